//! The shaft: one rotor with windage.

use serde::{Deserialize, Serialize};

use crate::real::Real;

/// The shaft that carries compressor and turbine, and in cogeneration the generator.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Shaft {
    /// Moment of inertia of compressor and turbine, kg m^2 (assumed; sets the rotor's time
    /// constant of 3.2 s).
    pub inertia_kg_m2: f64,
    /// Loss torque per squared speed, N m s^2 (assumed: 10 kW at design).
    pub loss_n_m_s2: f64,
}

impl Shaft {
    /// Angular acceleration, rad/s^2, with the inertia `extra_kg_m2` of what is coupled.
    #[inline(always)]
    pub fn acceleration<R: Real>(&self, net_n_m: R, speed_rad_s: R, extra_kg_m2: f64) -> R {
        (net_n_m - speed_rad_s.squared() * self.loss_n_m_s2) / (self.inertia_kg_m2 + extra_kg_m2)
    }
}
