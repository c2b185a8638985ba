//! The shaft: one rotor with windage.

use serde::{Deserialize, Serialize};

/// The shaft that carries compressor and turbine.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Shaft {
    /// Moment of inertia, kg m^2 (assumed; sets the rotor's time constant of 3.2 s).
    pub inertia_kg_m2: f64,
    /// Loss torque per squared speed, N m s^2 (assumed: 20 kW at design).
    pub loss_n_m_s2: f64,
}

impl Shaft {
    /// Angular acceleration, rad/s^2.
    pub fn acceleration(&self, driving_n_m: f64, braking_n_m: f64, speed_rad_s: f64) -> f64 {
        (driving_n_m - braking_n_m - self.loss_n_m_s2 * speed_rad_s * speed_rad_s)
            / self.inertia_kg_m2
    }
}
