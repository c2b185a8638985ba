//! The walk-throughs of `docs`, run as they are printed: the numbers of their tables are what the
//! binary reports.

use std::path::{Path, PathBuf};

use serde_json::Value;

use crate::document::{Document, Step, is_printed};
use crate::place::{Place, array, number, reference_data};
use crate::report_page;

/// A place with some public records under their own names.
fn place_with(records: &[&Path]) -> Place {
    let place = Place::new();
    for record in records {
        let name = record.file_name().expect("a name").to_str().expect("text");
        place.write(name, std::fs::read(record).expect(name));
    }
    place
}

/// The report of the one command that ends so.
fn report(steps: &[Step], end: &str) -> Value {
    let mut found = steps.iter().filter(|step| step.command.ends_with(end));
    let step = found
        .next()
        .unwrap_or_else(|| panic!("no command `..{end}`"));
    assert!(found.next().is_none(), "two commands `..{end}`");
    step.report()
}

/// The row of the file at a time that a report tells.
fn row(report: &Value, pointer: &str) -> f64 {
    (number(report, pointer) / number(report, "/sample_time_s")).round()
}

/// The first alarm of a report, or none: its place.
fn first_alarm(report: &Value) -> Option<&Value> {
    array(report, "/alarms").first()
}

/// What is asked of the process's set: alarms in time, and no more than 2.2 % of the samples of a
/// fresh normal record above a limit that was set at 1 %.
#[test]
fn the_tennessee_eastman_walk_through_is_true() {
    const ONSET_ROW: f64 = 160.0;
    let Some(folder) = reference_data("the_tennessee_eastman_walk_through_is_true") else {
        return;
    };
    let names = ["d00", "d00_te", "d01_te", "d05_te", "d11_te"];
    let paths = names.map(|name| folder.join("tep").join(format!("{name}.csv")));
    let place = place_with(&paths.each_ref().map(PathBuf::as_path));
    let document = Document::read("docs/tennessee_eastman.md");
    let steps = document.run_in(&place);

    let design = report(&steps, "--out bank.json");
    let warnings = array(&design, "/warnings");
    let own = |warning: &&Value| {
        let text = warning.as_str().expect("a text");
        text.contains("the model was identified from this record")
    };
    let own = warnings.iter().find(own).expect("a warning");
    assert!(own.to_string().contains("up to 1.110 times"), "{own}");
    let share = number(&design, "/detectors/0/exceedance_share_cross_validated");
    // One sample in a hundred of 499, to the sample.
    assert!((share - 0.01).abs() < 1.0 / 499.0, "{share}");

    let rows = document.table("record");
    assert_eq!(rows.len(), 4);
    for (cells, name) in rows.iter().zip(["d00_te", "d01_te", "d05_te", "d11_te"]) {
        let whole = report(&steps, &format!("bank.json {name}.csv"));
        assert_eq!(whole["samples"], 960);
        let share = |report: &Value| 100.0 * number(report, "/outputs/0/exceedance_share");
        let Some(alarm) = first_alarm(&whole) else {
            assert_eq!((name, cells[2]), ("d00_te", "none"));
            assert!(is_printed(cells[1], share(&whole)), "{cells:?}: {whole}");
            assert!(share(&whole) <= 2.2, "{cells:?}: {whole}");
            continue;
        };
        assert_eq!(alarm["tag"], "joint");
        let after = report(&steps, &format!("{name}.csv --rows 160:960"));
        assert!(is_printed(cells[1], share(&after)), "{cells:?}: {after}");
        let first = row(&whole, "/alarms/0/first_exceedance_s");
        assert!(is_printed(cells[2], first), "{cells:?}: row {first}");
        let delay_min = (first - ONSET_ROW) * number(&whole, "/sample_time_s") / 60.0;
        assert!(
            is_printed(cells[3], delay_min),
            "{cells:?}: {delay_min} min"
        );
        let asked: f64 = cells[4].trim_end_matches(" min").parse().expect(cells[4]);
        assert!((0.0..=asked).contains(&delay_min), "{cells:?}");
    }

    let shown = report(&steps, "--report fault5");
    let html = report_page::page(&place, "fault5");
    let points = report_page::points(&html);
    let statistic = report_page::chart(&points, "statistic");
    let times: Vec<&Value> = array(&shown, "/alarms")
        .iter()
        .map(|own| &own["time_s"])
        .collect();
    let marked: Vec<&Value> = array(statistic, "/marks")
        .iter()
        .map(|own| &own[0])
        .collect();
    assert!(!times.is_empty() && marked == times, "{marked:?} {times:?}");
    assert_eq!(statistic["limits"][0], shown["outputs"][0]["threshold"]);
    // The statistic, 52 residuals and 52 outputs.
    assert_eq!(points.len(), 105);
}

#[test]
fn the_power_plant_walk_through_is_true() {
    let Some(folder) = reference_data("the_power_plant_walk_through_is_true") else {
        return;
    };
    let place = place_with(&[&folder.join("powerplant.csv")]);
    let document = Document::read("docs/power_plant.md");
    let steps = document.run_in(&place);

    let data = report(&steps, "check powerplant.csv");
    assert_eq!(
        (&data["rows"], array(&data, "/damages").len()),
        (&200.into(), 0)
    );
    assert_eq!(data["time"], Value::Null);

    let identified = report(&steps, "--out model.json");
    assert_eq!(identified["structure"]["full"]["na"], 2);
    assert_eq!(identified["residuals"]["joint_whiteness"], "not_rejected");
    let tests = array(&identified, "/residuals/outputs").iter();
    for test in tests {
        assert_eq!(
            (&test["whiteness"], &test["independence"]),
            (&"not_rejected".into(), &"not_rejected".into())
        );
    }
    let checked = report(&steps, "model.json powerplant.csv --rows 150:200");
    let designed = report(&steps, "--out bank.json");
    let warned = array(&designed, "/warnings").iter().any(|warning| {
        let text = warning.as_str().expect("a text");
        text.contains("they count up to 1.115 times")
    });
    assert!(warned, "{designed}");
    let kinds: Vec<&Value> = array(&checked, "/findings")
        .iter()
        .map(|f| &f["kind"])
        .collect();
    assert!(
        kinds.iter().any(|kind| *kind == "poor_free_run"),
        "{kinds:?}"
    );
    for (index, cells) in document.table("output").iter().enumerate() {
        let value = |report: &Value, pointer: &str| {
            let pointer = pointer.replace('#', &index.to_string());
            number(report, &pointer)
        };
        let expected = [
            value(&identified, "/outputs/#/fit_prediction_percent"),
            value(&checked, "/records/0/outputs/#/fit_prediction_percent"),
            value(&designed, "/detectors/#/limit"),
        ];
        assert_eq!(cells[0], format!("`y{}`", index + 1));
        for (cell, value) in cells[1..].iter().zip(expected) {
            assert!(is_printed(cell, value), "{cells:?}: {value}");
        }
    }

    let rows = document.table("record, from row 170");
    assert_eq!(rows.len(), 8);
    for cells in &rows {
        let name = cells[0].trim_matches('`');
        let found = report(&steps, &format!("bank.json {name}.csv --rows 150:200"));
        assert_eq!(found["samples"], 50);
        let count = array(&found, "/alarms").len() as f64;
        assert!(is_printed(cells[2], count), "{cells:?}: {found}");
        let Some(alarm) = first_alarm(&found) else {
            assert_eq!(cells[3..], ["none", "", ""], "{cells:?}");
            continue;
        };
        let (tag, at) = (&alarm["tag"], row(&found, "/alarms/0/time_s"));
        assert!(cells[3].starts_with(&format!("`{}`", tag.as_str().expect("a tag"))));
        assert!(is_printed(cells[4], at), "{cells:?}: row {at}");
        let delay_min = (at - 170.0) * number(&found, "/sample_time_s") / 60.0;
        assert!(
            is_printed(cells[5], delay_min),
            "{cells:?}: {delay_min} min"
        );
    }
}
