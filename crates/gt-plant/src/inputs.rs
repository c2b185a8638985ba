//! What acts on the plant from outside.

use crate::PlantParameters;
use crate::drive::Deviation;
use crate::real::Real;

/// What acts on the plant from outside, constant over a sample.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Inputs<R = f64> {
    /// Demanded opening angle of the valve, degrees.
    pub valve_deg: R,
    /// Speed reference of the governor (prototype) or speed of the grid (cogeneration), rad/s of
    /// the turbine's shaft.
    pub speed_reference_rad_s: R,
    /// Added to the fuel demand, kg/s: to what the governor asks for (prototype), to the design
    /// flow (cogeneration).
    pub fuel_offset_kg_s: R,
    /// Ambient pressure, Pa.
    pub ambient_pa: R,
    /// Ambient temperature, K.
    pub ambient_k: R,
    /// Lower heating value, J/kg.
    pub heating_value_j_kg: R,
    /// Disturbance of the heat release, share of what the fuel gives.
    pub heat_release_fraction: R,
    /// Disturbing torque on the shaft, N m; positive accelerates.
    pub torque_n_m: R,
}

impl Inputs {
    /// The inputs of the design point.
    pub fn design(parameters: &PlantParameters) -> Self {
        Self {
            valve_deg: parameters.design.valve_deg,
            speed_reference_rad_s: parameters.design.speed_rad_s,
            fuel_offset_kg_s: 0.0,
            ambient_pa: parameters.design.ambient_pa,
            ambient_k: parameters.design.ambient_k,
            heating_value_j_kg: parameters.design.heating_value_j_kg,
            heat_release_fraction: 0.0,
            torque_n_m: 0.0,
        }
    }

    /// The inputs at a deviation from the design point.
    pub fn driven(parameters: &PlantParameters, deviation: &Deviation) -> Self {
        let design = Self::design(parameters);
        let fuel = deviation.fuel_fraction + deviation.dither_fraction;
        Self {
            valve_deg: design.valve_deg + deviation.valve_deg,
            speed_reference_rad_s: design.speed_reference_rad_s * (1.0 + deviation.speed_fraction),
            fuel_offset_kg_s: parameters.governor.design_fuel_kg_s * fuel,
            ambient_pa: design.ambient_pa + deviation.ambient_pa,
            ambient_k: design.ambient_k + deviation.ambient_k,
            heating_value_j_kg: design.heating_value_j_kg
                * (1.0 + deviation.heating_value_fraction),
            heat_release_fraction: deviation.heat_release_fraction,
            torque_n_m: deviation.torque_n_m,
        }
    }
}

impl<R: Copy> Inputs<R> {
    /// Every input through `function`, for example into another kind of number.
    #[inline(always)]
    pub fn map<Q>(&self, mut function: impl FnMut(R) -> Q) -> Inputs<Q> {
        Inputs {
            valve_deg: function(self.valve_deg),
            speed_reference_rad_s: function(self.speed_reference_rad_s),
            fuel_offset_kg_s: function(self.fuel_offset_kg_s),
            ambient_pa: function(self.ambient_pa),
            ambient_k: function(self.ambient_k),
            heating_value_j_kg: function(self.heating_value_j_kg),
            heat_release_fraction: function(self.heat_release_fraction),
            torque_n_m: function(self.torque_n_m),
        }
    }
}

impl Inputs {
    /// The same inputs as numbers of the kind of `kind`.
    #[inline(always)]
    pub fn like<R: Real>(&self, kind: R) -> Inputs<R> {
        self.map(|value| kind.like(value))
    }
}
