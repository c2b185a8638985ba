//! The turbine: Stodola's ellipse and an efficiency over the velocity ratio.

use serde::{Deserialize, Serialize};

use crate::gas::{GAS_CONSTANT_J_KG_K, Gas};

/// Mean heat capacity from which the exit temperature is iterated, J/(kg K).
const START_HEAT_CAPACITY: f64 = 1168.0;
/// Evaluations of the exit temperature.
const PASSES: usize = 3;

/// The turbine.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Turbine {
    /// Constant of the ellipse, kg sqrt(K) / (s Pa) (derived from Table 3).
    pub flow_constant: f64,
    /// Design isentropic efficiency `et0` (derived from Table 3).
    pub design_efficiency: f64,
    /// Design velocity ratio `w / sqrt(cp T5 s)`, rad/s per m/s (derived from Table 3).
    pub design_velocity_ratio: f64,
    /// Curvature of the efficiency over the velocity ratio (assumed).
    pub efficiency_curvature: f64,
}

/// What the turbine does at one operating point.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Expansion {
    /// Mass flow m8, kg/s.
    pub flow_kg_s: f64,
    /// Temperature behind the blades, K (before the cooling air mixes in).
    pub exit_k: f64,
    /// Isentropic efficiency `e_t`.
    pub efficiency: f64,
    /// Power `P_t`, W.
    pub power_w: f64,
}

impl Turbine {
    /// The operating point at inlet `(p5, T5)`, exit pressure p7 and speed, where damage takes
    /// the share `efficiency_loss` of the efficiency (fault case 3).
    pub fn expand(
        &self,
        gas: &Gas,
        [inlet_pa, inlet_k]: [f64; 2],
        exit_pa: f64,
        speed_rad_s: f64,
        efficiency_loss: f64,
    ) -> Expansion {
        let ratio = exit_pa / inlet_pa;
        let flow_kg_s =
            self.flow_constant * inlet_pa / inlet_k.sqrt() * (1.0 - ratio * ratio).sqrt();
        let log_ratio = GAS_CONSTANT_J_KG_K * ratio.ln();
        let mut mean_cp = START_HEAT_CAPACITY;
        let mut exit_k = inlet_k;
        let mut efficiency = self.design_efficiency;
        for _ in 0..PASSES {
            let share = -(log_ratio / mean_cp).exp_m1();
            let velocity_ratio =
                speed_rad_s / (mean_cp * inlet_k * share).sqrt() / self.design_velocity_ratio;
            let off_design = velocity_ratio - 1.0;
            efficiency = self.design_efficiency
                * (1.0 - self.efficiency_curvature * off_design * off_design)
                * (1.0 - efficiency_loss);
            exit_k = inlet_k * (1.0 - efficiency * share);
            mean_cp = gas.mean_heat_capacity(exit_k, inlet_k);
        }
        let power_w = flow_kg_s * mean_cp * (inlet_k - exit_k);
        Expansion {
            flow_kg_s,
            exit_k,
            efficiency,
            power_w,
        }
    }
}
