//! The intake: fan and filter, a plenum, and the inlet of the compressor.

use serde::{Deserialize, Serialize};

use super::duct::Duct;
use super::volume::Volume;

/// Intake duct, plenum (station 1) and compressor inlet (station 2).
///
/// Table 3 has `t1 > T_a` and `t2 < t1`, which no adiabatic duct gives, and `p1 > p_a`, which
/// needs a fan; factors and head reproduce the table and have no other source.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Intake {
    /// Duct from ambient to plenum (inertance and loss assumed, head derived from Table 3).
    pub duct: Duct,
    /// Plenum volume (assumed).
    pub plenum: Volume,
    /// `t1 / T_a` (derived from Table 3).
    pub plenum_temperature_ratio: f64,
    /// `t2 / t1` (derived from Table 3).
    pub inlet_temperature_ratio: f64,
    /// Loss from plenum to compressor inlet, Pa s^2/kg^2 (derived from Table 3).
    pub inlet_loss_pa_s2_kg2: f64,
}

impl Intake {
    /// Temperature in the plenum, K.
    pub fn plenum_temperature_k(&self, ambient_k: f64) -> f64 {
        self.plenum_temperature_ratio * ambient_k
    }

    /// Temperature at the compressor inlet, K.
    pub fn inlet_temperature_k(&self, plenum_k: f64) -> f64 {
        self.inlet_temperature_ratio * plenum_k
    }

    /// Pressure at the compressor inlet, Pa.
    pub fn inlet_pressure_pa(&self, plenum_pa: f64, flow_kg_s: f64) -> f64 {
        plenum_pa - self.inlet_loss_pa_s2_kg2 * flow_kg_s * flow_kg_s
    }
}
