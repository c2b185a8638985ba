//! The intake: fan and filter legs, a plenum, and the inlet of the compressor.

use serde::{Deserialize, Serialize};

use super::duct::Duct;
use super::volume::Volume;
use crate::real::Real;

/// Intake duct, plenum (station 1) and compressor inlet (station 2).
///
/// Table 3 has `p1 > p_a`, which needs a fan in front of the filters, and `t1 > T_a`, `t2 < t1`,
/// which no adiabatic duct gives; head and factors reproduce the table and have no other source.
/// The table's m1 is a little less than half of the compressor's flow: it is read as one of two
/// parallel filter legs, with the share of the flow that the table says.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Intake {
    /// Both legs together, from ambient to plenum (inertance and filter loss assumed, head of the
    /// fan derived from Table 3).
    pub duct: Duct,
    /// Share of the flow that passes the leg in which m1 is measured (derived from Table 3).
    pub measured_leg_share: f64,
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
    #[inline(always)]
    pub fn plenum_temperature_k<R: Real>(&self, ambient_k: R) -> R {
        ambient_k * self.plenum_temperature_ratio
    }

    /// Temperature at the compressor inlet, K.
    #[inline(always)]
    pub fn inlet_temperature_k<R: Real>(&self, plenum_k: R) -> R {
        plenum_k * self.inlet_temperature_ratio
    }

    /// Pressure at the compressor inlet, Pa.
    #[inline(always)]
    pub fn inlet_pressure_pa<R: Real>(&self, plenum_pa: R, flow_kg_s: R) -> R {
        plenum_pa - flow_kg_s.squared() * self.inlet_loss_pa_s2_kg2
    }
}
