//! The interpolant: nodes on a common grid of speed and share of the line.

use super::axis::{Axis, Cell, FARTHEST};
use super::bend::Bend;
use super::line::SpeedLine;
use super::{order, slopes};

/// Shares of different lines that lie closer than this are one node of the grid.
const SAME_SHARE: f64 = 1e-8;
/// How far off a line's end a share still counts as on it.
pub(super) const ROUNDING: f64 = 1e-12;

/// What a map says at one operating point: value, derivative by speed, derivative by pressure
/// ratio.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct MapValue {
    /// Corrected flow, in the unit of the map's kind.
    pub flow: [f64; 3],
    /// Isentropic efficiency.
    pub efficiency: [f64; 3],
    /// Whether the point lies on the map, edges (but for rounding) included; if not, the values are
    /// continued.
    pub inside: bool,
}

/// A quantity at a node: value, slope by share, slope by speed, mixed derivative.
pub(super) type Corner = [f64; 4];

/// Both quantities at a node, in one cache line: flow, efficiency and their slopes by speed; and
/// the derivatives of these four by share. Weights meet all four of a list at once.
type Node = [[f64; 4]; 2];

/// Lower end and width of a line, in pressure ratio; and their slopes over speed.
type Ends = [[f64; 2]; 2];

/// The interpolant.
#[derive(Debug)]
pub(super) struct Grid {
    speeds: Axis,
    ends: Vec<Ends>,
    shares: Axis,
    /// Line by line.
    nodes: Vec<Node>,
    /// Of the lower end above 1, of the width, of flow and of efficiency.
    bends: [Bend; 4],
}

/// An operating point's place: its interval of speed and the ends of its line.
#[derive(Debug, Clone, Copy)]
pub(super) struct Place {
    across: Cell,
    ends: Ends,
}

impl Place {
    /// How far along the line a pressure ratio lies. Divided, not multiplied with the inverse, so
    /// that a point of the table lies exactly on its node.
    #[inline]
    pub(super) fn share(&self, pressure_ratio: f64) -> f64 {
        let [low, width] = self.ends[0];
        let share = (pressure_ratio - low) / width;
        share.clamp(-FARTHEST, FARTHEST)
    }

    /// Lowest and highest pressure ratio.
    pub(super) fn range(&self) -> [f64; 2] {
        let [low, width] = self.ends[0];
        [low, low + width]
    }
}

impl Grid {
    /// The interpolant of lines that passed their checks.
    pub(super) fn new(lines: &[SpeedLine]) -> Self {
        let speeds: Vec<f64> = lines.iter().map(|line| line.speed).collect();
        let shares = shared(lines);
        let lows: Vec<f64> = lines.iter().map(|line| line.ends()[0]).collect();
        let widths: Vec<f64> = lines
            .iter()
            .map(|line| line.ends()[1] - line.ends()[0])
            .collect();
        let low_slopes = slopes::smooth(&speeds, &lows, |low| low - 1.0);
        let width_slopes = slopes::smooth(&speeds, &widths, |width| width);
        let ends = (0..lines.len())
            .map(|line| {
                [
                    [lows[line], widths[line]],
                    [low_slopes[line], width_slopes[line]],
                ]
            })
            .collect();
        let mut flow = corners(
            &speeds,
            along(lines, &shares, |line, own| {
                (&line.flow, slopes::monotone(own, &line.flow))
            }),
            |flow| flow,
        );
        order::keep(&speeds, &shares, &mut flow);
        let room = |efficiency: f64| efficiency.min(1.0 - efficiency);
        let mut efficiency = corners(
            &speeds,
            along(lines, &shares, |line, own| {
                let slopes = slopes::smooth(own, &line.efficiency, room);
                (&line.efficiency, slopes)
            }),
            room,
        );
        mix(&shares, &mut efficiency);
        let nodes = flow
            .into_iter()
            .zip(efficiency)
            .map(|(flow, efficiency)| {
                // Fields 0 and 2, of both; their derivatives by share are fields 1 and 3.
                [0, 1].map(|by_share| {
                    let (value, by_speed) = (by_share, by_share + 2);
                    [
                        flow[value],
                        efficiency[value],
                        flow[by_speed],
                        efficiency[by_speed],
                    ]
                })
            })
            .collect();
        let bends = [
            Bend::positive(extremes(&lows)[0] - 1.0),
            Bend::positive(extremes(&widths)[0]),
            Bend::flow(extremes(lines.iter().flat_map(|line| &line.flow))),
            Bend::efficiency(extremes(lines.iter().flat_map(|line| &line.efficiency))),
        ];
        Self {
            speeds: Axis::new(speeds),
            ends,
            shares: Axis::new(shares),
            nodes,
            bends,
        }
    }

    /// Lowest and highest speed.
    pub(super) fn speed_range(&self) -> [f64; 2] {
        self.speeds.range()
    }

    /// The place of a speed.
    #[inline]
    pub(super) fn place(&self, speed: f64) -> Place {
        let across = self.speeds.find(speed);
        let [mut ends, mut slopes] =
            across.blend(&self.ends[across.index], &self.ends[across.index + 1]);
        if across.beyond != 0.0 {
            let [low_bend, width_bend, ..] = &self.bends;
            let [above, low_slope] = low_bend.apply(ends[0] + slopes[0] * across.beyond - 1.0);
            let [width, width_slope] = width_bend.apply(ends[1] + slopes[1] * across.beyond);
            ends = [1.0 + above, width];
            slopes = [slopes[0] * low_slope, slopes[1] * width_slope];
        }
        Place {
            across,
            ends: [ends, slopes],
        }
    }

    /// What the map says at a place and a pressure ratio.
    #[inline]
    pub(super) fn evaluate(&self, place: &Place, pressure_ratio: f64) -> MapValue {
        let across = &place.across;
        let share = place.share(pressure_ratio);
        let along = self.shares.find(share);
        let slow = across.index * self.shares.nodes().len() + along.index;
        let fast = slow + self.shares.nodes().len();
        let slow = along.blend(&self.nodes[slow], &self.nodes[slow + 1]);
        let fast = along.blend(&self.nodes[fast], &self.nodes[fast + 1]);
        let [value, by_speed] = across.blend(&halves(slow[0]), &halves(fast[0]));
        let [by_share, mixed] = across.blend(&halves(slow[1]), &halves(fast[1]));
        let [[_, width], [low_slope, width_slope]] = place.ends;
        let share_by_ratio = 1.0 / width;
        let share_by_speed = -(low_slope + share * width_slope) * share_by_ratio;
        let quantity = |of: usize, bend: &Bend| {
            // Linear in both coordinates beyond the table; these terms vanish on it.
            let value = value[of]
                + by_share[of] * along.beyond
                + (by_speed[of] + mixed[of] * along.beyond) * across.beyond;
            let by_share = by_share[of] + mixed[of] * across.beyond;
            let by_speed = by_speed[of] + mixed[of] * along.beyond;
            let [value, bent] = bend.apply(value);
            [
                value,
                bent * (by_speed + by_share * share_by_speed),
                bent * by_share * share_by_ratio,
            ]
        };
        let [_, _, flow_bend, efficiency_bend] = &self.bends;
        let (flow, efficiency) = (quantity(0, flow_bend), quantity(1, efficiency_bend));
        MapValue {
            flow,
            efficiency,
            inside: across.beyond == 0.0 && along.beyond.abs() <= ROUNDING,
        }
    }
}

/// Values and slopes by speed, apart.
#[inline]
fn halves([flow, efficiency, flow_by_speed, efficiency_by_speed]: [f64; 4]) -> [[f64; 2]; 2] {
    [[flow, efficiency], [flow_by_speed, efficiency_by_speed]]
}

/// The shares of all lines, without those that are the same but for rounding.
fn shared(lines: &[SpeedLine]) -> Vec<f64> {
    let mut shares: Vec<f64> = lines.iter().flat_map(SpeedLine::shares).collect();
    shares.sort_by(f64::total_cmp);
    shares.dedup_by(|next, kept| *next - *kept < SAME_SHARE);
    // Every line ends at 1 exactly; what lay just below it is the same node.
    if let Some(last) = shares.last_mut() {
        *last = 1.0;
    }
    shares
}

/// Value and slope of each line's own interpolant at the common shares, line by line.
fn along<'a>(
    lines: &'a [SpeedLine],
    shares: &[f64],
    curve: impl Fn(&'a SpeedLine, &[f64]) -> (&'a Vec<f64>, Vec<f64>),
) -> Vec<Vec<[f64; 2]>> {
    lines
        .iter()
        .map(|line| {
            let own: Vec<f64> = line.shares().collect();
            let (values, slopes) = curve(line, &own);
            let own = Axis::new(own);
            let at = |&share: &f64| {
                let cell = own.find(share);
                let (left, right) = (cell.index, cell.index + 1);
                let [value, slope] = cell.blend(
                    &[[values[left]], [slopes[left]]],
                    &[[values[right]], [slopes[right]]],
                );
                [value[0], slope[0]]
            };
            shares.iter().map(at).collect()
        })
        .collect()
}

/// Adds the slopes over speed of the values, which may move by `room`; no mixed derivatives yet.
fn corners(speeds: &[f64], lines: Vec<Vec<[f64; 2]>>, room: impl Fn(f64) -> f64) -> Vec<Corner> {
    let width = lines[0].len();
    let mut corners: Vec<Corner> = lines
        .into_iter()
        .flatten()
        .map(|[value, by_share]| [value, by_share, 0.0, 0.0])
        .collect();
    for share in 0..width {
        let nodes = corners[share..].iter().step_by(width);
        let column: Vec<f64> = nodes.map(|corner| corner[0]).collect();
        let slopes = slopes::smooth(speeds, &column, &room);
        let nodes = corners[share..].iter_mut().step_by(width);
        for (corner, slope) in nodes.zip(slopes) {
            corner[2] = slope;
        }
    }
    corners
}

/// Adds the mixed derivatives: slopes along each line of the slopes over speed.
pub(super) fn mix(shares: &[f64], corners: &mut [Corner]) {
    for line in corners.chunks_exact_mut(shares.len()) {
        let by_speed: Vec<f64> = line.iter().map(|corner| corner[2]).collect();
        let mixed = slopes::smooth(shares, &by_speed, |_| f64::INFINITY);
        for (corner, mixed) in line.iter_mut().zip(mixed) {
            corner[3] = mixed;
        }
    }
}

/// The smallest and the largest.
fn extremes<'a>(values: impl IntoIterator<Item = &'a f64>) -> [f64; 2] {
    values
        .into_iter()
        .fold([f64::INFINITY, 0.0], |[least, most], &value| {
            [value.min(least), value.max(most)]
        })
}
