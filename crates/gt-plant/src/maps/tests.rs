//! Tests of the maps, and the maps that they share.

mod files;
mod generic;
mod interpolation;
mod outside;

use proptest::prelude::*;

use super::*;

/// A compressor like the prototype's with `MapSet::Axial`: flow and efficiency.
fn axial(speed: f64, pressure_ratio: f64) -> (f64, f64) {
    let phi = (pressure_ratio - 1.0) / (8.97 * speed.powf(2.2));
    (
        16.26 * speed.powf(1.6) * (1.0 + 0.12 * (1.0 - phi * phi)),
        0.84 * (1.0 - 0.6 * (speed - 1.0).powi(2) - 0.25 * (phi - 1.0).powi(2)),
    )
}

/// The compressor's lines from choke to surge, `phi` from 0.6 to 1.25.
fn axial_range(speed: f64) -> (f64, f64) {
    let rise = 8.97 * speed.powf(2.2);
    (1.0 + 0.6 * rise, 1.0 + 1.25 * rise)
}

/// A turbine's ellipse, with a weak influence of speed and an efficiency over the velocity ratio.
fn ellipse(speed: f64, expansion: f64) -> (f64, f64) {
    let head = (1.0 - expansion.powf(-0.25)).sqrt();
    (
        5.743e-4 * (1.0 - expansion.powi(-2)).sqrt() * (1.02 - 0.02 * speed),
        0.81 * (1.0 - (0.57 * speed / head - 1.0).powi(2)),
    )
}

/// `count` speeds from 0.7 to 1.1.
fn speeds(count: usize) -> Vec<f64> {
    let last = (count - 1) as f64;
    (0..count)
        .map(|line| 0.7 + 0.4 * line as f64 / last)
        .collect()
}

/// The compressor as a table of `lines` by `points`.
fn axial_table(lines: usize, points: usize) -> SpeedLineTable {
    let kind = MapKind::Compressor;
    SpeedLineTable::from_function(kind, &speeds(lines), points, axial_range, axial).unwrap()
}

/// The turbine as a table of `lines` by `points`.
fn ellipse_table(lines: usize, points: usize) -> SpeedLineTable {
    let kind = MapKind::Turbine;
    let range = |_| (3.5, 6.0);
    SpeedLineTable::from_function(kind, &speeds(lines), points, range, ellipse).unwrap()
}

/// Random maps: lines of random lengths and spacings, with random steps of flow and jagged
/// efficiencies.
fn maps(kind: MapKind) -> impl Strategy<Value = SpeedLineTable> {
    // Half the efficiencies are 1, where nothing is left to move.
    let efficiency = prop_oneof![0.1..1.0f64, Just(1.0)];
    let points = proptest::collection::vec((0.05..1.0f64, 0.01..1.0f64, efficiency), 3..8);
    let lines = proptest::collection::vec((0.02..0.3f64, 1.1..4.0f64, 1.0..9.0f64, points), 2..6);
    lines.prop_map(move |lines| {
        let mut speed = 0.5;
        let line = (0..)
            .zip(lines)
            .map(|(index, (step, lowest, flow, points))| {
                speed += step;
                let mut line = SpeedLine {
                    speed,
                    pressure_ratio: vec![],
                    flow: vec![],
                    efficiency: vec![],
                };
                // Up to 7 steps below 1 each stay above zero, and above the line before.
                let (mut ratio, mut flow) = (lowest, flow + 7.0 + 20.0 * f64::from(index));
                for (step, rise, efficiency) in points {
                    line.pressure_ratio.push(ratio);
                    line.flow.push(flow);
                    line.efficiency.push(efficiency);
                    ratio += step;
                    flow += match kind {
                        MapKind::Compressor => -rise,
                        // A third of the steps is choked.
                        MapKind::Turbine => (rise - 0.33).max(0.0),
                    };
                }
                line
            });
        SpeedLineTable::new(kind, Extrapolation::Flag, line.collect()).unwrap()
    })
}

/// Random maps of both kinds.
fn any_map() -> impl Strategy<Value = SpeedLineTable> {
    prop_oneof![maps(MapKind::Compressor), maps(MapKind::Turbine)]
}

/// The speed and pressure ratio at shares of the range of speeds and of the line, 0 to 1 inside.
fn point(table: &SpeedLineTable, [speed, share]: [f64; 2]) -> [f64; 2] {
    let [slow, fast] = table.speed_range();
    let speed = slow + speed * (fast - slow);
    let [low, high] = table.pressure_ratio_range(speed);
    [speed, low + share * (high - low)]
}

/// Flow and efficiency, each with its derivatives.
fn quantities(value: MapValue) -> [[f64; 3]; 2] {
    [value.flow, value.efficiency]
}
