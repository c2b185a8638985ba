//! The 13 states by name, and as the vector that the integrator sees.

use crate::PlantError;

/// Number of states.
pub const STATES: usize = 13;

/// Number of states of the gas path and the rotor, without governor and fuel actuator.
pub const GAS_PATH_STATES: usize = 11;

/// The states of the plant: 11 of the gas path and the rotor, then governor and actuator.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct State {
    /// Angular speed of the shaft, rad/s.
    pub speed_rad_s: f64,
    /// Mass flow through the intake duct, kg/s (both legs).
    pub intake_flow_kg_s: f64,
    /// Pressure in the intake plenum (station 1), Pa.
    pub p1_pa: f64,
    /// Pressure at the compressor exit (station 3), Pa.
    pub p3_pa: f64,
    /// Mass flow from compressor to bleeds (station 4), kg/s.
    pub m4_kg_s: f64,
    /// Pressure at the combustor inlet (station 4), Pa.
    pub p4_pa: f64,
    /// Air flow into the combustor (station 5), kg/s.
    pub m5_kg_s: f64,
    /// Pressure at the combustor exit (station 5), Pa.
    pub p5_pa: f64,
    /// Pressure at the turbine exit (station 7), Pa.
    pub p7_pa: f64,
    /// Pressure in the exhaust duct behind the valve (station 8), Pa.
    pub p8_pa: f64,
    /// Mass flow out of the exhaust duct, kg/s.
    pub exhaust_flow_kg_s: f64,
    /// Integral of the speed error, rad.
    pub speed_error_integral_rad: f64,
    /// State of the fuel actuator, kg/s.
    pub actuator_fuel_kg_s: f64,
}

/// Name with unit, and the open interval in which the model means something.
///
/// The pressures of neighbouring stations keep their order by these intervals alone (p7 < p5);
/// the maps are no more than plausible far from the design point, so the intervals are wide
/// enough for any profile and fault of the project and still exclude nonsense.
const VALIDITY: [(&str, f64, f64); STATES] = [
    ("w_t [rad/s]", 800.0, 2200.0),
    ("intake flow [kg/s]", 2.0, 40.0),
    ("p1 [Pa]", 60e3, 160e3),
    ("p3 [Pa]", 400e3, 2.5e6),
    ("m4 [kg/s]", 1.0, 40.0),
    ("p4 [Pa]", 400e3, 2.5e6),
    ("m5 [kg/s]", 1.0, 40.0),
    ("p5 [Pa]", 400e3, 2.5e6),
    ("p7 [Pa]", 70e3, 400e3),
    ("p8 [Pa]", 60e3, 160e3),
    ("exhaust flow [kg/s]", 1.0, 40.0),
    ("integral of the speed error [rad]", -1e6, 1e6),
    ("fuel actuator [kg/s]", 0.0, 1.0),
];

impl State {
    /// The state as a vector, in the order of the fields.
    pub fn to_array(self) -> [f64; STATES] {
        [
            self.speed_rad_s,
            self.intake_flow_kg_s,
            self.p1_pa,
            self.p3_pa,
            self.m4_kg_s,
            self.p4_pa,
            self.m5_kg_s,
            self.p5_pa,
            self.p7_pa,
            self.p8_pa,
            self.exhaust_flow_kg_s,
            self.speed_error_integral_rad,
            self.actuator_fuel_kg_s,
        ]
    }

    /// The state from a vector, in the order of the fields.
    pub fn from_array(x: &[f64; STATES]) -> Self {
        let [w, mi, p1, p3, m4, p4, m5, p5, p7, p8, mex, integral, fuel] = *x;
        Self {
            speed_rad_s: w,
            intake_flow_kg_s: mi,
            p1_pa: p1,
            p3_pa: p3,
            m4_kg_s: m4,
            p4_pa: p4,
            m5_kg_s: m5,
            p5_pa: p5,
            p7_pa: p7,
            p8_pa: p8,
            exhaust_flow_kg_s: mex,
            speed_error_integral_rad: integral,
            actuator_fuel_kg_s: fuel,
        }
    }

    /// Refuses a state outside the model's range of validity, NaN included.
    ///
    /// # Errors
    /// [`PlantError::OutOfRange`] with the first quantity that left its interval.
    pub fn check(&self, time_s: f64) -> Result<(), PlantError> {
        for (found, (quantity, low, high)) in self.to_array().into_iter().zip(VALIDITY) {
            if !(low < found && found < high) {
                return Err(PlantError::OutOfRange {
                    time_s,
                    quantity,
                    low,
                    high,
                    found,
                });
            }
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn prop_names_and_vector_agree(x in proptest::array::uniform13(-1e6..1e6f64)) {
            let back = State::from_array(&x).to_array();
            prop_assert_eq!(back.map(f64::to_bits), x.map(f64::to_bits));
        }
    }
}
