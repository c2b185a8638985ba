//! `gtfdi identify`: the published regressions, and what a model may do that nobody wants.

use serde_json::Value;

use crate::place::{Place, array, number, reference_data};
use crate::signal::{Noise, arx, csv, second_order, two_outputs_csv};

/// Two independent solvers agree to 1.2e-13 on these regressions; what is left is the conditioning
/// of the records (up to 1e5).
const REGRESSION_TOLERANCE: f64 = 1e-8;
/// The reference fits are rounded to three digits; the rest is for the free runs' accumulation.
const FIT_TOLERANCE_PERCENT: f64 = 0.05;

#[test]
fn published_regressions_and_fits() {
    let test = "published_regressions_and_fits";
    let Some(folder) = reference_data(test) else {
        return;
    };
    let text = std::fs::read(folder.join("arx_reference.json")).expect("arx_reference.json");
    let reference: Value = serde_json::from_slice(&text).expect("JSON");
    let cases = reference["arx"].as_object().expect("cases");
    assert_eq!(cases.len(), 4, "dryer, powerplant, winding, evaporator");
    let place = Place::new();
    let mut compared = 0;
    for (name, case) in cases {
        for structure in ["diag", "full"] {
            let Some(expected) = case.get(structure) else {
                continue;
            };
            let record = folder.join(case["csv"].as_str().expect("a file"));
            let record = record.to_str().expect("a path");
            let report = place.json(&command(record, case, structure));
            let (coefficient, fit) = errors(&report, case, expected);
            println!("{name} {structure}: regression {coefficient:.1e}, fits {fit:.1e} %");
            assert!(coefficient < REGRESSION_TOLERANCE, "{name} {structure}");
            assert!(fit < FIT_TOLERANCE_PERCENT, "{name} {structure}");
            compared += 1;
        }
    }
    assert_eq!(compared, 7, "the dryer has one output and one structure");
}

/// The command of a reference case; `full` is the default structure.
fn command<'a>(record: &'a str, case: &Value, structure: &str) -> Vec<&'a str> {
    let leak = |text: String| -> &'static str { Box::leak(text.into_boxed_str()) };
    let tags = |key: &str| {
        let tags = array(case, key)
            .iter()
            .map(|tag| tag.as_str().expect("a tag"));
        leak(tags.collect::<Vec<_>>().join(","))
    };
    let rows = |key: &str| leak(format!("{}:{}", case[key][0], case[key][1]));
    let lags = |key: &str| leak(case[key].to_string());
    let mut args = vec![
        "identify",
        record,
        "--inputs",
        tags("/u"),
        "--outputs",
        tags("/y"),
    ];
    args.extend([
        "--method",
        "arx",
        "--na",
        lags("na"),
        "--nb",
        lags("nb"),
        "--nk",
        lags("nk"),
    ]);
    args.extend(["--train", rows("train"), "--validate", rows("val")]);
    if structure == "diag" {
        args.extend(["--structure", "diag"]);
    }
    args
}

/// The largest error of a coefficient (relative to the row's largest) and of a fit in per cent.
fn errors(report: &Value, case: &Value, expected: &Value) -> (f64, f64) {
    let (mut coefficient, mut fit) = (0.0_f64, 0.0_f64);
    let outputs = array(report, "/outputs");
    assert_eq!(outputs.len(), array(case, "/y").len());
    for (index, output) in outputs.iter().enumerate() {
        assert_eq!(output["name"], case["y"][index]);
        let (found, wanted) = (array(output, "/regression"), &expected["regression"][index]);
        let wanted = wanted.as_array().expect("terms");
        assert_eq!(found.len(), wanted.len());
        let scale = wanted
            .iter()
            .map(|term| number(term, "/coefficient").abs())
            .fold(0.0, f64::max);
        for term in wanted {
            let same = |other: &&Value| {
                ["signal", "lag"]
                    .iter()
                    .all(|key| other[*key] == term[*key])
            };
            let found = found.iter().find(same).expect("the term");
            let error = number(found, "/coefficient") - number(term, "/coefficient");
            coefficient = coefficient.max(error.abs() / scale);
        }
        for (ours, theirs) in [
            ("fit_prediction_percent", "fit_pred"),
            ("fit_simulation_percent", "fit_sim"),
            ("ppcre_percent", "ppre_pred"),
            ("ppcre_simulation_percent", "ppre_sim"),
        ] {
            let wanted = expected[theirs][index].as_f64();
            let found = output[ours].as_f64();
            match (found, wanted) {
                (Some(found), Some(wanted)) => fit = fit.max((found - wanted).abs()),
                (found, wanted) => assert_eq!(found, wanted, "{ours}"),
            }
        }
    }
    (coefficient, fit)
}

/// Without noise the regression is exact but for the means: those of the whole record are removed,
/// those of its lagged parts differ by the rows at the ends.
#[test]
fn a_known_system_comes_back() {
    const TOLERANCE: f64 = 1e-3;
    let place = Place::new();
    let rows = arx(&[1.5, -0.7], &[1.0, 0.5], 0.0, 300, 3);
    place.write("one.csv", csv("u,y", &rows));
    let head = ["identify", "one.csv", "--inputs", "u", "--outputs", "y"];
    let report = place.json(&[&head[..], &["--na", "2", "--nb", "2", "--out", "m.json"]].concat());
    let terms = array(&report, "/outputs/0/regression");
    let expected = [("y", 1, 1.5), ("y", 2, -0.7), ("u", 1, 1.0), ("u", 2, 0.5)];
    assert_eq!(terms.len(), expected.len());
    for (term, (signal, lag, value)) in terms.iter().zip(expected) {
        assert_eq!(
            (&term["signal"], &term["lag"]),
            (&signal.into(), &lag.into())
        );
        let error = number(term, "/coefficient") - value;
        assert!(error.abs() < TOLERANCE, "{term}");
    }
    assert_eq!(report["method"], "arx");
    assert_eq!(report["train_rows"], serde_json::json!([0, 300]));
    assert_eq!(report["out"], "m.json");
    // |poles| = sqrt(0.7)
    assert!((number(&report, "/spectral_radius") - 0.7_f64.sqrt()).abs() < TOLERANCE);
    let model: Value = serde_json::from_slice(&place.read("m.json")).expect("JSON");
    assert_eq!(model["input_sha256"], report["input_sha256"]);
}

/// `y(t) = 1.3 y(t - 1) + u(t - 1)` while it is trained, bounded noise while it is validated: the
/// free run grows as 1.3^t. That is a result, not a failure: it is said in words and numbers.
#[test]
fn a_free_run_that_diverges_has_no_fit() {
    let place = Place::new();
    let mut noise = Noise::new(5);
    let mut rows = vec![vec![0.0, 0.1]];
    for t in 1..1000 {
        let y = if t < 40 {
            1.3 * rows[t - 1][1] + rows[t - 1][0]
        } else {
            noise.next()
        };
        rows.push(vec![noise.next(), y]);
    }
    place.write("grows.csv", csv("u,y", &rows));
    let args = [
        "identify",
        "grows.csv",
        "--inputs",
        "u",
        "--outputs",
        "y",
        "--order",
        "1",
    ];
    let args = [&args[..], &["--train", "0:40", "--validate", "40:1000"]].concat();
    let report = place.json(&args);
    assert!(number(&report, "/outputs/0/regression/0/coefficient") > 1.2);
    assert!(number(&report, "/spectral_radius") > 1.2);
    let output = &report["outputs"][0];
    for key in [
        "fit_simulation_percent",
        "ppcre_simulation_percent",
        "sse_simulation",
    ] {
        assert!(output[key].is_null(), "{key}: {}", output[key]);
    }
    assert!(number(output, "/fit_prediction_percent").is_finite());
    // In the record's own time, one sample a second, and within the rows that are validated on.
    let time = number(output, "/diverges_at_s");
    assert!(time > 40.0 && time < 1000.0, "{time}");
    assert_eq!(report["diverges_at"], time);
    assert_eq!(report["stable"], false);
    let text = place.done(&args);
    assert!(text.contains(&format!("diverges at {time:.2} s")), "{text}");
    assert!(
        text.contains("the model is not stable: its largest pole has modulus 1."),
        "{text}"
    );
    assert!(
        text.contains("--stable keeps poles inside the unit circle"),
        "{text}"
    );
    assert!(!text.contains("NaN") && !text.contains("nan"), "{text}");
}

#[test]
fn several_outputs_are_canonical_by_order_or_indices() {
    let place = Place::new();
    place.write("two.csv", two_outputs_csv(500, 1));
    let head = ["identify", "two.csv", "--inputs", "u*", "--outputs", "y*"];
    let canonical = |tail: &[&str]| {
        let report = place.json(&[&head[..], tail].concat());
        report["structure"]["canonical"].clone()
    };
    for (tail, indices, feedthrough) in [
        (vec!["--order", "4"], [2, 2], false),
        (vec!["--order", "3"], [2, 1], false),
        (vec!["--indices", "2,2"], [2, 2], false),
        (vec!["--indices", "1,3", "--nk", "0"], [1, 3], true),
        (
            vec!["--structure", "canonical", "--order", "auto"],
            [2, 2],
            false,
        ),
    ] {
        let found = canonical(&tail);
        assert_eq!(found["indices"], serde_json::json!(indices), "{tail:?}");
        assert_eq!(found["feedthrough"], feedthrough, "{tail:?}");
    }
    // Lags are full unless the structure is named, and so is the order of a single output.
    let report = place.json(&[&head[..], &["--na", "2", "--nb", "2"]].concat());
    assert_eq!(report["structure"]["full"]["nk"], serde_json::json!([1]));
    assert_eq!(array(&report, "/outputs/0/regression").len(), 8);
    let one = [
        "identify",
        "two.csv",
        "--inputs",
        "u1",
        "--outputs",
        "y1",
        "--order",
        "2",
    ];
    let report = place.json(&one);
    assert_eq!(report["structure"]["full"]["na"], 2);
    let full = ["--structure", "full", "--order", "2"];
    let report = place.json(&[&head[..], &full].concat());
    assert_eq!(report["structure"]["full"]["na"], 2);
}

#[test]
fn validation_rows_may_stand_before_the_training_rows() {
    let place = Place::new();
    place.write("one.csv", csv("u,y", &second_order(300, 2)));
    let head = [
        "identify",
        "one.csv",
        "--inputs",
        "u",
        "--outputs",
        "y",
        "--order",
        "2",
    ];
    let rows = ["--train", "100:300", "--validate", "20:90"];
    let report = place.json(&[&head[..], &rows].concat());
    assert_eq!(report["train_rows"], serde_json::json!([100, 300]));
    assert_eq!(report["validation_rows"], serde_json::json!([20, 90]));
    // The same blocks by hand.
    place.write("train.csv", csv("u,y", &second_order(300, 2)[100..]));
    let alone = [
        "identify",
        "train.csv",
        "--inputs",
        "u",
        "--outputs",
        "y",
        "--order",
        "2",
    ];
    let alone = place.json(&alone);
    assert_eq!(
        report["outputs"][0]["regression"],
        alone["outputs"][0]["regression"]
    );
}
