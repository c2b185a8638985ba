//! What the map says, and that it says so, outside the table.

use super::*;

/// Smallest and largest flow and efficiency of the points.
fn extremes(table: &SpeedLineTable) -> [[f64; 2]; 2] {
    let over = |pick: fn(&SpeedLine) -> &Vec<f64>| {
        let values = table.lines().iter().flat_map(pick);
        values.fold([f64::INFINITY, 0.0_f64], |[least, most], &value| {
            [least.min(value), most.max(value)]
        })
    };
    [over(|line| &line.flow), over(|line| &line.efficiency)]
}

/// A small compressor map whose ends are round numbers.
fn square() -> SpeedLineTable {
    let line = |speed: f64| SpeedLine {
        speed,
        pressure_ratio: vec![2.0, 3.0, 4.0],
        flow: vec![5.0 * speed, 4.5 * speed, 4.0 * speed],
        efficiency: vec![0.7, 0.8, 0.75],
    };
    let lines = vec![line(0.8), line(0.9), line(1.0)];
    SpeedLineTable::new(MapKind::Compressor, Extrapolation::Refuse, lines).unwrap()
}

#[test]
fn position_names_the_edge() {
    let turbine = ellipse_table(3, 4);
    let compressor = square();
    for (table, point, edge, coordinate, [low, high]) in [
        (
            &compressor,
            [0.7, 3.0],
            MapEdge::SlowestLine,
            "speed",
            [0.8, 1.0],
        ),
        (
            &compressor,
            [1.1, 9.0],
            MapEdge::FastestLine,
            "speed",
            [0.8, 1.0],
        ),
        (
            &compressor,
            [0.85, 1.9],
            MapEdge::ChokeSide,
            "pressure ratio",
            [2.0, 4.0],
        ),
        (
            &compressor,
            [0.85, 4.1],
            MapEdge::SurgeSide,
            "pressure ratio",
            [2.0, 4.0],
        ),
        (
            &turbine,
            [0.9, 3.4],
            MapEdge::LowExpansion,
            "pressure ratio",
            [3.5, 6.0],
        ),
        (
            &turbine,
            [0.9, 6.1],
            MapEdge::HighExpansion,
            "pressure ratio",
            [3.5, 6.0],
        ),
    ] {
        let value = point[usize::from(coordinate != "speed")];
        let exit = MapExit {
            edge,
            low,
            high,
            value,
        };
        let [speed, ratio] = point;
        assert_eq!(table.position(speed, ratio), MapPosition::Outside(exit));
        assert_eq!(edge.coordinate(), coordinate);
        assert!(!table.evaluate(speed, ratio).inside, "{edge}");
    }
    for (speed, ratio) in [(0.8, 2.0), (1.0, 4.0), (0.87, 3.3), (0.9, 2.0)] {
        assert_eq!(compressor.position(speed, ratio), MapPosition::Inside);
        assert!(compressor.evaluate(speed, ratio).inside);
    }
    let edge = |speed, ratio| match compressor.position(speed, ratio) {
        MapPosition::Inside => None,
        MapPosition::Outside(exit) => Some(exit.edge),
    };
    assert_eq!(edge(f64::NAN, 3.0), Some(MapEdge::SlowestLine));
    assert_eq!(edge(0.9, f64::NAN), Some(MapEdge::ChokeSide));
    assert_eq!(format!("{:>13}", MapEdge::SurgeSide), "   surge side");
}

#[test]
fn a_nan_gives_a_nan_and_no_panic() {
    for (speed, ratio) in [(f64::NAN, 3.0), (0.9, f64::NAN)] {
        let value = square().evaluate(speed, ratio);
        assert!(value.flow[0].is_nan() && value.efficiency[0].is_nan() && !value.inside);
    }
}

/// Numbers of any size, and the ends of the scale.
fn any_number() -> impl Strategy<Value = f64> {
    prop_oneof![
        -2.0..12.0f64,
        proptest::num::f64::ANY.prop_filter("a NaN gives a NaN", |x| !x.is_nan()),
        Just(f64::INFINITY),
        Just(f64::NEG_INFINITY),
        Just(f64::MAX),
    ]
}

proptest! {
    #[test]
    fn prop_sane_everywhere(table in any_map(), speed in any_number(), ratio in any_number()) {
        let value = table.evaluate(speed, ratio);
        let [flows, efficiencies] = extremes(&table);
        for field in 0..3 {
            prop_assert!(value.flow[field].is_finite() && value.efficiency[field].is_finite());
        }
        prop_assert!((0.25 * flows[0]..=4.0 * flows[1]).contains(&value.flow[0]));
        // Half the tables reach 1 and leave no room below it.
        prop_assert!((0.25 * efficiencies[0]..=1.01).contains(&value.efficiency[0]));
        let [low, high] = table.pressure_ratio_range(speed);
        prop_assert!(1.0 < low && low < high);
    }

    /// Whatever way a point went, `position` and the flag of the value agree.
    #[test]
    fn prop_flag_and_position_agree(
        table in any_map(), speed in -0.5..1.5f64, share in -0.5..1.5f64,
    ) {
        let [speed, ratio] = point(&table, [speed, share]);
        let inside = table.position(speed, ratio) == MapPosition::Inside;
        prop_assert_eq!(table.evaluate(speed, ratio).inside, inside);
    }

    /// Near the border the continuation is the straight line of the border's value and slope.
    #[test]
    fn prop_continued_linearly(share in 0.0..1.0f64, far in 0.0..0.2f64) {
        for table in [axial_table(5, 6), ellipse_table(5, 6)] {
            for (edge, sign) in [(0.0, -1.0), (1.0, 1.0)] {
                // Over the pressure ratio, at any speed.
                let [speed, border] = point(&table, [share, edge]);
                let [low, high] = table.pressure_ratio_range(speed);
                let step = sign * far * (high - low);
                let start = quantities(table.evaluate(speed, border));
                let end = quantities(table.evaluate(speed, border + step));
                for (start, end) in start.into_iter().zip(end) {
                    prop_assert!((start[0] + start[2] * step - end[0]).abs() < 1e-12 * start[0]);
                    prop_assert!((start[2] - end[2]).abs() < 1e-12 * start[0]);
                }
                // Over speed, at one share of the line; the slope at a share from a short step.
                let along = |far: f64| {
                    let [speed, ratio] = point(&table, [edge + sign * far, share]);
                    quantities(table.evaluate(speed, ratio)).map(|quantity| quantity[0])
                };
                let (border, near, end) = (along(0.0), along(0.1 * far), along(far));
                for of in 0..2 {
                    let straight = border[of] + 10.0 * (near[of] - border[of]);
                    prop_assert!((straight - end[of]).abs() < 1e-12 * border[of]);
                }
            }
        }
    }
}
