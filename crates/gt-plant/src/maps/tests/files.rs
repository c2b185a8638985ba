//! Reading and writing.

#![expect(clippy::float_cmp, reason = "numbers come back as they were written")]

use super::*;
use crate::PlantError;

const FILE: &str = r#"
kind = "compressor"
extrapolation = "flag"

[[line]]
speed = 0.95
pressure_ratio = [8.1, 8.6, 9.2]
flow = [16.9, 16.5, 15.6]
efficiency = [0.82, 0.83, 0.81]

[[line]]
speed = 1
pressure_ratio = [9.2, 9.8, 10.5, 11]
flow = [17.6, 17.2, 16.2, 15]
efficiency = [0.83, 0.84, 0.82, 0.75]
"#;

fn read(text: &str) -> Result<SpeedLineTable, toml::de::Error> {
    toml::from_str(text)
}

#[test]
fn reads_a_file() {
    let table = read(FILE).unwrap();
    assert_eq!(table.kind(), MapKind::Compressor);
    assert_eq!(table.extrapolation(), Extrapolation::Flag);
    assert_eq!(table.lines()[1].flow, [17.6, 17.2, 16.2, 15.0]);
    assert_eq!(table.speed_range(), [0.95, 1.0]);
    let silent = read(&FILE.replace("extrapolation = \"flag\"", "")).unwrap();
    assert_eq!(silent.extrapolation(), Extrapolation::Refuse);
    assert_ne!(silent, table);
    assert_eq!(silent.with_extrapolation(Extrapolation::Flag), table);
    assert!(format!("{table:?}").contains("speed: 0.95"));
}

/// Each replacement in `file` gives an error with the text expected.
fn refused(file: &str, cases: &[(&str, &str, &str)]) {
    for (what, instead, expected) in cases {
        assert!(file.contains(what), "{what}");
        let error = read(&file.replacen(what, instead, 1)).unwrap_err();
        assert!(
            error.message().contains(expected),
            "{}\n{expected}",
            error.message()
        );
    }
}

#[test]
fn compressor_lines_do_not_cross() {
    refused(
        FILE,
        &[
            (
                "flow = [17.6, 17.2, 16.2, 15]",
                "flow = [15.6, 15.2, 14.2, 13]",
                "map line 2 (speed 1), flow[0]: expected above 15.6 (flow at one pressure ratio \
                 rises with speed), found 15.6",
            ),
            // Between two points of the faster line.
            (
                "pressure_ratio = [8.1, 8.6, 9.2]\nflow = [16.9, 16.5, 15.6]",
                "pressure_ratio = [8.6, 9.5, 9.6]\nflow = [17.65, 17.5, 15.6]",
                "map line 1 (speed 0.95), flow[1]: expected below 17.",
            ),
        ],
    );
}

#[test]
fn a_line_out_of_order_has_its_error() {
    refused(
        FILE,
        &[
            (
                "speed = 1\n",
                "speed = 0.95\n",
                "map line 2, speed: expected above 0.95 (speeds rise from line to line), found \
                 0.95",
            ),
            (
                "speed = 1\n",
                "speed = 0.9500005\n",
                "map line 2, speed: expected at least 0.950001 (a millionth beyond the line \
                 before it), found 0.9500005",
            ),
            (
                "speed = 0.95",
                "speed = nan",
                "map line 1, speed: expected above 0 and at most 10, found NaN",
            ),
            (
                "speed = 0.95",
                "speed = 95",
                "map line 1, speed: expected above 0 and at most 10, found 95",
            ),
        ],
    );
}

#[test]
fn a_point_out_of_order_has_its_error() {
    refused(
        FILE,
        &[
            (
                "[8.1, 8.6, 9.2]",
                "[8.1, 8.6]",
                "map line 1 (speed 0.95): expected 3 to 128 points, found 2",
            ),
            (
                "[16.9, 16.5, 15.6]",
                "[16.9, 16.5]",
                "map line 1 (speed 0.95), flow: expected 3 values, as many as in pressure_ratio, \
                 found 2",
            ),
            (
                "[0.83, 0.84, 0.82, 0.75]",
                "[]",
                "map line 2 (speed 1), efficiency: expected 4 values, as many as in \
                 pressure_ratio, found 0",
            ),
            (
                "[8.1, 8.6, 9.2]",
                "[8.1, 8.1, 9.2]",
                "map line 1 (speed 0.95), pressure_ratio[1]: expected above 8.1 (pressure ratios \
                 rise along a line), found 8.1",
            ),
            (
                "[8.1, 8.6, 9.2]",
                "[8.5, 8.5000001, 9.5]",
                "map line 1 (speed 0.95), pressure_ratio[1]: expected at least 8.500001 (a \
                 millionth of the line beyond the point before it), found 8.5000001",
            ),
            (
                "[8.1, 8.6, 9.2]",
                "[1, 8.6, 9.2]",
                "map line 1 (speed 0.95), pressure_ratio[0]: expected above 1 and at most 1000, \
                 found 1",
            ),
            (
                "15]",
                "16.8]",
                "map line 2 (speed 1), flow[3]: expected below 16.2 (flow falls as the pressure \
                 ratio rises; give a choked, upright part a slight slope), found 16.8",
            ),
            (
                "16.5",
                "inf",
                "map line 1 (speed 0.95), flow[1]: expected above 0 and at most 1000000000, found \
                 inf",
            ),
            (
                "15]",
                "0]",
                "map line 2 (speed 1), flow[3]: expected above 0 and at most 1000000000, found 0",
            ),
            (
                "0.84",
                "1.01",
                "map line 2 (speed 1), efficiency[1]: expected above 0 and at most 1, found 1.01",
            ),
        ],
    );
}

#[test]
fn a_turbine_out_of_order_has_its_error() {
    refused(
        &FILE.replace("compressor", "turbine"),
        &[(
            "16.9",
            "16.8",
            "map line 1 (speed 0.95), flow[1]: expected at least 16.8 (flow does not fall as the \
             expansion ratio rises), found 16.5",
        )],
    );
}

#[test]
fn an_unknown_word_has_its_error() {
    refused(
        FILE,
        &[
            ("kind", "sort", "unknown field `sort`"),
            ("flow = [16.9", "flows = [16.9", "unknown field `flows`"),
            (
                "\"flag\"",
                "\"ignore\"",
                "unknown variant `ignore`, expected `refuse` or `flag`",
            ),
            ("\"compressor\"", "\"fan\"", "unknown variant `fan`"),
            ("kind = \"compressor\"", "", "missing field `kind`"),
        ],
    );
}

#[test]
fn too_few_and_too_many() {
    let table = read(FILE).unwrap();
    let build = |lines| SpeedLineTable::new(MapKind::Compressor, Extrapolation::Refuse, lines);
    for found in [0, 1, 65] {
        let lines = vec![table.lines()[0].clone(); found];
        let (least, most) = (2, 64);
        assert_eq!(
            build(lines),
            Err(PlantError::MapLines { least, most, found })
        );
    }
    // Refused before anything of that length is made.
    for found in [0, 2, 129, usize::MAX] {
        let refused = SpeedLineTable::from_function(
            MapKind::Compressor,
            &[0.9, 1.0],
            found,
            axial_range,
            axial,
        );
        let (line, speed, least, most) = (1, 0.9, 3, 128);
        let expected = PlantError::MapPoints {
            line,
            speed,
            least,
            most,
            found,
        };
        assert_eq!(refused, Err(expected));
    }
}

#[test]
fn a_function_that_is_no_map_is_refused() {
    let kind = MapKind::Compressor;
    let refused =
        SpeedLineTable::from_function(kind, &[0.9, 1.0], 3, axial_range, |_, _| (f64::NAN, 0.8));
    let Err(error) = refused else {
        panic!("a NaN is no flow")
    };
    assert_eq!(
        error.to_string(),
        "map line 1 (speed 0.9), flow[0]: expected above 0 and at most 1000000000, found NaN"
    );
}

#[test]
fn tables_go_to_other_threads() {
    fn check<T: Send + Sync + Clone>(_: &T) {}
    check(&read(FILE).unwrap());
}

/// A list of numbers as text, mostly sensible.
fn numbers() -> impl Strategy<Value = String> {
    let number = prop_oneof![
        6 => (1.0..9.0f64).prop_map(|x| x.to_string()),
        6 => (0.1..1.0f64).prop_map(|x| x.to_string()),
        1 => "nan|inf|-inf|-?[0-9]{1,3}|1e-?[0-9]{1,3}|'x'".prop_map(String::from),
    ];
    proptest::collection::vec(number, 0..5).prop_map(|list| format!("[{}]", list.join(", ")))
}

proptest! {
    #[test]
    fn prop_round_trip(table in any_map()) {
        let text = toml::to_string(&table).unwrap();
        prop_assert_eq!(&read(&text).unwrap(), &table);
        let json = serde_json::to_string(&table).unwrap();
        prop_assert_eq!(&serde_json::from_str::<SpeedLineTable>(&json).unwrap(), &table);
    }

    #[test]
    fn prop_no_text_panics(
        text in "(kind|extrapolation|\\[\\[line\\]\\]|speed|flow|pressure_ratio|efficiency\
                 | |=|\n|[0-9.e-]{1,8}|'[a-z]{1,9}'|\\[|\\]|,){0,20}",
    ) {
        let _ = read(&text);
    }

    /// Files of the right shape with any numbers: a map that is accepted is finite and positive.
    #[test]
    fn prop_no_numbers_panic(
        lines in proptest::collection::vec((0.1..2.0f64, numbers(), numbers(), numbers()), 0..4),
        turbine in proptest::bool::ANY,
    ) {
        let kind = if turbine { "turbine" } else { "compressor" };
        let mut text = format!("kind = '{kind}'\n");
        for (speed, pressure_ratio, flow, efficiency) in lines {
            let line = format!(
                "[[line]]\nspeed = {speed}\npressure_ratio = {pressure_ratio}\n\
                 flow = {flow}\nefficiency = {efficiency}\n"
            );
            text.push_str(&line);
        }
        let _ = read(&text);
    }

    /// Numbers at the edges of what is accepted, with lines that mostly are in order.
    #[test]
    fn prop_accepted_maps_are_finite(
        speeds in proptest::array::uniform3(prop_oneof![Just(1e-6), Just(2e-6), 1e-9..10.0f64]),
        ratios in proptest::array::uniform9(prop_oneof![1.0..1.000001f64, 1.0..1000.0f64]),
        flows in proptest::array::uniform9(
            prop_oneof![Just(f64::MIN_POSITIVE), 0.0..1.0f64, 0.0..1e9f64]
        ),
        efficiencies in proptest::array::uniform9(
            prop_oneof![Just(1e-300), Just(1.0), 0.0..1.0f64]
        ),
        speed in -1.0..12.0f64,
        ratio in 0.0..1100.0f64,
    ) {
        let sorted = |list: &[f64]| {
            let mut list = list.to_vec();
            list.sort_by(f64::total_cmp);
            list
        };
        let (speeds, ratios, flows) = (sorted(&speeds), sorted(&ratios), sorted(&flows));
        let lines = (0..3).map(|line| SpeedLine {
            speed: speeds[line],
            pressure_ratio: ratios[3 * line..3 * line + 3].to_vec(),
            flow: flows[3 * line..3 * line + 3].to_vec(),
            efficiency: efficiencies[3 * line..3 * line + 3].to_vec(),
        });
        let built = SpeedLineTable::new(MapKind::Turbine, Extrapolation::Flag, lines.collect());
        if let Ok(table) = built {
            let value = table.evaluate(speed, ratio);
            prop_assert!(value.flow.iter().all(|x| x.is_finite()), "{:?}", value);
            prop_assert!(value.efficiency.iter().all(|x| x.is_finite()), "{:?}", value);
            prop_assert!(value.flow[0] > 0.0 && value.efficiency[0] > 0.0, "{:?}", value);
        }
    }
}
