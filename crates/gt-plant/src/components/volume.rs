//! A volume in which gas is stored.

use serde::{Deserialize, Serialize};

use crate::gas::GAS_CONSTANT_J_KG_K;

/// A volume with isentropic change of density.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Volume {
    /// Volume, m^3.
    pub volume_m3: f64,
}

impl Volume {
    /// Rate of change of the pressure, Pa/s: `gamma R T / V` times the net inflow.
    pub fn pressure_rate(&self, gamma: f64, temperature_k: f64, net_inflow_kg_s: f64) -> f64 {
        gamma * GAS_CONSTANT_J_KG_K * temperature_k / self.volume_m3 * net_inflow_kg_s
    }
}
