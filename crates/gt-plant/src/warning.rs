//! What a run did that a reader of its record should know.

use std::fmt;

use serde::{Deserialize, Serialize};

use crate::PlantParameters;
use crate::components::governor::FuelLimit;
use crate::components::valve::critical_ratio;
use crate::dynamics::Instant;
use crate::maps::MapExit;
use crate::state::State;
use crate::variant::Variant;

/// When something was seen.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Seen {
    /// Time of the first such sample, s.
    pub first_s: f64,
    /// Number of such samples.
    pub samples: usize,
}

/// A remark on a run that is no error.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(tag = "kind", rename_all = "snake_case")]
pub enum Warning {
    /// The fuel demand was at its lower limit.
    FuelAtMinimum(Seen),
    /// The fuel demand was at its upper limit.
    FuelAtMaximum(Seen),
    /// The guide vanes stood at their open stop.
    VanesOpen(Seen),
    /// The guide vanes stood at their closed stop.
    VanesClosed(Seen),
    /// The pressurising valve was not choked (prototype, where it is at design).
    ValveUnchoked(Seen),
    /// The compressor ran outside its map.
    OutsideCompressorMap {
        /// When.
        #[serde(flatten)]
        seen: Seen,
        /// The edge that was passed, where it was passed furthest.
        furthest: MapExit,
    },
    /// The turbine ran outside its map.
    OutsideTurbineMap {
        /// When.
        #[serde(flatten)]
        seen: Seen,
        /// The edge that was passed, where it was passed furthest.
        furthest: MapExit,
    },
    /// Noise was asked for as a share of what signals do, but nothing is excited.
    NoNoise,
}

impl fmt::Display for Warning {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        let (what, seen) = match self {
            Self::FuelAtMinimum(seen) => ("the fuel demand was at its lower limit", seen),
            Self::FuelAtMaximum(seen) => ("the fuel demand was at its upper limit", seen),
            Self::VanesOpen(seen) => ("the guide vanes stood at their open stop", seen),
            Self::VanesClosed(seen) => ("the guide vanes stood at their closed stop", seen),
            Self::ValveUnchoked(seen) => ("the pressurising valve was not choked", seen),
            Self::OutsideCompressorMap { seen, .. } => ("the compressor ran outside its map", seen),
            Self::OutsideTurbineMap { seen, .. } => ("the turbine ran outside its map", seen),
            Self::NoNoise => {
                return formatter.write_str(
                    "no noise where it is a share of the signals' deviations: nothing is excited",
                );
            }
        };
        write!(
            formatter,
            "{what} in {} samples, first at {:.2} s",
            seen.samples, seen.first_s
        )?;
        if let Self::OutsideCompressorMap { furthest, .. }
        | Self::OutsideTurbineMap { furthest, .. } = self
        {
            write!(
                formatter,
                " ({}: expected a {} between {:.4} and {:.4}, furthest {:.4})",
                furthest.edge,
                furthest.edge.coordinate(),
                furthest.low,
                furthest.high,
                furthest.value
            )?;
        }
        Ok(())
    }
}

/// Counts what warnings report.
#[derive(Debug, Clone, Default)]
pub(crate) struct Remarks {
    minimum: Option<Seen>,
    maximum: Option<Seen>,
    open: Option<Seen>,
    closed: Option<Seen>,
    unchoked: Option<Seen>,
    compressor: Option<(Seen, MapExit)>,
    turbine: Option<(Seen, MapExit)>,
}

impl Remarks {
    pub fn see(&mut self, plant: &PlantParameters, instant: &Instant, x: &State, time_s: f64) {
        match plant.governor.limit(instant.fuel_demand_kg_s) {
            None => {}
            Some(FuelLimit::Minimum) => count(&mut self.minimum, time_s),
            Some(FuelLimit::Maximum) => count(&mut self.maximum, time_s),
        }
        let point = &instant.point;
        match plant.variant {
            Variant::Prototype => {
                if x.p8_pa > critical_ratio(point.exit_gamma) * x.p7_pa {
                    count(&mut self.unchoked, time_s);
                }
            }
            Variant::Cogeneration => {
                if instant.guide_vane_demand_deg <= 0.0 {
                    count(&mut self.open, time_s);
                } else if instant.guide_vane_demand_deg >= plant.guide_vanes.closed_deg {
                    count(&mut self.closed, time_s);
                }
            }
        }
        let (compression, expansion) = (&point.compression, &point.expansion);
        let map = &plant.compressor.map;
        let edge = map.exit(compression.map_speed, compression.map_pressure_ratio);
        extend(&mut self.compressor, edge, time_s);
        let map = &plant.turbine.map;
        let edge = map.exit(expansion.map_speed, expansion.expansion_ratio);
        extend(&mut self.turbine, edge, time_s);
    }

    pub fn warnings(&self) -> Vec<Warning> {
        let outside = |entry: Option<(Seen, MapExit)>, of: fn(Seen, MapExit) -> Warning| {
            entry.map(|(seen, furthest)| of(seen, furthest))
        };
        [
            self.minimum.map(Warning::FuelAtMinimum),
            self.maximum.map(Warning::FuelAtMaximum),
            self.open.map(Warning::VanesOpen),
            self.closed.map(Warning::VanesClosed),
            self.unchoked.map(Warning::ValveUnchoked),
            outside(self.compressor, |seen, furthest| {
                Warning::OutsideCompressorMap { seen, furthest }
            }),
            outside(self.turbine, |seen, furthest| Warning::OutsideTurbineMap {
                seen,
                furthest,
            }),
        ]
        .into_iter()
        .flatten()
        .collect()
    }
}

fn count(entry: &mut Option<Seen>, time_s: f64) {
    entry
        .get_or_insert(Seen {
            first_s: time_s,
            samples: 0,
        })
        .samples += 1;
}

fn extend(entry: &mut Option<(Seen, MapExit)>, edge: Option<MapExit>, time_s: f64) {
    let Some(edge) = edge else { return };
    let start = Seen {
        first_s: time_s,
        samples: 0,
    };
    let (seen, furthest) = entry.get_or_insert((start, edge));
    seen.samples += 1;
    if edge.excess() > furthest.excess() {
        *furthest = edge;
    }
}
