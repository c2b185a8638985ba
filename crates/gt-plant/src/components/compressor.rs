//! The compressor: a map of flow and efficiency, and the compression along it.

use serde::{Deserialize, Serialize};

use super::guide_vanes::VaneEffect;
use crate::gas::{GAS_CONSTANT_J_KG_K, air};
use crate::maps::CompressorMap;
use crate::real::Real;

/// Standard pressure of the corrected mass flow, Pa.
pub(crate) const STANDARD_PRESSURE_PA: f64 = 101325.0;
/// Standard temperature of the corrected mass flow, K.
pub(crate) const STANDARD_TEMPERATURE_K: f64 = 288.15;
/// Mean heat capacity from which the exit temperature is iterated, J/(kg K).
const START_HEAT_CAPACITY: f64 = 1020.0;
/// Evaluations of the exit temperature: a start and two corrections of the mean heat capacity.
const PASSES: usize = 3;

/// The compressor.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Compressor {
    /// Design value of `w / sqrt T2`, rad/(s sqrt K) (derived from Table 3).
    pub design_corrected_speed: f64,
    /// Its map.
    pub map: CompressorMap,
    /// `t4 / t3`, heat lost behind the compressor (derived from Table 3).
    pub exit_temperature_ratio: f64,
}

/// What the compressor does at one operating point.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Compression<R = f64> {
    /// Mass flow m3, kg/s.
    pub flow_kg_s: R,
    /// Exit temperature t3, K.
    pub exit_k: R,
    /// Isentropic efficiency from inlet to exit, the map's.
    pub efficiency: R,
    /// Power `P_c`, W.
    pub power_w: R,
    /// Corrected speed over its design value, where the map was read.
    pub map_speed: R,
    /// Pressure ratio at which the map was read (that of the machine with open guide vanes).
    pub map_pressure_ratio: R,
}

impl Compressor {
    /// The operating point at inlet `(p2, T2)`, exit pressure p3 and speed, where fouling takes
    /// the share `flow_loss` of the mass flow at given pressure ratio (fault case 1).
    ///
    /// Guide vanes scale the map's speed lines: flow, pressure rise and efficiency.
    #[inline(always)]
    pub fn compress<R: Real>(
        &self,
        [inlet_pa, inlet_k]: [R; 2],
        exit_pa: R,
        speed_rad_s: R,
        flow_loss: R,
        vanes: &VaneEffect<R>,
    ) -> Compression<R> {
        let root_k = inlet_k.sqrt();
        let map_speed = speed_rad_s / root_k / self.design_corrected_speed;
        let pressure_ratio = exit_pa / inlet_pa;
        let map_pressure_ratio = (pressure_ratio - 1.0) / vanes.pressure_rise + 1.0;
        let [corrected_kg_s, map_efficiency] = self.map.evaluate(map_speed, map_pressure_ratio);
        let flow_kg_s = (-flow_loss + 1.0) * corrected_kg_s * vanes.flow * inlet_pa / root_k
            * (STANDARD_TEMPERATURE_K.sqrt() / STANDARD_PRESSURE_PA);
        let efficiency = map_efficiency * vanes.efficiency;
        let log_ratio = pressure_ratio.ln() * GAS_CONSTANT_J_KG_K;
        let mut mean_cp = inlet_k.like(START_HEAT_CAPACITY);
        let mut exit_k = inlet_k;
        for _ in 0..PASSES {
            exit_k = inlet_k * ((log_ratio / mean_cp).exp_m1() / efficiency + 1.0);
            mean_cp = air::mean_heat_capacity(inlet_k, exit_k);
        }
        let power_w = flow_kg_s * mean_cp * (exit_k - inlet_k);
        Compression {
            flow_kg_s,
            exit_k,
            efficiency,
            power_w,
            map_speed,
            map_pressure_ratio,
        }
    }
}
