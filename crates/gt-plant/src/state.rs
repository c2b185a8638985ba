//! The states by name, and as the vector that the integrator sees.

use std::f64::consts::FRAC_PI_2;

use crate::PlantError;
use crate::variant::Variant;

/// Number of states.
pub const STATES: usize = 18;

/// Number of states of the gas path and the rotor, without controllers and actuators.
pub const GAS_PATH_STATES: usize = 11;

/// The states of the plant: 11 of the gas path and the rotor, then actuators and controllers.
///
/// One set of states serves both variants. In the prototype the generator and the guide vanes rest
/// (the last four), in cogeneration the speed governor's integral does; [`Variant::states`] says
/// which take part.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct State<R = f64> {
    /// Angular speed of the shaft, rad/s.
    pub speed_rad_s: R,
    /// Mass flow through the intake duct, kg/s (both legs).
    pub intake_flow_kg_s: R,
    /// Pressure in the intake plenum (station 1), Pa.
    pub p1_pa: R,
    /// Pressure at the compressor exit (station 3), Pa.
    pub p3_pa: R,
    /// Mass flow from compressor to bleeds (station 4), kg/s.
    pub m4_kg_s: R,
    /// Pressure at the combustor inlet (station 4), Pa.
    pub p4_pa: R,
    /// Air flow into the combustor (station 5), kg/s.
    pub m5_kg_s: R,
    /// Pressure at the combustor exit (station 5), Pa.
    pub p5_pa: R,
    /// Pressure at the turbine exit (station 7), Pa.
    pub p7_pa: R,
    /// Pressure in the exhaust duct behind the valve (station 8), Pa.
    pub p8_pa: R,
    /// Mass flow out of the exhaust duct, kg/s.
    pub exhaust_flow_kg_s: R,
    /// State of the fuel actuator, kg/s.
    pub fuel_actuator_kg_s: R,
    /// State of the valve's actuator, degrees.
    pub valve_actuator_deg: R,
    /// Integral of the speed error, rad.
    pub speed_error_integral_rad: R,
    /// Load angle of the generator, electrical radians.
    pub load_angle_rad: R,
    /// Reading of the thermocouple that the guide vanes' controller sees, K.
    pub exhaust_reading_k: R,
    /// Integral of the exhaust temperature's error, K s.
    pub exhaust_error_integral_k_s: R,
    /// Angle of the guide vanes, degrees from open.
    pub guide_vane_deg: R,
}

/// Name with unit, and the open interval in which the model means something.
///
/// The pressures of neighbouring stations keep their order by these intervals alone (p7 < p5);
/// the maps are no more than plausible far from the design point, so the intervals are wide
/// enough for any profile and fault of the project and still exclude nonsense. Where a map is left,
/// a run warns.
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
    ("fuel actuator [kg/s]", 0.0, 1.0),
    ("valve actuator [deg]", 1.0, 179.0),
    ("integral of the speed error [rad]", -1e6, 1e6),
    // Beyond a right angle a synchronous machine falls out of step.
    ("load angle [rad]", -FRAC_PI_2, FRAC_PI_2),
    ("reading of the exhaust temperature [K]", 200.0, 2000.0),
    ("integral of the exhaust error [K s]", -1e7, 1e7),
    ("guide vanes [deg]", -1.0, 90.0),
];

/// Names of the states, in the order of [`State`].
const NAMES: [&str; STATES] = [
    "w_t",
    "m_in",
    "p1",
    "p3",
    "m4",
    "p4",
    "m5",
    "p5",
    "p7",
    "p8",
    "m_ex",
    "fuel_actuator",
    "valve_actuator",
    "speed_error_integral",
    "load_angle",
    "exhaust_reading",
    "exhaust_error_integral",
    "guide_vanes",
];

impl<R: Copy> State<R> {
    /// The state as a vector, in the order of the fields.
    #[inline(always)]
    pub fn to_array(self) -> [R; STATES] {
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
            self.fuel_actuator_kg_s,
            self.valve_actuator_deg,
            self.speed_error_integral_rad,
            self.load_angle_rad,
            self.exhaust_reading_k,
            self.exhaust_error_integral_k_s,
            self.guide_vane_deg,
        ]
    }

    /// The state from a vector, in the order of the fields.
    #[inline(always)]
    pub fn from_array(x: &[R; STATES]) -> Self {
        Self {
            speed_rad_s: x[0],
            intake_flow_kg_s: x[1],
            p1_pa: x[2],
            p3_pa: x[3],
            m4_kg_s: x[4],
            p4_pa: x[5],
            m5_kg_s: x[6],
            p5_pa: x[7],
            p7_pa: x[8],
            p8_pa: x[9],
            exhaust_flow_kg_s: x[10],
            fuel_actuator_kg_s: x[11],
            valve_actuator_deg: x[12],
            speed_error_integral_rad: x[13],
            load_angle_rad: x[14],
            exhaust_reading_k: x[15],
            exhaust_error_integral_k_s: x[16],
            guide_vane_deg: x[17],
        }
    }
}

impl State {
    /// Refuses a state outside the model's range of validity, NaN included.
    ///
    /// # Errors
    /// [`PlantError::OutOfRange`] with the first quantity that left its interval.
    pub fn check(&self, time_s: f64) -> Result<(), PlantError> {
        let mut values = self.to_array().into_iter().zip(VALIDITY);
        values.try_for_each(|(found, range)| within(range, found, time_s))
    }
}

/// Refuses a value outside an open interval, NaN included.
pub(crate) fn within(
    (quantity, low, high): (&'static str, f64, f64),
    found: f64,
    time_s: f64,
) -> Result<(), PlantError> {
    if low < found && found < high {
        return Ok(());
    }
    Err(PlantError::OutOfRange {
        time_s,
        quantity,
        low,
        high,
        found,
    })
}

impl Variant {
    /// Which states take part in a variant's dynamics: index and name.
    pub fn states(self) -> Vec<(usize, &'static str)> {
        let rests = |index: &usize| match self {
            Self::Prototype => *index >= 14,
            Self::Cogeneration => *index == 13,
        };
        (0..STATES)
            .filter(|index| !rests(index))
            .map(|index| (index, NAMES[index]))
            .collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn prop_names_and_vector_agree(
            x in proptest::collection::vec(-1e6..1e6f64, STATES).prop_map(|x| {
                let x: [f64; STATES] = x.try_into().unwrap();
                x
            })
        ) {
            let back = State::from_array(&x).to_array();
            prop_assert_eq!(back.map(f64::to_bits), x.map(f64::to_bits));
        }
    }

    #[test]
    fn resting_states_are_those_of_the_other_variant() {
        let names = |variant: Variant| {
            let mut names: Vec<_> = variant.states().into_iter().map(|(_, name)| name).collect();
            names.drain(..13);
            names
        };
        assert_eq!(names(Variant::Prototype), ["speed_error_integral"]);
        assert_eq!(
            names(Variant::Cogeneration),
            [
                "load_angle",
                "exhaust_reading",
                "exhaust_error_integral",
                "guide_vanes"
            ]
        );
    }
}
