//! What the interpolant is on the map.

#![expect(clippy::float_cmp, reason = "the ends of a line are exact")]

use super::*;

/// Largest errors on a mesh that no table of the tests shares: of flow and efficiency, relative,
/// and of their derivatives times the ranges of speed and pressure ratio, over the value.
fn errors(table: &SpeedLineTable, law: fn(f64, f64) -> (f64, f64)) -> [f64; 4] {
    let mut worst = [0.0_f64; 4];
    for i in 0..=61 {
        for j in 0..=61 {
            let [speed, ratio] = point(table, [f64::from(i) / 61.0, f64::from(j) / 61.0]);
            let pair = |speed, ratio| <[f64; 2]>::from(law(speed, ratio));
            let truth = pair(speed, ratio);
            let step = 1e-5;
            let by_speed = [pair(speed - step, ratio), pair(speed + step, ratio)];
            let by_ratio = [pair(speed, ratio - step), pair(speed, ratio + step)];
            for (of, found) in quantities(table.evaluate(speed, ratio)).iter().enumerate() {
                let slope = |ends: [[f64; 2]; 2]| (ends[1][of] - ends[0][of]) / (2.0 * step);
                let slopes = [
                    (found[1] - slope(by_speed)) * 0.4 / truth[of],
                    (found[2] - slope(by_ratio)) * 5.0 / truth[of],
                ];
                worst[of] = worst[of].max((found[0] / truth[of] - 1.0).abs());
                worst[2 + of] = worst[2 + of].max(slopes[0].abs()).max(slopes[1].abs());
            }
        }
    }
    worst
}

/// Halving the spacing divides the error of the values by 8 and that of the derivatives by 4; a
/// tenth less of the order is asked for, because the grids are coarse.
#[test]
fn converges_at_third_order_and_its_derivatives_at_second() {
    let axial = [13, 25, 49].map(|nodes| errors(&axial_table(nodes, nodes), axial));
    let ellipse = [13, 25, 49].map(|nodes| errors(&ellipse_table(nodes, nodes), ellipse));
    for pair in axial.windows(2).chain(ellipse.windows(2)) {
        for of in 0..4 {
            let order = (pair[0][of] / pair[1][of]).log2();
            let expected = if of < 2 { 2.7 } else { 1.8 };
            assert!(order > expected, "{of}: order {order}, errors {pair:?}");
        }
    }
    // A map as published ones are, 7 lines of 7 points: errors of 16e-6 and 5e-6 were measured.
    let published_size = errors(&axial_table(7, 7), super::axial);
    assert!(published_size[0] < 2e-5, "{published_size:?}");
    assert!(published_size[1] < 1e-5, "{published_size:?}");
}

/// Two points at nearly one share, one on each line: one node of the grid stands for both.
#[test]
fn points_at_almost_one_share_are_reproduced() {
    let line = |speed: f64, share: f64| SpeedLine {
        speed,
        pressure_ratio: vec![2.0, 2.0 + share, 3.0],
        flow: vec![speed + 2.0, speed + 1.5, speed],
        efficiency: vec![0.7, 0.9, 0.4],
    };
    let lines = vec![line(0.9, 0.5), line(1.0, 0.5 + 4e-9), line(1.1, 0.5 - 7e-9)];
    let table = SpeedLineTable::new(MapKind::Compressor, Extrapolation::Refuse, lines).unwrap();
    reproduces(&table).unwrap();
}

/// Whether every point of the table comes back within 1e-14, relative: rounding.
fn reproduces(table: &SpeedLineTable) -> Result<(), TestCaseError> {
    for line in table.lines() {
        for (i, &ratio) in line.pressure_ratio.iter().enumerate() {
            let value = table.evaluate(line.speed, ratio);
            prop_assert!((value.flow[0] / line.flow[i] - 1.0).abs() <= 1e-14);
            prop_assert!((value.efficiency[0] / line.efficiency[i] - 1.0).abs() <= 1e-14);
            prop_assert!(value.inside);
        }
        // Between the ends another line's node may stand for a point, some roundings away.
        let last = line.flow.len() - 1;
        for (i, ratio) in [0, last].into_iter().zip(line.ends()) {
            prop_assert_eq!(table.evaluate(line.speed, ratio).flow[0], line.flow[i]);
        }
    }
    Ok(())
}

proptest! {
    #[test]
    fn prop_reproduces_its_points(table in any_map()) {
        reproduces(&table)?;
    }

    #[test]
    fn prop_flow_does_not_overshoot_on_a_line(table in any_map(), share in 0.0..1.0f64) {
        for line in table.lines() {
            for i in 1..line.flow.len() {
                let [left, right] = [i - 1, i].map(|i| line.pressure_ratio[i]);
                let value = table.evaluate(line.speed, left + share * (right - left));
                let [a, b] = [i - 1, i].map(|i| line.flow[i]);
                let rounding = 1e-14 * a;
                prop_assert!(value.flow[0] >= a.min(b) - rounding);
                prop_assert!(value.flow[0] <= a.max(b) + rounding);
                prop_assert!(value.efficiency[0] > 0.0 && value.efficiency[0] <= 1.0);
            }
        }
    }

    /// On lines and between them, for lines as unlike as may be.
    #[test]
    fn prop_flow_is_monotone_at_every_speed(
        table in any_map(),
        speed in 0.0..=1.0f64,
        shares in proptest::collection::vec(0.0..=1.0f64, 20),
    ) {
        let sign = match table.kind() {
            MapKind::Compressor => -1.0,
            MapKind::Turbine => 1.0,
        };
        for share in shares {
            let [speed, ratio] = point(&table, [speed, share]);
            // Slopes here are of the order of 10; a negative one comes from rounding only.
            let slope = sign * table.evaluate(speed, ratio).flow[2];
            prop_assert!(slope > -1e-9, "slope {} at {} {}", slope, speed, ratio);
        }
    }

    /// The derivatives of smooth tables, inside and outside.
    #[test]
    fn prop_derivatives_are_those_of_the_value(speed in -2.0..3.0f64, share in -0.3..1.3f64) {
        for table in [axial_table(6, 7), ellipse_table(6, 7)] {
            let [speed, ratio] = point(&table, [speed, share]);
            let at = |speed, ratio| quantities(table.evaluate(speed, ratio));
            let found = at(speed, ratio);
            let step = 1e-5;
            let by_speed = [at(speed - step, ratio), at(speed + step, ratio)];
            let by_ratio = [at(speed, ratio - step), at(speed, ratio + step)];
            for of in 0..2 {
                for (field, ends) in [(1, by_speed), (2, by_ratio)] {
                    let slope = (ends[1][of][0] - ends[0][of][0]) / (2.0 * step);
                    // The second derivatives, which jump at the nodes, are below 100 values.
                    let tolerance = 100.0 * step * found[of][0];
                    prop_assert!((found[of][field] - slope).abs() < tolerance);
                }
            }
        }
    }

    /// Value and derivatives are the same on both sides of every line, every node and every edge.
    #[test]
    fn prop_nothing_jumps_at_a_border(table in any_map(), other in -0.5..1.5f64) {
        let on_lines = table.lines().iter().map(|line| {
            [line.speed, point(&table, [0.0, other])[1]]
        });
        let [slow, fast] = table.speed_range();
        let at_nodes = table.lines().iter().flat_map(|line| {
            let [low, high] = line.ends();
            let speed = slow + other * (fast - slow);
            line.pressure_ratio.iter().map(move |ratio| (speed, (ratio - low) / (high - low)))
        });
        let at_nodes = at_nodes.map(|(speed, share)| {
            let [low, high] = table.pressure_ratio_range(speed);
            [speed, low + share * (high - low)]
        });
        for [speed, ratio] in on_lines.chain(at_nodes) {
            // Across a border a continuous derivative changes as the step, a jump stays.
            let change = |a: f64, b: f64| {
                let before = quantities(table.evaluate(speed - a, ratio - b)).concat();
                let behind = quantities(table.evaluate(speed + a, ratio + b)).concat();
                let pairs = before.into_iter().zip(behind);
                pairs.map(|(before, behind)| behind - before).collect::<Vec<f64>>()
            };
            for [a, b] in [[1.0, 0.0], [0.0, 1.0]] {
                let far = change(1e-8 * a, 1e-8 * b);
                let near = change(1e-10 * a, 1e-10 * b);
                for (near, far) in near.into_iter().zip(far) {
                    prop_assert!(near.abs() <= 0.1 * far.abs() + 1e-6, "{} {}", near, far);
                }
            }
        }
    }
}
