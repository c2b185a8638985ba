//! `gtfdi identify`: ridge, operating point, equation errors, solver.

use serde_json::Value;

use crate::place::{Place, Ran, array, number, object};
use crate::signal::{csv, second_order, second_order_csv, two_outputs_csv};

/// The same sums in another order.
const TOLERANCE: f64 = 1e-10;
const HEAD: [&str; 6] = ["identify", "one.csv", "--inputs", "u", "--outputs", "y"];

fn coefficients(report: &Value) -> Vec<f64> {
    let outputs = array(report, "/outputs").iter();
    let terms = outputs.flat_map(|output| array(output, "/regression"));
    terms.map(|term| number(term, "/coefficient")).collect()
}

fn agree(a: &[f64], b: &[f64], tolerance: f64) {
    assert_eq!(a.len(), b.len());
    for (a, b) in a.iter().zip(b) {
        assert!((a - b).abs() < tolerance, "{a} {b}");
    }
}

/// One coefficient `theta = x'y / x'x` under a penalty `r |x|^2 theta^2` is `x'y / (x'x (1 + r))`.
#[test]
fn a_ridge_divides_a_single_coefficient() {
    let place = Place::new();
    place.write("one.csv", second_order_csv(200, 1));
    let lags = ["--na", "0", "--nb", "1"];
    let of = |more: &[&str]| coefficients(&place.json(&[&HEAD[..], &lags, more].concat()))[0];
    let plain = of(&[]);
    assert!(plain.abs() > 0.1);
    for (weight, factor) in [("0", 1.0), ("0.5", 1.5), ("3", 4.0)] {
        let held = of(&["--ridge", weight]);
        assert!(
            (held * factor - plain).abs() < TOLERANCE,
            "{weight}: {held} {plain}"
        );
    }
}

/// Two equal channels have no least-squares solution; the ridge shares the effect between them.
#[test]
fn a_ridge_holds_equal_channels() {
    let place = Place::new();
    let rows: Vec<Vec<f64>> = second_order(200, 1)
        .iter()
        .map(|row| vec![row[0], row[0], row[1]])
        .collect();
    place.write("twins.csv", csv("u,v,y", &rows));
    let args = [
        "identify",
        "twins.csv",
        "--inputs",
        "u,v",
        "--outputs",
        "y",
        "--order",
        "1",
    ];
    let report = place.json(&[&args[..], &["--ridge", "1e-6"]].concat());
    let found = coefficients(&report);
    // y(t-1), u(t-1), v(t-1).
    assert!(
        (found[1] - found[2]).abs() < 1e-6 * found[1].abs(),
        "{found:?}"
    );
    // The mean of the least-squares coefficient, but for the ridge.
    place.write("one.csv", second_order_csv(200, 1));
    let one = coefficients(&place.json(&[&HEAD[..], &["--order", "1"]].concat()));
    assert!(
        (2.0 * found[1] - one[1]).abs() < 1e-4 * one[1].abs(),
        "{found:?} {one:?}"
    );
}

#[test]
fn the_operating_point_is_chosen() {
    let place = Place::new();
    place.write("one.csv", second_order_csv(200, 1));
    let of = |centre: &str| {
        let args = ["--order", "2", "--centre", centre, "--out", "m.json"];
        let report = place.json(&[&HEAD[..], &args].concat());
        let model: Value = serde_json::from_slice(&place.read("m.json")).expect("JSON");
        let point = ["u", "y"].map(|side| model["model"]["operating_point"][side][0][0].clone());
        (coefficients(&report), point)
    };
    let (means, point) = of("means");
    assert_eq!(
        coefficients(&place.json(&[&HEAD[..], &["--order", "2"]].concat())),
        means
    );
    let (zero, origin) = of("zero");
    assert_eq!(origin, [Value::from(0.0), Value::from(0.0)]);
    assert!(zero != means);
    let (same, again) = of(&format!("y={},u={}", point[1], point[0]));
    assert_eq!(again, point);
    agree(&same, &means, TOLERANCE);
}

#[test]
fn equation_errors_and_solvers_are_chosen() {
    let place = Place::new();
    place.write("one.csv", second_order_csv(5000, 1));
    let of =
        |more: &[&str]| coefficients(&place.json(&[&HEAD[..], &["--order", "2"], more].concat()));
    let qr = of(&[]);
    assert_eq!(of(&["--solver", "qr"]), qr);
    // A well-conditioned record: refinement agrees to about the accuracy of QR.
    agree(&of(&["--solver", "automatic"]), &qr, TOLERANCE);
    // Alone, an output has no other's errors to be correlated with.
    agree(&of(&["--equation-errors", "correlated"]), &qr, TOLERANCE);
    place.write("two.csv", two_outputs_csv(500, 1));
    let head = [
        "identify",
        "two.csv",
        "--inputs",
        "u*",
        "--outputs",
        "y*",
        "--structure",
        "diag",
    ];
    let two =
        |more: &[&str]| coefficients(&place.json(&[&head[..], &["--order", "2"], more].concat()));
    let (alone, together) = (two(&[]), two(&["--equation-errors", "correlated"]));
    // Independent noise: the same but for the sample's own correlation of the errors, which is of
    // the order of 1 / sqrt(500); not the same to the last digit.
    agree(&alone, &together, 0.02);
    assert!(alone != together);
}

#[test]
fn environment_and_file_give_the_options_too() {
    let place = Place::new();
    place.write("one.csv", second_order_csv(200, 1));
    let args = [&HEAD[..], &["--order", "2"]].concat();
    let flag = place.json(&[&args[..], &["--ridge", "0.5", "--centre", "zero"]].concat());
    let mut command = place.command(&[&args[..], &["--json"]].concat());
    let ran = Ran::of(
        command
            .env("GTFDI_RIDGE", "0.5")
            .env("GTFDI_CENTRE", "zero"),
    );
    assert_eq!(object(&ran.stdout)["outputs"], flag["outputs"]);
    place.write("c.toml", "[identify]\nridge = 0.5\ncentre = \"zero\"\n");
    let file = place.json(&[&args[..], &["--config", "c.toml"]].concat());
    assert_eq!(file["outputs"], flag["outputs"]);
}

#[test]
fn values_that_make_no_sense_are_refused() {
    let place = Place::new();
    place.write("one.csv", second_order_csv(200, 1));
    let centre = "--centre: expected means, zero or TAG=VALUE with a finite value for each \
                  channel, found ";
    let cases: [(&[&str], &str); 14] = [
        (
            &["--ridge", "-1"],
            "--ridge: expected a finite number of at least 0, found -1",
        ),
        (
            &["--ridge", "nan"],
            "--ridge: expected a finite number of at least 0, found NaN",
        ),
        (
            &["--ridge", "inf"],
            "--ridge: expected a finite number of at least 0, found inf",
        ),
        (
            &["--ridge", "1", "--equation-errors", "correlated"],
            "--ridge: expected 0 with --equation-errors correlated, found 1",
        ),
        (&["--centre", "middle"], &format!("{centre}`middle`")),
        (&["--centre", "u=x,y=1"], &format!("{centre}`u=x`")),
        (&["--centre", "u=inf,y=1"], &format!("{centre}`u=inf`")),
        (&["--centre", "u=1,u=2"], &format!("{centre}`u=2`")),
        (
            &["--centre", "u=1"],
            "--centre: expected a value for each channel, found none for `y`",
        ),
        (
            &["--centre", "u=1,y=2,z=3"],
            "--centre: expected selected channels, found `z`",
        ),
        (
            &["--method", "eiv", "--ridge", "1"],
            "--ridge: expected with --method arx only, found another method: it takes --order and \
             --nk",
        ),
        (
            &["--method", "frisch", "--centre", "zero"],
            "--centre: expected with --method arx only, found another method: it takes --order \
             and --nk",
        ),
        (
            &["--method", "eiv", "--solver", "qr"],
            "--solver: expected with --method arx only, found another method: it takes --order \
             and --nk",
        ),
        (
            &["--method", "eiv", "--equation-errors", "correlated"],
            "--equation-errors: expected with --method arx only, found another method: it takes \
             --order and --nk",
        ),
    ];
    for (tail, text) in cases {
        let out = ["--order", "2", "--sample-time", "1", "--out", "m.json"];
        place.refused_exactly(&[&HEAD[..], &out, tail].concat(), text);
    }
    for (tail, text) in [
        (
            ["--ridge", "much"],
            "invalid value 'much' for '--ridge <WEIGHT>'",
        ),
        (["--solver", "svd"], "[possible values: qr, automatic]"),
        (
            ["--equation-errors", "white"],
            "[possible values: uncorrelated, correlated]",
        ),
    ] {
        place.refused(&[&HEAD[..], &["--order", "2"], &tail].concat(), &[text]);
    }
}

/// A line in time that is added to a channel changes the slope that is taken out, and nothing else.
#[test]
fn a_trend_is_taken_out_and_said() {
    let place = Place::new();
    place.write("one.csv", second_order_csv(400, 1));
    let rows = second_order(400, 1);
    let tilted = (0..).zip(&rows).map(|(k, row)| {
        let t = f64::from(k);
        vec![row[0] - 0.01 * t, row[1] + 5.0 + 0.02 * t]
    });
    let tilted: Vec<Vec<f64>> = tilted.collect();
    place.write("tilted.csv", csv("u,y", &tilted));
    let of = |file: &str, more: &[&str]| {
        let args = [
            "identify",
            file,
            "--inputs",
            "u",
            "--outputs",
            "y",
            "--order",
            "2",
        ];
        place.json(&[&args[..], &["--sample-time", "0.5"], more].concat())
    };
    let plain = of(
        "one.csv",
        &["--detrend", "--train", "0:300", "--validate", "300:400"],
    );
    let found = of(
        "tilted.csv",
        &["--detrend", "--train", "0:300", "--validate", "300:400"],
    );
    // Sums of numbers of up to ten, rounded to what the file prints.
    agree(&coefficients(&plain), &coefficients(&found), 1e-9);
    let fit = |report: &Value| number(report, "/outputs/0/fit_simulation_percent");
    assert!((fit(&plain) - fit(&found)).abs() < 1e-6);
    for (channel, added) in [(0, -0.02), (1, 0.04)] {
        let slope = |report: &Value| {
            let place = format!("/records/0/trend/{channel}/per_s");
            number(report, &place)
        };
        assert!((slope(&found) - slope(&plain) - added).abs() < 1e-10);
    }
    assert_eq!(
        found.pointer("/records/0/trend/1/signal"),
        Some(&Value::from("y"))
    );
    // Left in, a drift counts as dynamics.
    let left = of("tilted.csv", &[]);
    assert_eq!(left.pointer("/records/0/trend"), Some(&Value::Null));
    let distance = |report: &Value| -> f64 {
        let pairs = coefficients(report).into_iter().zip(coefficients(&plain));
        pairs.map(|(a, b)| (a - b).abs()).fold(0.0, f64::max)
    };
    assert!(distance(&left) > 1e-3, "{}", distance(&left));
}
