//! A bleed: cooling air through a fixed, choked orifice.

use serde::{Deserialize, Serialize};

/// A bleed with a constant flow function.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Bleed {
    /// Flow function, kg sqrt(K) / (s Pa) (derived from the reconciled flows of Table 3).
    pub flow_function: f64,
}

impl Bleed {
    /// Mass flow, kg/s, for the square root of the inlet temperature.
    pub fn flow_kg_s(&self, inlet_pa: f64, root_inlet_k: f64) -> f64 {
        self.flow_function * inlet_pa / root_inlet_k
    }
}
