//! Turbine maps.

use serde::{Deserialize, Serialize};

use super::range::{self, MapRange};
use super::{Extrapolation, MapEdge, MapExit, MapKind, SpeedLineTable};
use crate::real::Real;

/// A turbine map: flow function and efficiency.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case", deny_unknown_fields)]
pub enum TurbineMap {
    /// A law around the design point.
    Analytic(AnalyticTurbineMap),
    /// Speed lines from a file; flow as `m sqrt(T5) / p5` in kg sqrt(K) / (s Pa) over the expansion
    /// ratio p5 / p7.
    Table(SpeedLineTable),
}

/// An analytic turbine map: the flow of Stodola's ellipse, and an efficiency that falls with the
/// square of the velocity ratio's distance from its design value.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct AnalyticTurbineMap {
    /// Constant of the ellipse, kg sqrt(K) / (s Pa) (derived from Table 3).
    pub flow_constant: f64,
    /// Design isentropic efficiency `et0` (derived from Table 3).
    pub design_efficiency: f64,
    /// Design velocity ratio `w / sqrt(cp T5 s)`, rad/s per m/s, where s is the isentropic share of
    /// the temperature that is expanded (derived from Table 3).
    pub design_velocity_ratio: f64,
    /// Curvature of the efficiency over the velocity ratio (assumed).
    pub efficiency_curvature: f64,
    /// Where the law is believed (assumed).
    pub range: MapRange,
}

impl AnalyticTurbineMap {
    /// Flow function `m sqrt(T5) / p5`, kg sqrt(K) / (s Pa), at a pressure ratio p7 / p5.
    #[inline(always)]
    pub fn flow_function<R: Real>(&self, ratio: R) -> R {
        (-ratio.squared() + 1.0).sqrt() * self.flow_constant
    }

    /// Isentropic efficiency at a velocity ratio, rad/s per m/s.
    #[inline(always)]
    pub fn efficiency<R: Real>(&self, velocity_ratio: R) -> R {
        let off_design = velocity_ratio / self.design_velocity_ratio - 1.0;
        (-off_design.squared() * self.efficiency_curvature + 1.0) * self.design_efficiency
    }
}

impl TurbineMap {
    /// Flow function `m sqrt(T5) / p5`, kg sqrt(K) / (s Pa), at a corrected speed over its design
    /// value and a pressure ratio p7 / p5.
    #[inline(always)]
    pub fn flow_function<R: Real>(&self, speed: R, ratio: R) -> R {
        match self {
            Self::Analytic(map) => map.flow_function(ratio),
            Self::Table(table) => table.flow(speed, ratio.like(1.0) / ratio),
        }
    }

    /// How a point (corrected speed over design, expansion ratio p5 / p7) lies off the map, if it
    /// does.
    pub fn exit(&self, speed: f64, expansion_ratio: f64) -> Option<MapExit> {
        match self {
            Self::Analytic(map) => {
                let edges = [MapEdge::LowExpansion, MapEdge::HighExpansion];
                let MapRange {
                    speed: speeds,
                    load,
                } = map.range;
                range::exit(speed, speeds, expansion_ratio, load, edges)
            }
            Self::Table(table) => table.position(speed, expansion_ratio).exit(),
        }
    }

    /// Whose map it is; a table may be of the other kind until it is checked.
    pub fn kind(&self) -> MapKind {
        match self {
            Self::Analytic(_) => MapKind::Turbine,
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
