//! The road of the command line: simulate, identify, design, detect.

use std::sync::OnceLock;

use serde_json::Value;

use crate::place::{Place, array, number};

const ONSET_S: f64 = 60.0;
const IDENTIFY: [&str; 13] = [
    "identify",
    "train.mcap",
    "--inputs",
    "a_v,M_f",
    "--outputs",
    "q_c,t3",
    "--order",
    "8",
    "--structure",
    "diag",
    "--nk",
    "1,0",
    "--json",
];

/// Two healthy records for the design, one that no model saw, and one with a drift of t3; the
/// model and its bank.
fn place() -> &'static Place {
    static PLACE: OnceLock<Place> = OnceLock::new();
    PLACE.get_or_init(|| {
        let place = Place::new();
        let fault = "[[fault]]\ncase = \"thermocouple_drift\"\nrate_percent_per_h = 20.0\n";
        place.write("faults.toml", format!("{fault}onset_s = {ONSET_S:.1}\n"));
        for (out, tail) in [
            ("train.mcap", &["--seed", "1"][..]),
            ("second.mcap", &["--seed", "2"]),
            ("fresh.mcap", &["--seed", "3"]),
            ("faulty.mcap", &["--seed", "4", "--faults", "faults.toml"]),
        ] {
            let args = ["simulate", "--seconds", "400", "--out", out];
            place.done(&[&args[..], tail].concat());
        }
        place.done(&[&IDENTIFY[..], &["--out", "model.json"]].concat());
        let healthy = ["--healthy", "train.mcap", "--healthy", "second.mcap"];
        let design = ["design", "--model", "model.json", "--out", "bank.json"];
        place.done(&[&design[..], &healthy, &["--margin", "1.2"]].concat());
        place
    })
}

fn tags(report: &Value) -> Vec<&str> {
    let alarms = array(report, "/alarms").iter();
    alarms
        .map(|alarm| alarm["tag"].as_str().expect("a tag"))
        .collect()
}

#[test]
fn a_drift_of_t3_lights_t3_after_its_onset() {
    let place = place();
    let args = [
        "detect",
        "faulty.mcap",
        "--bank",
        "bank.json",
        "--out",
        "faulty-verdicts.mcap",
    ];
    let report = place.json(&args);
    let tags = tags(&report);
    assert!(
        !tags.is_empty() && tags.iter().all(|tag| *tag == "t3"),
        "{tags:?}"
    );
    let alarm = &report["alarms"][0];
    assert!(number(alarm, "/time_s") > ONSET_S, "{alarm}");
    assert!(number(alarm, "/statistic") > number(alarm, "/threshold"));
    for key in ["fault", "onset_s", "magnitude", "probability"] {
        assert!(alarm[key].is_null(), "{key} is not estimated yet");
    }
    assert_eq!(report["samples"], 5000);
    let text = place.done(&["detect", "faulty.mcap", "--bank", "bank.json"]);
    assert!(text.contains("t3"), "{text}");

    let info = place.json(&["log", "info", "faulty-verdicts.mcap"]);
    let messages = |name: &str| {
        let mut topics = array(&info, "/topics").iter();
        let topic = topics.find(|topic| topic["topic"] == name).expect(name);
        topic["messages"].as_u64().expect("a number")
    };
    assert_eq!(messages("/fdi/observers/residual"), 5000);
    assert!(messages("/alarms") >= tags.len() as u64);
    assert_eq!(
        array(&info, "/attachments")[0]["name"],
        "models/observers.json"
    );
    let data = array(&info, "/metadata")
        .iter()
        .find(|m| m["name"] == "gtfdi.data");
    assert_eq!(
        data.expect("gtfdi.data")["values"]["input_sha256"],
        report["input_sha256"]
    );
}

#[test]
fn a_fresh_healthy_record_has_no_alarm() {
    let report = place().json(&["detect", "fresh.mcap", "--bank", "bank.json"]);
    assert_eq!(tags(&report), [""; 0]);
    let text = place().done(&["detect", "fresh.mcap", "--bank", "bank.json"]);
    assert!(text.ends_with("no alarm\n"), "{text}");
}

#[test]
fn fail_on_alarm_ends_with_3_and_the_whole_report() {
    let detect = |record: &str, tail: &[&str]| {
        let args = ["detect", record, "--bank", "bank.json", "--json"];
        place().run(&[&args[..], tail].concat())
    };
    let fail = ["--fail-on", "alarm"];
    let (with, without) = (detect("faulty.mcap", &fail), detect("faulty.mcap", &[]));
    assert_eq!((with.code, without.code), (3, 0));
    assert_eq!(with.stdout, without.stdout);
    assert_eq!(detect("fresh.mcap", &fail).code, 0);
    // Before the onset the faulty record is healthy.
    let before = ["--rows", "0:700", "--fail-on", "alarm"];
    assert_eq!(detect("faulty.mcap", &before).code, 0);
}

#[test]
fn a_design_by_exceedance_reports_its_false_alarms() {
    let place = place();
    let design = [
        "design",
        "--model",
        "model.json",
        "--healthy",
        "train.mcap,second.mcap",
    ];
    let limit = [
        "--exceedance",
        "0.01",
        "--consecutive",
        "6",
        "--out",
        "share.json",
    ];
    let report = place.json(&[&design[..], &limit].concat());
    assert_eq!(report["healthy_records"], 2);
    for (detector, (output, pole)) in array(&report, "/detectors")
        .iter()
        .zip([("q_c", 0.7), ("t3", 0.3)])
    {
        assert_eq!(detector["output"], output);
        // Section 5 of the paper: one pole an output, for each of the 8 states.
        assert_eq!(detector["poles"], serde_json::json!(vec![pole; 8]));
        assert_eq!(detector["consecutive"], 6);
        let rate = &detector["false_alarms_cross_validated"];
        let (low, high) = (
            number(rate, "/per_hour_low"),
            number(rate, "/per_hour_high"),
        );
        assert!((low..=high).contains(&number(rate, "/per_hour")), "{rate}");
    }
    // A bank with another limit on the same generator says more.
    let report = place.json(&["detect", "faulty.mcap", "--bank", "share.json"]);
    assert!(tags(&report).contains(&"t3"));
}

/// Silence of an observer that never settled is not health, and is said.
#[test]
fn an_output_that_was_never_judged_is_named() {
    let place = place();
    let args = ["detect", "fresh.mcap", "--bank", "bank.json"];
    let short = place.json(&[&args[..], &["--rows", "0:5"]].concat());
    assert_eq!(short["outputs"][0]["judged_samples"], 0);
    let warnings = array(&short, "/warnings");
    let never = |tag: &str| {
        warnings.iter().any(|warning| {
            let text = warning.as_str().expect("a text");
            text.starts_with(&format!("`{tag}` was never judged"))
        })
    };
    assert!(never("q_c") && never("t3"), "{warnings:?}");
    let whole = place.json(&args);
    assert_eq!(array(&whole, "/warnings").len(), 0);
    assert!(number(&whole, "/outputs/0/judged_samples") > 4000.0);
}

/// Eight poles at 0.95 amplify the model's error by 1 / 0.05^8: the limit is of no use.
#[test]
fn a_limit_beyond_the_output_is_warned_of() {
    let place = place();
    let args = [
        "design",
        "--model",
        "model.json",
        "--healthy",
        "second.mcap",
    ];
    let design = |pole| {
        let tail = ["--poles", pole, "--out", "other.json"];
        place.json(&[&args[..], &tail].concat())
    };
    let slow = design("0.95");
    let text = slow["warnings"][0].as_str().expect("a warning");
    assert!(
        text.contains("beyond the output's whole healthy range"),
        "{text}"
    );
    assert_eq!(array(&design("0.4"), "/warnings").len(), 0);
}
