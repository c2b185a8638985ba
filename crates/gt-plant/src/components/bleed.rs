//! A bleed: cooling air through a fixed, choked orifice.

use serde::{Deserialize, Serialize};

use crate::real::Real;

/// A bleed with a constant flow function, without dynamics (paper, section 3.1).
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Bleed {
    /// Flow function, kg sqrt(K) / (s Pa) (derived from the reconciled flows of Table 3).
    pub flow_function: f64,
}

impl Bleed {
    /// Mass flow, kg/s, for the square root of the inlet temperature.
    #[inline(always)]
    pub fn flow_kg_s<R: Real>(&self, inlet_pa: R, root_inlet_k: R) -> R {
        inlet_pa * self.flow_function / root_inlet_k
    }
}
