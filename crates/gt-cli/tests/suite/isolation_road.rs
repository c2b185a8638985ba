//! From records to the name of a fault: `design --faults` and `detect` with an isolator.

use std::sync::OnceLock;

use serde_json::Value;

use crate::place::{Place, array, number};
use crate::report_page;
use crate::signal::{Noise, csv};

const SAMPLE_TIME_S: f64 = 0.1;
/// Faults grow from here for a minute, then stay.
const ONSET_S: f64 = 200.0;
const RISE_S: f64 = 60.0;
const TIME: [&str; 2] = ["--sample-time", "0.1"];

const FAULTS: &str = r#"
[[fault]]
name = "sensor a"
unit = "K"
both_signs = true
changes = { a = 1.0 }

[[fault]]
name = "leak"
[[fault.pair]]
healthy = "clean.csv"
faulty = "leaking.csv"
course = [[200, 0.0], [260, 2.0]]

[[fault]]
name = "valve"
actuator = "u"
"#;

/// One tank with three sensors: a sensor that is off by `sensor`, a leak of `leak` that two of them
/// see, a valve that lags its demand by `lag_s`; all grown evenly over [`RISE_S`].
fn record(seed: u64, rows: usize, sensor: f64, leak: f64, lag_s: f64) -> String {
    let mut source = Noise::new(seed);
    let (mut demand, mut short, mut x) = (0.0, 0.0, 0.0);
    let mut table = Vec::with_capacity(rows);
    for t in 0..rows {
        let time_s = t as f64 * SAMPLE_TIME_S;
        let growth = ((time_s - ONSET_S) / RISE_S).clamp(0.0, 1.0);
        let before = demand;
        demand = 0.97 * demand + source.next();
        let lag = growth * lag_s;
        let decay = (-SAMPLE_TIME_S / f64::max(lag, 1e-9)).exp();
        short = decay * short + (demand - before);
        let position = demand - short * lag * (1.0 - decay) / SAMPLE_TIME_S;
        let mut measured = |value: f64| value + 0.1 * source.next();
        table.push(vec![
            demand,
            measured(x + growth * sensor),
            measured(0.5 * x + growth * leak),
            measured(-0.8 * x + 0.7 * growth * leak),
        ]);
        x = 0.95 * x + 0.05 * position;
    }
    csv("u,a,b,c", &table)
}

/// Records and a model with its noise, where the isolator of all tests is made.
fn place() -> &'static Place {
    static PLACE: OnceLock<Place> = OnceLock::new();
    PLACE.get_or_init(|| furnished(6))
}

/// A folder of its own with so many healthy records: nobody else writes while a refusal is checked.
fn furnished(records: u64) -> Place {
    let place = Place::new();
    place.write("train.csv", record(1, 6000, 0.0, 0.0, 0.0));
    for healthy in 0..records {
        let name = format!("healthy{healthy}.csv");
        place.write(&name, record(10 + healthy, 36_000, 0.0, 0.0, 0.0));
    }
    place.write("clean.csv", record(2, 4000, 0.0, 0.0, 0.0));
    place.write("leaking.csv", record(2, 4000, 0.0, 2.0, 0.0));
    place.write("faults.toml", FAULTS);
    place.write("sensor.csv", record(3, 5000, -0.08, 0.0, 0.0));
    place.write("leak.csv", record(4, 5000, 0.0, 0.06, 0.0));
    place.write("valve.csv", record(5, 5000, 0.0, 0.0, 0.6));
    let channels = ["--inputs", "u", "--outputs", "a,b,c"];
    let files = ["identify", "train.csv", "--out", "model.json"];
    let method = ["--method", "eiv", "--order", "1"];
    place.done(&[&files[..], &channels, &method, &TIME].concat());
    place
}

const HEALTHY: &str =
    "healthy0.csv,healthy1.csv,healthy2.csv,healthy3.csv,healthy4.csv,healthy5.csv";

fn design<'a>(faults: &'a str, healthy: &'a str, out: &'a str, more: &[&'a str]) -> Vec<&'a str> {
    let head = ["design", "--model", "model.json", "--healthy", healthy];
    let kalman = ["--generator", "kalman", "--faults", faults, "--out", out];
    [&head[..], &kalman, &TIME, more].concat()
}

fn isolator() -> &'static Value {
    static REPORT: OnceLock<Value> = OnceLock::new();
    REPORT.get_or_init(|| {
        let args = design("faults.toml", HEALTHY, "isolator.json", &["--arl0", "2h"]);
        place().json(&args)
    })
}

#[test]
fn a_design_says_what_each_fault_does_and_what_its_limit_promises() {
    let report = isolator();
    let faults = array(report, "/faults");
    let names: Vec<&Value> = faults.iter().map(|fault| &fault["name"]).collect();
    assert_eq!(names, ["sensor a", "leak", "valve"]);
    // The leak was learned: nothing in a, 1 in b, 0.7 in c, to the accuracy of the model's gain.
    for (tag, expected) in [("a", 0.0), ("b", 1.0), ("c", 0.7)] {
        let found = number(&faults[1], &format!("/effect/changes/{tag}"));
        assert!((found - expected).abs() < 0.05, "{tag}: {found}");
    }
    assert_eq!(faults[2]["effect"]["input"], "u");
    assert_eq!(faults[2]["unit"], "s");
    for fault in faults {
        // Four statistics share one false alarm in two hours.
        let asked = number(fault, "/mean_time_between_false_alarms/asked_hours");
        assert!((asked - 8.0).abs() < 1e-9, "{asked}");
        assert!(number(fault, "/limit") > 0.0);
    }
}

#[test]
fn detect_names_sizes_and_dates_faults_and_logs_its_diagnoses() {
    isolator();
    for (data, fault, size, tolerance) in [
        ("sensor.csv", "sensor a", -0.08, 0.15),
        ("leak.csv", "leak", 0.06, 0.15),
        ("valve.csv", "valve", 0.6, 0.2),
    ] {
        let args = [
            "detect",
            data,
            "--bank",
            "isolator.json",
            "--out",
            "said.mcap",
            "--report",
            "said",
        ];
        let report = place().json(&[&args[..], &TIME].concat());
        let alarm = &array(&report, "/alarms")[0];
        assert_eq!(alarm["fault"], fault, "{alarm}");
        assert_eq!(alarm["finding"], "named");
        assert!(number(alarm, "/probability") >= 0.99);
        // Within the interval that the design's tolerance of directions gives.
        let found = number(alarm, "/magnitude");
        assert!((found / size - 1.0).abs() < tolerance, "{data}: {found}");
        let onset = |end: usize| {
            let own = array(alarm, "/hypotheses").iter();
            let own = own
                .clone()
                .find(|own| own["fault"] == fault)
                .expect("the fault");
            number(own, &format!("/onset_interval_s/{end}"))
        };
        assert!(onset(0) <= ONSET_S && ONSET_S <= onset(1), "{alarm}");
        assert!(number(alarm, "/time_s") > ONSET_S);
        let html = report_page::page(place(), "said");
        assert!(html.contains(&format!("1. {fault}: from ")), "{fault}");
        let info = place().json(&["log", "info", "said.mcap"]);
        let topics = array(&info, "/topics").iter();
        let topics: Vec<&str> = topics.filter_map(|topic| topic["topic"].as_str()).collect();
        for topic in ["/alarms", "/fdi/diagnosis", "/fdi/filters/statistic"] {
            assert!(topics.contains(&topic), "{topics:?}");
        }
        let text = place().done(&[&args[..4], &TIME].concat());
        assert!(text.contains(fault) && text.contains("since s"), "{text}");
    }
    // Healthy records of which the limits know nothing: silence.
    place().write("new.csv", record(99, 6000, 0.0, 0.0, 0.0));
    let args = ["detect", "new.csv", "--bank", "isolator.json"];
    let report = place().json(&[&args[..], &TIME].concat());
    assert_eq!(array(&report, "/alarms").len(), 0, "{report}");
    assert_eq!(report["samples"], 6000);
}

#[test]
fn what_is_wrong_with_faults_is_named() {
    let place = furnished(1);
    let cases = [
        ("", "expected at least one `[[fault]]`"),
        ("[[fault]]\nname = \"f\"\n", "fault `f`: expected `changes`"),
        (
            "[[fault]]\nname = \"f\"\nchanges = { a = 1.0 }\nactuator = \"u\"\n",
            "fault `f`: expected `changes`, `actuator` or a `pair` of records, found both",
        ),
        (
            "[[fault]]\nname = \"f\"\nchange = { a = 1.0 }\n",
            "unknown field `change`",
        ),
        (
            "[[fault]]\nname = \"f\"\nchanges = { z = 1.0 }\n",
            "bad.toml: record: expected the channels z, found only a, b, c",
        ),
        (
            "[[fault]]\nname = \"f\"\nactuator = \"w\"\n",
            "bad.toml: record: expected the channels w, found only u",
        ),
        (
            "[[fault]]\nname = \"f\"\n[[fault.pair]]\nhealthy = \"clean.csv\"\n\
             faulty = \"sensor.csv\"\ncourse = [[0, 1]]\n",
            "sensor.csv: fault `f`: expected the 4000 samples of clean.csv, found 5000",
        ),
        (
            "[[fault]]\nname = \"f\"\n[[fault.pair]]\nhealthy = \"clean.csv\"\n\
             faulty = \"leaking.csv\"\ncourse = [[9, 1], [3, 1]]\n",
            "fault `f`, course of a pair: expected ascending times, found 3 after 9",
        ),
        (
            "[[fault]]\nname = \"f\"\n[[fault.pair]]\nhealthy = \"clean.csv\"\n\
             faulty = \"clean.csv\"\ncourse = [[0, 0], [9, 1]]\n",
            "fault `f`:",
        ),
        (
            "[[fault]]\nname = \"f\"\n[[fault.pair]]\nhealthy = \"absent.csv\"\n\
             faulty = \"clean.csv\"\ncourse = [[0, 0], [9, 1]]\n",
            "absent.csv: there is no such file",
        ),
    ];
    for (text, expected) in cases {
        place.write("bad.toml", text);
        let args = design("bad.toml", "healthy0.csv", "never.json", &[]);
        place.refused(&args, &[expected]);
    }
    for (more, expected) in [
        (
            &["--margin", "1.2"][..],
            "--margin: expected without --faults",
        ),
        (
            &["--statistic", "cusum"],
            "--statistic: expected without --faults",
        ),
        (&["--arl0", "soon"], "--arl0: expected a positive time"),
        (&["--longest", "0s"], "--longest: expected a positive time"),
        (&["--limiter", "-1"], "--limiter: "),
        (&["--confidence", "1.5"], "--confidence: "),
        // An hour has too few peaks for a day.
        (&["--arl0", "24h"], "--healthy: "),
    ] {
        let args = design("faults.toml", "healthy0.csv", "never.json", more);
        place.refused(&args, &[expected]);
    }
    let head = [
        "design",
        "--model",
        "model.json",
        "--healthy",
        "healthy0.csv",
    ];
    let tail = ["--out", "never.json", "--confidence", "0.9"];
    place.refused(
        &[&head[..], &TIME, &tail].concat(),
        &["--confidence: expected with --faults"],
    );
}

/// A pair with samples that one of its records misses is several pairs: what the leak does is
/// learned all the same. Healthy records are split too.
#[test]
fn pairs_that_miss_samples_are_learned_from() {
    let place = furnished(6);
    let without = |text: String, rows: [usize; 3]| {
        let lines = text.lines().enumerate();
        let mended = lines.map(|(line, text)| {
            if rows.contains(&line) {
                "Bad,Bad,Bad,Bad\n".to_owned()
            } else {
                format!("{text}\n")
            }
        });
        mended.collect::<String>()
    };
    let leaking = record(2, 4000, 0.0, 2.0, 0.0);
    place.write("leaking.csv", without(leaking, [901, 2300, 2301]));
    let healthy = record(10, 36_000, 0.0, 0.0, 0.0);
    place.write("healthy0.csv", without(healthy, [500, 7000, 20_000]));
    let args = design("faults.toml", HEALTHY, "isolator.json", &["--arl0", "2h"]);
    place.refused(&args, &["healthy0.csv: line 501", "--missing break"]);
    let report = place.json_of_missing(&[&args[..], &["--missing", "break"]].concat());
    assert_eq!(report["healthy_records"], 6 + 3);
    for (tag, expected) in [("a", 0.0), ("b", 1.0), ("c", 0.7)] {
        let found = number(&report, &format!("/faults/1/effect/changes/{tag}"));
        assert!((found - expected).abs() < 0.05, "{tag}: {found}");
    }
}
