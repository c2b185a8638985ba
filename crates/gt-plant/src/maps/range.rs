//! The range in which an analytic map is believed.

use serde::{Deserialize, Serialize};

use super::{MapEdge, MapExit};

/// Range of an analytic map in its two coordinates.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct MapRange {
    /// Lowest and highest corrected speed over its design value (assumed).
    pub speed: [f64; 2],
    /// Lowest and highest load of a speed line (assumed): for the compressor the pressure rise
    /// over that of the line's design point, for the turbine the expansion ratio.
    pub load: [f64; 2],
}

/// How a point left a range: the speed first. A NaN lies off the lower edge.
pub(super) fn exit(
    speed: f64,
    speed_range: [f64; 2],
    ratio: f64,
    ratio_range: [f64; 2],
    [low_edge, high_edge]: [MapEdge; 2],
) -> Option<MapExit> {
    let speed_edges = [MapEdge::SlowestLine, MapEdge::FastestLine];
    [
        (speed, speed_range, speed_edges),
        (ratio, ratio_range, [low_edge, high_edge]),
    ]
    .into_iter()
    .find(|(value, [low, high], _)| !(low <= value && value <= high))
    .map(|(value, [low, high], [below, above])| MapExit {
        edge: if value > high { above } else { below },
        low,
        high,
        value,
    })
}
