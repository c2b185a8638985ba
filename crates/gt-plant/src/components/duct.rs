//! A duct: momentum of a gas column with a quadratic loss and a constant head.

use serde::{Deserialize, Serialize};

/// A duct between two pressures.
///
/// Draught and fans are a constant head over a positive loss: a negative loss that would give
/// the same steady state makes the duct unstable.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Duct {
    /// Inertance L/A, 1/m.
    pub inertance_per_m: f64,
    /// Loss coefficient: pressure drop per squared mass flow, Pa s^2/kg^2.
    pub loss_pa_s2_kg2: f64,
    /// Constant head of a fan or of draught, Pa.
    pub head_pa: f64,
}

impl Duct {
    /// Rate of change of the mass flow, kg/s^2.
    pub fn flow_rate(&self, inlet_pa: f64, outlet_pa: f64, flow_kg_s: f64) -> f64 {
        let loss_pa = self.loss_pa_s2_kg2 * flow_kg_s * flow_kg_s.abs();
        (inlet_pa + self.head_pa - outlet_pa - loss_pa) / self.inertance_per_m
    }
}
