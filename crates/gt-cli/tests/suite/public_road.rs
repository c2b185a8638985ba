//! The road on a public record: the Tennessee Eastman process, which has no time column; the second
//! test is what `docs/tennessee_eastman.md` says.

use serde_json::Value;

use crate::place::{Place, array, number, reference_data};

/// Faults of the set begin after eight hours.
const ONSET_ROW: f64 = 160.0;
const SAMPLE_TIME_S: f64 = 180.0;

#[test]
fn faults_of_the_tennessee_eastman_process_are_found() {
    let Some(folder) = reference_data("faults_of_the_tennessee_eastman_process_are_found") else {
        return;
    };
    let place = Place::new();
    let record = |name: &str| {
        folder
            .join("tep")
            .join(name)
            .to_str()
            .expect("a path")
            .to_owned()
    };
    let (normal, test) = (record("d00.csv"), record("d00_te.csv"));
    let identify = [
        "identify",
        &normal,
        "--inputs",
        "xmv*",
        "--outputs",
        "xmeas4,xmeas22",
        "--structure",
        "diag",
        "--na",
        "2",
        "--nb",
        "2",
        "--sample-time",
        "180",
        "--out",
        "model.json",
    ];
    let model = place.json(&identify);
    assert_eq!(model["sample_time_s"], SAMPLE_TIME_S);
    assert_eq!(array(&model, "/outputs").len(), 2);
    // The sample time of design and detect is the model's: the records have none.
    let limit = [
        "--exceedance",
        "0.01",
        "--consecutive",
        "6",
        "--poles",
        "0.5",
    ];
    let design = [
        "design",
        "--model",
        "model.json",
        "--healthy",
        &normal,
        "--out",
        "bank.json",
    ];
    place.json(&[&design[..], &limit].concat());
    let detect =
        |name: &str| -> Value { place.json(&["detect", &record(name), "--bank", "bank.json"]) };
    for (name, tag) in [("d01_te.csv", "xmeas4"), ("d05_te.csv", "xmeas22")] {
        let report = detect(name);
        assert_eq!(report["samples"], 960);
        assert_eq!(report["sample_time_s"], SAMPLE_TIME_S);
        let mut alarms = array(&report, "/alarms").iter();
        let alarm = alarms.find(|alarm| alarm["tag"] == tag);
        let row = number(alarm.expect(name), "/time_s") / SAMPLE_TIME_S;
        println!(
            "{name}: {} alarms, first on {tag} at row {row}",
            array(&report, "/alarms").len()
        );
        assert!(row >= ONSET_ROW, "{name}: row {row}");
    }
    let report = place.json(&["detect", &test, "--bank", "bank.json"]);
    println!("d00_te.csv: {} alarms", array(&report, "/alarms").len());
}

/// One setting for all faults, from the normal record alone: what is asked of it, and no more than
/// 2.2 % of the samples of a fresh normal record above a limit that was set at 1 %.
#[test]
fn faults_are_found_in_time_by_all_channels_together() {
    let Some(folder) = reference_data("faults_are_found_in_time_by_all_channels_together") else {
        return;
    };
    let place = Place::new();
    let record = |name: &str| {
        let path = folder.join("tep").join(name);
        path.to_str().expect("a path").to_owned()
    };
    let normal = record("d00.csv");
    let identify = [
        "identify",
        &normal,
        "--outputs",
        "xmeas*,xmv*",
        "--structure",
        "full",
        "--order",
        "1",
        "--ridge",
        "0.1",
        "--sample-time",
        "180",
        "--out",
        "model.json",
    ];
    place.json(&identify);
    let design = [
        "design",
        "--model",
        "model.json",
        "--healthy",
        &normal,
        "--generator",
        "kalman",
        "--watch",
        "joint",
        "--exceedance",
        "0.01",
        "--consecutive",
        "6",
        "--out",
        "bank.json",
    ];
    let designed = place.json(&design);
    let warnings = array(&designed, "/warnings");
    let own = |warning: &Value| {
        let text = warning.as_str().expect("a text");
        text.contains("the model was identified from this record")
    };
    assert!(warnings.iter().any(own), "{warnings:?}");
    let share = number(&designed, "/detectors/0/exceedance_share_cross_validated");
    // One sample in a hundred of 499, to the sample.
    assert!((share - 0.01).abs() < 1.0 / 499.0, "{share}");
    let detect = |name: &str, rows: &str| {
        let args = [
            "detect",
            &record(name),
            "--bank",
            "bank.json",
            "--rows",
            rows,
        ];
        place.json(&args)
    };
    let fresh = detect("d00_te.csv", "0:960");
    assert!(array(&fresh, "/alarms").is_empty(), "{fresh}");
    let share = number(&fresh, "/outputs/0/exceedance_share");
    assert!(share <= 0.022, "{share}");
    for (name, minutes, flagged) in [
        ("d01_te.csv", 12.0, 0.9),
        ("d05_te.csv", 30.0, 0.9),
        ("d11_te.csv", 150.0, 0.5),
    ] {
        let report = detect(name, "0:960");
        let first = array(&report, "/alarms").first().expect(name);
        assert_eq!(first["tag"], "joint");
        let row = number(first, "/first_exceedance_s") / SAMPLE_TIME_S;
        let delay = (row - ONSET_ROW) * SAMPLE_TIME_S / 60.0;
        println!("{name}: {delay} min after the onset");
        assert!(delay >= 0.0 && delay <= minutes, "{name}: {delay} min");
        let after = detect(name, "160:960");
        let share = number(&after, "/outputs/0/exceedance_share");
        assert!(share >= flagged, "{name}: {share}");
    }
}
