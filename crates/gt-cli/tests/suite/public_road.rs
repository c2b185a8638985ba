//! The road on a public record: the Tennessee Eastman process, which has no time column.

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
