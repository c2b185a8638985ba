//! A duct: momentum of a gas column with a quadratic loss and a constant head.

use serde::{Deserialize, Serialize};

use crate::real::Real;

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
    #[inline(always)]
    pub fn flow_rate<R: Real>(&self, inlet_pa: R, outlet_pa: R, flow_kg_s: R) -> R {
        let loss_pa = flow_kg_s * flow_kg_s.abs() * self.loss_pa_s2_kg2;
        (inlet_pa - outlet_pa - loss_pa + self.head_pa) / self.inertance_per_m
    }
}
