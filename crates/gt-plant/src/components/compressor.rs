//! The compressor: a map of flow and efficiency around the design point.

use serde::{Deserialize, Serialize};

use crate::gas::{GAS_CONSTANT_J_KG_K, Gas};

/// Standard pressure of the corrected mass flow, Pa.
const STANDARD_PRESSURE_PA: f64 = 101325.0;
/// Standard temperature of the corrected mass flow, K.
const STANDARD_TEMPERATURE_K: f64 = 288.15;
/// Mean heat capacity from which the exit temperature is iterated, J/(kg K).
const START_HEAT_CAPACITY: f64 = 1020.0;
/// Evaluations of the exit temperature: a start and two corrections of the mean heat capacity.
const PASSES: usize = 3;

/// The compressor map.
///
/// With `n = (w / sqrt T2) / (its design value)` the speed line's design pressure ratio is
/// `1 + (PR0 - 1) n^aPR` and `phi = (PR - 1) / (that ratio - 1)`; corrected flow is
/// `mcor n^am (1 + s0 (1 - phi^2))`, efficiency
/// `ec0 (1 - speed_curvature (n - 1)^2 - pressure_curvature (phi - 1)^2)`.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Compressor {
    /// Corrected design mass flow `mcor`, kg/s (derived from Table 3).
    pub design_flow_kg_s: f64,
    /// Design pressure ratio `PR0` (derived from Table 3).
    pub design_pressure_ratio: f64,
    /// Design value of `w / sqrt T2`, rad/(s sqrt K) (derived from Table 3).
    pub design_corrected_speed: f64,
    /// Design isentropic efficiency `ec0` (derived from Table 3 with real heat capacities).
    pub design_efficiency: f64,
    /// Exponent `aPR` of speed in the pressure ratio (assumed; the map set).
    pub pressure_exponent: f64,
    /// Exponent `am` of speed in the mass flow (assumed; the map set).
    pub flow_exponent: f64,
    /// Slope `s0` of the speed lines at design (assumed; the map set).
    pub line_slope: f64,
    /// Curvature of the efficiency over speed (assumed).
    pub efficiency_speed_curvature: f64,
    /// Curvature of the efficiency over pressure ratio (assumed).
    pub efficiency_pressure_curvature: f64,
    /// `t4 / t3`, heat lost behind the compressor (derived from Table 3).
    pub exit_temperature_ratio: f64,
}

/// What the compressor does at one operating point.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Compression {
    /// Mass flow m3, kg/s.
    pub flow_kg_s: f64,
    /// Exit temperature t3, K.
    pub exit_k: f64,
    /// Isentropic efficiency `e_c`.
    pub efficiency: f64,
    /// Power `P_c`, W.
    pub power_w: f64,
}

impl Compressor {
    /// The operating point at inlet `(p2, T2)`, exit pressure p3 and speed, where fouling takes
    /// the share `flow_loss` of the mass flow at given pressure ratio (fault case 1).
    pub fn compress(
        &self,
        [inlet_pa, inlet_k]: [f64; 2],
        exit_pa: f64,
        speed_rad_s: f64,
        flow_loss: f64,
    ) -> Compression {
        let n = speed_rad_s / inlet_k.sqrt() / self.design_corrected_speed;
        let log_n = n.ln();
        let pressure_ratio = exit_pa / inlet_pa;
        let line_rise = (self.design_pressure_ratio - 1.0) * (self.pressure_exponent * log_n).exp();
        let phi = (pressure_ratio - 1.0) / line_rise;
        let corrected_kg_s = self.design_flow_kg_s
            * (self.flow_exponent * log_n).exp()
            * (1.0 + self.line_slope * (1.0 - phi * phi));
        let flow_kg_s = (1.0 - flow_loss) * corrected_kg_s * (inlet_pa / STANDARD_PRESSURE_PA)
            / (inlet_k / STANDARD_TEMPERATURE_K).sqrt();
        let efficiency = self.design_efficiency
            * (1.0
                - self.efficiency_speed_curvature * (n - 1.0) * (n - 1.0)
                - self.efficiency_pressure_curvature * (phi - 1.0) * (phi - 1.0));
        let log_ratio = GAS_CONSTANT_J_KG_K * pressure_ratio.ln();
        let mut mean_cp = START_HEAT_CAPACITY;
        let mut exit_k = inlet_k;
        for _ in 0..PASSES {
            exit_k = inlet_k * (1.0 + (log_ratio / mean_cp).exp_m1() / efficiency);
            mean_cp = Gas::AIR.mean_heat_capacity(inlet_k, exit_k);
        }
        let power_w = flow_kg_s * mean_cp * (exit_k - inlet_k);
        Compression {
            flow_kg_s,
            exit_k,
            efficiency,
            power_w,
        }
    }
}
