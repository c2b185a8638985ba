//! `gtfdi identify` on several records and on records with gaps.

use serde_json::Value;

use crate::document::{Document, Step, commands};
use crate::place::{Place, array, number, object};
use crate::signal::{arx, csv, second_order, second_order_csv, two_outputs_csv};

/// The same rows in another order of summation.
const TOLERANCE: f64 = 1e-10;
const TAIL: [&str; 6] = ["--inputs", "u", "--outputs", "y", "--order", "2"];

fn identify(place: &Place, records: &[&str], more: &[&str]) -> Value {
    place.json(&[&["identify"], records, &TAIL[..], more].concat())
}

fn numbers(report: &Value, key: &str) -> Vec<f64> {
    let terms = array(report, "/outputs/0/regression").iter();
    terms.map(|term| number(term, &format!("/{key}"))).collect()
}

/// The largest difference of two lists beside the first list's largest.
fn difference(a: &[f64], b: &[f64]) -> f64 {
    assert_eq!(a.len(), b.len());
    let most = a.iter().fold(0.0_f64, |most, value| most.max(value.abs()));
    let pairs = a.iter().zip(b);
    pairs.fold(0.0_f64, |most, (a, b)| most.max((a - b).abs())) / most
}

/// A record twice holds the same equation, and twice as many rows of it: with `T` rows and 4
/// coefficients `s^2 (Phi' Phi)^-1` shrinks by `(T - 4) / (2 T - 4)`.
#[test]
fn a_record_twice_is_the_record_with_smaller_errors() {
    let place = Place::new();
    for name in ["a.csv", "b.csv"] {
        place.write(name, second_order_csv(302, 1));
    }
    let one = identify(&place, &["a.csv"], &[]);
    let two = identify(&place, &["a.csv", "b.csv"], &["--out", "model.json"]);
    let coefficients = [&one, &two].map(|report| numbers(report, "coefficient"));
    assert!(difference(&coefficients[0], &coefficients[1]) < TOLERANCE);
    let errors = [&one, &two].map(|report| numbers(report, "standard_error"));
    let factor = (596.0_f64 / 296.0).sqrt();
    let scaled: Vec<f64> = errors[1].iter().map(|error| factor * error).collect();
    assert!(difference(&errors[0], &scaled) < TOLERANCE);
    // Fits over both are those over one.
    for key in [
        "/outputs/0/fit_prediction_percent",
        "/outputs/0/fit_simulation_percent",
    ] {
        assert!(
            (number(&one, key) - number(&two, key)).abs() < TOLERANCE * 100.0,
            "{key}"
        );
    }
    assert_eq!(array(&two, "/records").len(), 2);
    assert_eq!(two["records"][1]["train_rows"], serde_json::json!([0, 302]));
    assert!(two["train_rows"].is_null() && two["input_sha256"].is_null());
    let file: Value = serde_json::from_slice(&place.read("model.json")).expect("JSON");
    // No row reaches across: two lags are lost in each.
    assert_eq!(file["model"]["rows_used"], 600);
    assert!(file["input_sha256"].is_null());
    let text = place.done(&[&["identify", "a.csv", "b.csv"], &TAIL[..]].concat());
    assert!(
        text.contains("identified on 604 rows of 2 records, validated on 604 rows"),
        "{text}"
    );
}

/// The rows before and after some that are missing are two records.
#[test]
fn missing_samples_break_the_record() {
    let place = Place::new();
    let rows = second_order(300, 1);
    place.write("before.csv", csv("u,y", &rows[..120]));
    place.write("after.csv", csv("u,y", &rows[123..]));
    let apart = identify(
        &place,
        &["before.csv", "after.csv"],
        &["--out", "apart.json"],
    );
    let whole = csv("u,y", &rows);
    let mut lines: Vec<String> = whole.lines().map(str::to_owned).collect();
    for (line, text) in [(121, "NaN,1"), (122, "0.5,"), (123, "nan,")] {
        lines[line] = text.to_owned();
    }
    place.write("holed.csv", lines.join("\n"));
    let args = [
        &["identify", "holed.csv"],
        &TAIL[..],
        &["--missing", "break"],
    ]
    .concat();
    let ran = place.run(&[&args[..], &["--out", "holed.json", "--json"]].concat());
    // The warnings speak of NaN, which `object` takes for a number.
    let holed: Value = serde_json::from_str(&ran.stdout).expect("JSON");
    assert!(
        ran.stderr
            .contains("`y` has 2 samples that are not valid (NaN)"),
        "{}",
        ran.stderr
    );
    let coefficients = [&apart, &holed].map(|report| numbers(report, "coefficient"));
    assert!(difference(&coefficients[0], &coefficients[1]) < TOLERANCE);
    for key in [
        "/outputs/0/fit_prediction_percent",
        "/outputs/0/fit_simulation_percent",
    ] {
        assert!(
            (number(&apart, key) - number(&holed, key)).abs() < TOLERANCE * 100.0,
            "{key}"
        );
    }
    for name in ["apart.json", "holed.json"] {
        let file: Value = serde_json::from_slice(&place.read(name)).expect("JSON");
        assert_eq!(file["model"]["rows_used"], 297 - 4, "{name}");
    }
    // Without the option the cell is named, and what to do.
    place.refused_exactly(
        &[&["identify", "holed.csv"], &TAIL[..]].concat(),
        "holed.csv: line 122, column `u`: expected a finite number, found `NaN`; --missing break \
         fits around it",
    );
    // An infinite value is no missing one.
    lines[121] = "inf,1".to_owned();
    place.write("holed.csv", lines.join("\n"));
    place.refused_exactly(
        &args,
        "holed.csv: line 122, column `u`: expected a finite number, found `inf`",
    );
}

#[test]
fn gaps_in_time_break_the_record() {
    let place = Place::new();
    let rows = second_order(300, 1);
    place.write("before.csv", csv("u,y", &rows[..120]));
    place.write("after.csv", csv("u,y", &rows[120..]));
    let apart = identify(
        &place,
        &["before.csv", "after.csv"],
        &["--sample-time", "0.5"],
    );
    let timed: Vec<Vec<f64>> = rows
        .iter()
        .enumerate()
        .map(|(k, row)| {
            let late = if k < 120 { 0.0 } else { 100.25 };
            vec![0.5 * k as f64 + late, row[0], row[1]]
        })
        .collect();
    place.write("timed.csv", csv("time,u,y", &timed));
    let whole = identify(&place, &["timed.csv"], &["--missing", "break"]);
    assert_eq!(whole["sample_time_s"], 0.5);
    let coefficients = [&apart, &whole].map(|report| numbers(report, "coefficient"));
    assert!(difference(&coefficients[0], &coefficients[1]) < TOLERANCE);
    place.refused(
        &[&["identify", "timed.csv"], &TAIL[..]].concat(),
        &[
            "timed.csv: line 122: expected a step of 0.5 s",
            "; --missing break fits around the gap",
        ],
    );
}

/// A record that runs away after a gap diverges at the time that stands in the file.
#[test]
fn a_free_run_after_a_gap_diverges_at_the_time_of_the_file() {
    let place = Place::new();
    let grows = arx(&[1.3], &[1.0], 0.0, 40, 3);
    place.write("grows.csv", csv("u,y", &grows));
    let noise = second_order(300, 2);
    let timed = |late: f64| -> Vec<Vec<f64>> {
        let rows = noise.iter().enumerate();
        rows.map(|(k, row)| {
            let start = if k < 3 { 0.0 } else { late };
            vec![k as f64 + start, row[0], row[1]]
        })
        .collect()
    };
    let time = |late: f64| {
        place.write("run.csv", csv("time,u,y", &timed(late)));
        let tail = ["--order", "1", "--centre", "zero", "--holdout", "run.csv"];
        let head = ["identify", "grows.csv", "--inputs", "u", "--outputs", "y"];
        let more = ["--missing", "break"];
        let report = place.json(&[&head[..], &tail, &more].concat());
        number(&report, "/diverges_at")
    };
    // The range that the limit is taken from is that of each piece: the first three rows stand in
    // both records apart from the rest.
    let (near, far) = (time(5.0), time(1000.0));
    assert!((far - near - 995.0).abs() < 1e-9, "{near} {far}");
}

#[test]
fn a_holdout_is_validated_on() {
    let place = Place::new();
    let rows = second_order(400, 1);
    place.write("all.csv", csv("u,y", &rows));
    place.write("train.csv", csv("u,y", &rows[..250]));
    place.write("rest.csv", csv("u,y", &rows[250..]));
    let rows = identify(
        &place,
        &["all.csv"],
        &["--train", "0:250", "--validate", "250:400"],
    );
    let files = identify(&place, &["train.csv"], &["--holdout", "rest.csv"]);
    assert_eq!(rows["outputs"], files["outputs"]);
    assert_eq!(rows["residuals"], files["residuals"]);
    assert_eq!(files["holdout"]["data"], "rest.csv");
    assert_eq!(files["validation_rows"], serde_json::json!([0, 150]));
    let text = place.done(
        &[
            &["identify", "train.csv"],
            &TAIL[..],
            &["--holdout", "rest.csv"],
        ]
        .concat(),
    );
    assert!(
        text.contains("validated on rows 0:150 of the hold-out record"),
        "{text}"
    );
}

#[test]
fn orders_are_compared_on_the_longest_record() {
    let place = Place::new();
    place.write("a.csv", second_order_csv(100, 1));
    place.write("b.csv", second_order_csv(600, 2));
    let args = [
        "identify",
        "a.csv",
        "b.csv",
        "--inputs",
        "u",
        "--outputs",
        "y",
    ];
    let ran = place.run(&[&args[..], &["--order", "auto", "--json"]].concat());
    let report = object(&ran.stdout);
    assert_eq!(report["order_table"]["window_rows"], 600 - 12);
    let warning =
        "2 records: orders are compared on the longest of 2 records without a break, 600 rows";
    assert!(ran.stderr.contains(warning), "{}", ran.stderr);
}

#[test]
fn records_that_do_not_belong_together_are_refused() {
    let place = Place::new();
    place.write("a.csv", second_order_csv(100, 1));
    place.write("two.csv", two_outputs_csv(100, 1));
    let timed: Vec<Vec<f64>> = (0..100)
        .zip(second_order(100, 1))
        .map(|(k, row)| vec![0.5 * f64::from(k), row[0], row[1]])
        .collect();
    place.write("timed.csv", csv("time,u,y", &timed));
    let refused = |args: &[&str], text: &str| {
        let out = ["--out", "m.json", "--json"];
        place.refused(&[&["identify"], args, &TAIL[..], &out].concat(), &[text]);
    };
    refused(&["a.csv", "two.csv"], "two.csv: expected a column `u`");
    refused(
        &["a.csv", "timed.csv"],
        "timed.csv: sample time: expected 1 s (the model's), found 0.5 s",
    );
    refused(&["a.csv", "none.csv"], "none.csv: there is no such file");
    refused(
        &["a.csv", "--holdout", "timed.csv"],
        "a.csv: --holdout timed.csv: sample time: expected 1 s (the model's), found 0.5 s",
    );
    refused(
        &["a.csv", "--holdout", "a.csv", "--validate", "0:50"],
        "--holdout: expected without --validate, found both",
    );
    refused(
        &["a.csv", "a.csv", "--train", "0:101"],
        "a.csv: --train: expected rows A:B with B at most 100, found 0:101",
    );
    for method in ["eiv", "frisch"] {
        let text = format!(
            "--method {method}: expected one training record without a break, found 2; plain \
             least squares (--method arx) takes several"
        );
        refused(&["a.csv", "a.csv", "--method", method], &text);
    }
    for option in [&["--stable"][..], &["--dc-gain", "y:u=+"]] {
        let text = format!(
            "{}: expected one training record without a break, found 2",
            option[0]
        );
        refused(&[&["a.csv", "a.csv"], option].concat(), &text);
    }
    // Nothing is left of a record whose every sample lacks a channel.
    place.write("holes.csv", "u,y\n1,\n,2\n3,nan\n");
    refused(
        &["holes.csv", "--missing", "break"],
        "holes.csv: expected samples of all channels, found none",
    );
    refused(
        &["a.csv", "--missing", "never"],
        "[possible values: error, break]",
    );
}

#[test]
fn the_commands_of_the_readme_on_several_records_run() {
    let readme = Document::read("README.md");
    let place = Place::new();
    for (name, seed) in [("monday.csv", 1), ("tuesday.csv", 2), ("friday.csv", 3)] {
        place.write(name, second_order_csv(300, seed));
    }
    let commands = commands(readme.block_with("sh", "monday.csv"));
    assert_eq!(commands.len(), 3, "{commands:?}");
    for command in commands {
        let report = Step::run(&place, command.clone()).report();
        if command.contains("monday.csv") {
            assert_eq!(report["structure"]["full"]["na"], 2);
        } else if command.contains("check") {
            assert_eq!(report["sound"], true, "{}", report["findings"]);
        } else {
            assert_eq!(report["stable"], true);
        }
    }
}
