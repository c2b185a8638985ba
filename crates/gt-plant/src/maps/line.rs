//! One speed line and what is asked of it.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::{MapKind, MapRule};
use crate::PlantError;

/// Fewest and most lines of a map.
pub(super) const LINES: [usize; 2] = [2, 64];
/// Fewest and most points of a line.
pub(super) const POINTS: [usize; 2] = [3, 128];
/// Limits of a speed over its design value.
const SPEED: [f64; 2] = [0.0, 10.0];
/// Limits of a pressure ratio.
const PRESSURE_RATIO: [f64; 2] = [1.0, 1000.0];
/// Limits of a flow, of a compressor or a turbine.
const FLOW: [f64; 2] = [0.0, 1e9];
/// Limits of an efficiency.
const EFFICIENCY: [f64; 2] = [0.0, 1.0];
/// Smallest distance of two speeds, and of two points as a share of their line.
const CLOSEST: f64 = 1e-6;

/// Points at one corrected speed; the lists are of equal length, 3 to 128. Units stand in the
/// documentation of [`maps`](super).
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct SpeedLine {
    /// Corrected speed over its design value, above 0 and at most 10.
    pub speed: f64,
    /// Pressure ratios (of a turbine: expansion ratios), above 1, at most 1000 and rising by at
    /// least a millionth of the line's range.
    pub pressure_ratio: Vec<f64>,
    /// Corrected flows, above 0 and at most 1e9. A compressor's fall strictly as the pressure ratio
    /// rises, because flow is looked up by pressure ratio: where flow is choked and the line stands
    /// upright, enter it with a slight slope. A turbine's do not fall.
    pub flow: Vec<f64>,
    /// Isentropic efficiencies, above 0 and at most 1.
    pub efficiency: Vec<f64>,
}

impl SpeedLine {
    /// Smallest and largest pressure ratio; the line has points.
    pub(super) fn ends(&self) -> [f64; 2] {
        let ratios = &self.pressure_ratio;
        [ratios[0], ratios[ratios.len() - 1]]
    }

    /// The points' shares of the line, 0 to 1.
    pub(super) fn shares(&self) -> impl Iterator<Item = f64> {
        let [low, high] = self.ends();
        let ratios = self.pressure_ratio.iter();
        ratios.map(move |ratio| (ratio - low) / (high - low))
    }

    /// Whether this line, number `line` from 1, makes sense behind one at speed `before`.
    pub(super) fn check(
        &self,
        line: usize,
        before: Option<f64>,
        kind: MapKind,
    ) -> Result<(), PlantError> {
        self.check_speed(line, before)?;
        self.check_lengths(line)?;
        let refuse = |list, index, expected, found| {
            Err(PlantError::MapPoint {
                line,
                speed: self.speed,
                list,
                index,
                expected,
                found,
            })
        };
        for (list, values, limits) in [
            ("pressure_ratio", &self.pressure_ratio, PRESSURE_RATIO),
            ("flow", &self.flow, FLOW),
            ("efficiency", &self.efficiency, EFFICIENCY),
        ] {
            for (index, &found) in values.iter().enumerate() {
                if let Some(expected) = outside(limits, found) {
                    return refuse(list, index, expected, found);
                }
            }
        }
        let [low, high] = self.ends();
        for index in 1..self.flow.len() {
            let [limit, found] = [index - 1, index].map(|index| self.pressure_ratio[index]);
            if found <= limit {
                let reason = "pressure ratios rise along a line";
                let expected = MapRule::Above { limit, reason };
                return refuse("pressure_ratio", index, expected, found);
            }
            // An unsorted line has no range; its error comes from a later pair.
            let least = limit + CLOSEST * (high - low);
            if found < least {
                let expected = MapRule::AtLeast {
                    limit: least,
                    reason: "a millionth of the line beyond the point before it",
                };
                return refuse("pressure_ratio", index, expected, found);
            }
            let [limit, found] = [index - 1, index].map(|index| self.flow[index]);
            match kind {
                MapKind::Compressor if found >= limit => {
                    let reason = "flow falls as the pressure ratio rises; \
                                  give a choked, upright part a slight slope";
                    return refuse("flow", index, MapRule::Below { limit, reason }, found);
                }
                MapKind::Turbine if found < limit => {
                    let reason = "flow does not fall as the expansion ratio rises";
                    return refuse("flow", index, MapRule::AtLeast { limit, reason }, found);
                }
                MapKind::Compressor | MapKind::Turbine => {}
            }
        }
        Ok(())
    }

    /// Whether a compressor's line, number `line` from 1 and checked by itself, has more flow than
    /// a slower one at every pressure ratio that both have; else no flow tells the speed.
    pub(super) fn check_faster_than(&self, slower: &Self, line: usize) -> Result<(), PlantError> {
        let reason = "flow at one pressure ratio rises with speed";
        let refuse = |(line, index): (usize, usize), of: &Self, expected| {
            Err(PlantError::MapPoint {
                line,
                speed: of.speed,
                list: "flow",
                index,
                expected,
                found: of.flow[index],
            })
        };
        for (index, &ratio) in self.pressure_ratio.iter().enumerate() {
            match slower.flow_at(ratio) {
                Some(limit) if self.flow[index] <= limit => {
                    return refuse((line, index), self, MapRule::Above { limit, reason });
                }
                _ => {}
            }
        }
        for (index, &ratio) in slower.pressure_ratio.iter().enumerate() {
            match self.flow_at(ratio) {
                Some(limit) if slower.flow[index] >= limit => {
                    return refuse((line - 1, index), slower, MapRule::Below { limit, reason });
                }
                _ => {}
            }
        }
        Ok(())
    }

    /// The flow at a pressure ratio on the straight lines between the points; none beyond the ends.
    fn flow_at(&self, ratio: f64) -> Option<f64> {
        let after = self.pressure_ratio.iter().position(|&own| own >= ratio)?;
        if after == 0 {
            return (self.pressure_ratio[0] <= ratio).then(|| self.flow[0]);
        }
        let [low, high] = [after - 1, after].map(|index| self.pressure_ratio[index]);
        let share = (ratio - low) / (high - low);
        Some(self.flow[after - 1] + share * (self.flow[after] - self.flow[after - 1]))
    }

    fn check_speed(&self, line: usize, before: Option<f64>) -> Result<(), PlantError> {
        let found = self.speed;
        let expected = outside(SPEED, found).or(match before {
            Some(limit) if found <= limit => Some(MapRule::Above {
                limit,
                reason: "speeds rise from line to line",
            }),
            Some(limit) if found < limit + CLOSEST => Some(MapRule::AtLeast {
                limit: limit + CLOSEST,
                reason: "a millionth beyond the line before it",
            }),
            _ => None,
        });
        match expected {
            Some(expected) => Err(PlantError::MapSpeed {
                line,
                expected,
                found,
            }),
            None => Ok(()),
        }
    }

    fn check_lengths(&self, line: usize) -> Result<(), PlantError> {
        let speed = self.speed;
        let expected = self.pressure_ratio.len();
        check_points(line, speed, expected)?;
        for (list, values) in [("flow", &self.flow), ("efficiency", &self.efficiency)] {
            let found = values.len();
            if found != expected {
                return Err(PlantError::MapLength {
                    line,
                    speed,
                    list,
                    expected,
                    found,
                });
            }
        }
        Ok(())
    }
}

/// Whether a line has an acceptable number of points.
pub(super) fn check_points(line: usize, speed: f64, found: usize) -> Result<(), PlantError> {
    let [least, most] = POINTS;
    if (least..=most).contains(&found) {
        return Ok(());
    }
    Err(PlantError::MapPoints {
        line,
        speed,
        least,
        most,
        found,
    })
}

/// The rule that `found` breaks; a NaN breaks it.
fn outside([low, high]: [f64; 2], found: f64) -> Option<MapRule> {
    let inside = low < found && found <= high;
    (!inside).then_some(MapRule::Range { low, high })
}
