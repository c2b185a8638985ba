//! Compressor maps.

use serde::{Deserialize, Serialize};

use super::range::{self, MapRange};
use super::{Extrapolation, MapEdge, MapExit, MapKind, SpeedLineTable};
use crate::real::Real;

/// A compressor map: corrected flow and efficiency over corrected speed and pressure ratio.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case", deny_unknown_fields)]
pub enum CompressorMap {
    /// A law around the design point.
    Analytic(AnalyticCompressorMap),
    /// Speed lines from a file; flow in kg/s at 101325 Pa and 288.15 K.
    Table(SpeedLineTable),
}

/// An analytic compressor map.
///
/// With n the corrected speed over its design value, a speed line's design pressure ratio is
/// `1 + (PR0 - 1) n^aPR` and its load `phi = (PR - 1) / (that ratio - 1)`; corrected flow is
/// `mcor n^am (1 + s0 (1 - phi^2))`, efficiency
/// `ec0 (1 - speed_curvature (n - 1)^2 - pressure_curvature (phi - 1)^2)`.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct AnalyticCompressorMap {
    /// Corrected design mass flow `mcor`, kg/s at 101325 Pa and 288.15 K (derived from Table 3).
    pub design_flow_kg_s: f64,
    /// Design pressure ratio `PR0` (derived from Table 3).
    pub design_pressure_ratio: f64,
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
    /// Where the law is believed: choke below, surge above (assumed).
    pub range: MapRange,
}

impl AnalyticCompressorMap {
    /// Pressure rise of a speed line's design point, `PR - 1`.
    #[inline(always)]
    fn line_rise<R: Real>(&self, log_speed: R) -> R {
        (log_speed * self.pressure_exponent).exp() * (self.design_pressure_ratio - 1.0)
    }

    /// Corrected flow, kg/s, and isentropic efficiency.
    #[inline(always)]
    pub fn evaluate<R: Real>(&self, speed: R, pressure_ratio: R) -> [R; 2] {
        let log_speed = speed.ln();
        let load = (pressure_ratio - 1.0) / self.line_rise(log_speed);
        let slope = (-load.squared() + 1.0) * self.line_slope + 1.0;
        let flow = (log_speed * self.flow_exponent).exp() * slope * self.design_flow_kg_s;
        let off_speed = (speed - 1.0).squared() * self.efficiency_speed_curvature;
        let off_load = (load - 1.0).squared() * self.efficiency_pressure_curvature;
        [flow, (-off_speed - off_load + 1.0) * self.design_efficiency]
    }
}

impl CompressorMap {
    /// Corrected flow, kg/s at 101325 Pa and 288.15 K, and isentropic efficiency at a corrected
    /// speed over its design value and a pressure ratio.
    #[inline(always)]
    pub fn evaluate<R: Real>(&self, speed: R, pressure_ratio: R) -> [R; 2] {
        match self {
            Self::Analytic(map) => map.evaluate(speed, pressure_ratio),
            Self::Table(table) => table.flow_and_efficiency(speed, pressure_ratio),
        }
    }

    /// How a point (corrected speed over design, pressure ratio) lies off the map, if it does.
    pub fn exit(&self, speed: f64, pressure_ratio: f64) -> Option<MapExit> {
        match self {
            Self::Analytic(map) => {
                let rise = map.line_rise(speed.ln());
                let ratios = map.range.load.map(|load| 1.0 + load * rise);
                let edges = [MapEdge::ChokeSide, MapEdge::SurgeSide];
                range::exit(speed, map.range.speed, pressure_ratio, ratios, edges)
            }
            Self::Table(table) => table.position(speed, pressure_ratio).exit(),
        }
    }

    /// Whose map it is; a table may be of the other kind until it is checked.
    pub fn kind(&self) -> MapKind {
        match self {
            Self::Analytic(_) => MapKind::Compressor,
            Self::Table(table) => table.kind(),
        }
    }

    /// What happens off the map; an analytic map goes on, and the run says so.
    pub fn extrapolation(&self) -> Extrapolation {
        match self {
            Self::Analytic(_) => Extrapolation::Flag,
            Self::Table(table) => table.extrapolation(),
        }
    }
}
