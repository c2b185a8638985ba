//! A volume in which gas is stored.

use serde::{Deserialize, Serialize};

use crate::gas::GAS_CONSTANT_J_KG_K;
use crate::real::Real;

/// A volume with isentropic change of density (paper, section 3.1).
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Volume {
    /// Volume, m^3.
    pub volume_m3: f64,
}

impl Volume {
    /// Rate of change of the pressure, Pa/s: `gamma R T / V` times the net inflow.
    #[inline(always)]
    pub fn pressure_rate<R: Real>(&self, gamma: R, temperature_k: R, net_inflow_kg_s: R) -> R {
        gamma * temperature_k * net_inflow_kg_s * (GAS_CONSTANT_J_KG_K / self.volume_m3)
    }
}
