//! Whether an operating point lies on a map.

use std::fmt;

use serde::{Deserialize, Serialize};

/// An edge of a map.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum MapEdge {
    /// The line of the lowest speed.
    SlowestLine,
    /// The line of the highest speed.
    FastestLine,
    /// A compressor's points of lowest pressure ratio.
    ChokeSide,
    /// A compressor's points of highest pressure ratio.
    SurgeSide,
    /// A turbine's points of lowest expansion ratio.
    LowExpansion,
    /// A turbine's points of highest expansion ratio.
    HighExpansion,
}

impl MapEdge {
    /// What lies across this edge: `"speed"` or `"pressure ratio"`.
    pub fn coordinate(self) -> &'static str {
        match self {
            Self::SlowestLine | Self::FastestLine => "speed",
            Self::ChokeSide | Self::SurgeSide | Self::LowExpansion | Self::HighExpansion => {
                "pressure ratio"
            }
        }
    }
}

impl fmt::Display for MapEdge {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        formatter.pad(match self {
            Self::SlowestLine => "slowest line",
            Self::FastestLine => "fastest line",
            Self::ChokeSide => "choke side",
            Self::SurgeSide => "surge side",
            Self::LowExpansion => "side of low expansion",
            Self::HighExpansion => "side of high expansion",
        })
    }
}

/// How an operating point left a map.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct MapExit {
    /// Over which edge; over one of speed where both coordinates lie outside.
    pub edge: MapEdge,
    /// Lower end of the map in the edge's coordinate (the pressure ratio's at the point's speed).
    pub low: f64,
    /// Upper end of the map in that coordinate.
    pub high: f64,
    /// The point's coordinate.
    pub value: f64,
}

/// Where an operating point lies.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum MapPosition {
    /// On the map, edges included.
    Inside,
    /// Off the map. A NaN lies off its coordinate's lower edge.
    Outside(MapExit),
}

impl MapPosition {
    /// How the point lies off the map, if it does.
    pub fn exit(self) -> Option<MapExit> {
        match self {
            Self::Inside => None,
            Self::Outside(exit) => Some(exit),
        }
    }
}

impl MapExit {
    /// How far outside, as a share of the width of the map there.
    pub fn excess(&self) -> f64 {
        (self.low - self.value).max(self.value - self.high) / (self.high - self.low)
    }
}
