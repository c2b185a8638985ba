//! The turbine: a map of flow and efficiency, and the expansion along it.

use serde::{Deserialize, Serialize};

use crate::gas::{GAS_CONSTANT_J_KG_K, Gas};
use crate::maps::TurbineMap;
use crate::real::Real;

/// Mean heat capacity from which the exit temperature is iterated, J/(kg K).
const START_HEAT_CAPACITY: f64 = 1168.0;
/// Evaluations of the exit temperature.
const PASSES: usize = 3;

/// The turbine, cooled by m6 upstream and m10 downstream of its blades.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Turbine {
    /// Design value of `w / sqrt T5`, rad/(s sqrt K) (derived from Table 3).
    pub design_corrected_speed: f64,
    /// Its map.
    pub map: TurbineMap,
}

/// What the turbine does at one operating point.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Expansion<R = f64> {
    /// Mass flow m8, kg/s.
    pub flow_kg_s: R,
    /// Temperature behind the blades, K (before the cooling air mixes in).
    pub exit_k: R,
    /// Isentropic efficiency `e_t`.
    pub efficiency: R,
    /// Power `P_t`, W.
    pub power_w: R,
    /// Corrected speed over its design value.
    pub map_speed: R,
    /// Expansion ratio p5 / p7.
    pub expansion_ratio: R,
}

impl Turbine {
    /// The operating point at inlet `(p5, T5)`, exit pressure p7 and speed, where damage takes
    /// the share `efficiency_loss` of the efficiency (fault case 3).
    #[inline(always)]
    pub fn expand<R: Real>(
        &self,
        gas: &Gas<R>,
        [inlet_pa, inlet_k]: [R; 2],
        exit_pa: R,
        speed_rad_s: R,
        efficiency_loss: R,
    ) -> Expansion<R> {
        let root_k = inlet_k.sqrt();
        let map_speed = speed_rad_s / root_k / self.design_corrected_speed;
        let ratio = exit_pa / inlet_pa;
        let flow_function = self.map.flow_function(map_speed, ratio);
        let flow_kg_s = flow_function * inlet_pa / root_k;
        let log_ratio = ratio.ln() * GAS_CONSTANT_J_KG_K;
        let mut mean_cp = inlet_k.like(START_HEAT_CAPACITY);
        let mut exit_k = inlet_k;
        let mut efficiency = inlet_k;
        let kept = -efficiency_loss + 1.0;
        let tabulated = match &self.map {
            TurbineMap::Analytic(_) => inlet_k,
            TurbineMap::Table(table) => table.efficiency(map_speed, inlet_pa / exit_pa),
        };
        for _ in 0..PASSES {
            let share = -(log_ratio / mean_cp).exp_m1();
            efficiency = match &self.map {
                TurbineMap::Analytic(map) => {
                    map.efficiency(speed_rad_s / (mean_cp * inlet_k * share).sqrt())
                }
                TurbineMap::Table(_) => tabulated,
            } * kept;
            exit_k = inlet_k * (-efficiency * share + 1.0);
            mean_cp = gas.mean_heat_capacity(exit_k, inlet_k);
        }
        let power_w = flow_kg_s * mean_cp * (inlet_k - exit_k);
        Expansion {
            flow_kg_s,
            exit_k,
            efficiency,
            power_w,
            map_speed,
            expansion_ratio: inlet_pa / exit_pa,
        }
    }
}
