//! The reproduction as a whole: its numbers against the paper's, its files, its determinism.

#![allow(clippy::unwrap_used, clippy::expect_used)] // a test may stop where it fails
#![allow(clippy::float_cmp)] // ones and zeros here are exact by construction

use std::fs;
use std::path::{Path, PathBuf};
use std::sync::OnceLock;

use gt_campaign::{Reproduction, Silent, paper, reproduce};

/// One reproduction serves all tests: it is the expensive part.
fn reproduction() -> &'static Reproduction {
    static ONCE: OnceLock<Reproduction> = OnceLock::new();
    ONCE.get_or_init(|| reproduce(1, &Silent).expect("the reproduction runs"))
}

fn files(folder: &Path) -> Vec<PathBuf> {
    let mut found = Vec::new();
    for entry in fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        if path.is_dir() {
            found.extend(files(&path));
        } else {
            found.push(path);
        }
    }
    found.sort();
    found
}

#[test]
fn published_table3_is_met_but_for_what_it_contradicts_itself() {
    let rows = &reproduction().tables.table3;
    assert_eq!(rows.len(), paper::TABLE3.len());
    for row in rows {
        // e_c: the paper's temperatures and pressure ratio themselves imply 0.839, 4.3 % lower.
        let limit = if row.variable == "e_c" { 4.3 } else { 2.5 };
        assert!(row.error_percent.abs() <= limit, "{row:?}");
    }
    let mean = rows.iter().map(|row| row.error_percent.abs()).sum::<f64>() / rows.len() as f64;
    // The calibrated plant's own mean is 0.5 %; a parameter that slips moves several entries.
    assert!(mean < 0.6, "mean absolute error {mean} %");
}

#[test]
fn published_table6_is_met_in_free_run_on_all_three_records() {
    let rows = &reproduction().tables.table6;
    let outputs: Vec<&str> = rows.iter().map(|row| row.output.as_str()).collect();
    assert_eq!(outputs, ["q_c", "t3", "p7", "m9", "w_t"]);
    for row in rows {
        let ours = [row.identification, row.validation1, row.validation2];
        for (ours, paper) in ours.iter().zip(row.paper) {
            assert!(
                ours.expect("the free run stays bounded") <= paper,
                "{row:?}"
            );
        }
        assert!(row.met);
        // One step ahead is far easier than a free run; were they equal, one would be the other.
        assert!(
            row.identification_prediction < 0.1 * row.identification.unwrap(),
            "{row:?}"
        );
    }
}

#[test]
fn published_signature_is_diagonal_with_the_papers_maps_and_the_axial_maps_are_shown_too() {
    let tables = &reproduction().tables.table9;
    let sets: Vec<&str> = tables.iter().map(|table| table.map_set.as_str()).collect();
    assert_eq!(sets, ["paper", "axial"]);
    assert!(tables[0].diagonal, "{:?}", tables[0].matrix);
    for table in tables.iter().chain(&reproduction().tables.table9_observers) {
        assert_eq!(table.columns, ["q_c", "t3", "p7", "m9"]);
        for column in 0..4 {
            let entries = table.matrix.iter().map(|row| row[column]);
            assert_eq!(
                entries.fold(0.0, f64::max),
                1.0,
                "{}: column {column}",
                table.map_set
            );
        }
        // A sensor fault touches the residual of its own sensor alone: the others are driven by
        // inputs and outputs that it cannot reach, so the zeros are exact.
        for column in [0, 2, 3] {
            assert_eq!(table.raw[1][column], 0.0, "{}", table.map_set);
        }
    }
    // Full-size faults, 0.5 cut: the pattern of the paper's Table 9.
    for (row, entries) in tables[0].matrix.iter().enumerate() {
        for (column, entry) in entries.iter().enumerate() {
            assert!(row == column || *entry <= 0.5, "({row}, {column}): {entry}");
        }
    }
}

#[test]
fn every_nominal_fault_is_seen_by_the_papers_output_after_its_onset() {
    for row in &reproduction().tables.detection {
        let own = row
            .delays_s
            .iter()
            .find(|delay| delay.output == row.expected)
            .unwrap();
        let delay = own.delay_s.expect("seen within the run");
        assert!(delay > 0.0, "{row:?}");
        let size = own.size.unwrap();
        assert!(size > 0.0 && size <= row.final_size, "{row:?}");
    }
}

#[test]
fn false_alarm_rates_leave_the_settling_out_and_carry_their_intervals() {
    for row in &reproduction().tables.observers {
        // Four healthy records of 600 s and a fifth, each less the same settling.
        let [four, one] = [&row.false_alarms_cross_validated, &row.false_alarms_test];
        assert!(one.hours < 600.0 / 3600.0, "{row:?}");
        assert!((four.hours - 4.0 * one.hours).abs() < 1e-12, "{row:?}");
        for rate in [four, one] {
            assert!(rate.per_hour_low <= rate.per_hour && rate.per_hour <= rate.per_hour_high);
        }
    }
}

#[test]
fn what_is_not_computed_is_null_or_empty() {
    let json = serde_json::to_value(&reproduction().tables).unwrap();
    assert_eq!(json["schema_version"], 1);
    assert_eq!(json["table10"], serde_json::json!([]));
    for key in ["table7", "table8", "isolation"] {
        assert!(
            json.as_object().unwrap().contains_key(key),
            "{key} is missing"
        );
        assert!(json[key].is_null(), "{key}");
    }
}

#[test]
fn the_folder_is_complete_whole_and_self_contained() {
    let folder = tempfile::tempdir().unwrap();
    reproduction().write(folder.path(), &Silent).unwrap();
    let files = files(folder.path());
    assert!(
        files
            .iter()
            .all(|path| path.extension().is_none_or(|end| end != "part"))
    );
    let count = |end: &str| {
        files
            .iter()
            .filter(|path| path.extension().is_some_and(|e| e == end))
            .count()
    };
    let figures = reproduction().figures.len();
    assert_eq!((count("svg"), count("csv")), (figures, figures));

    let page = fs::read_to_string(folder.path().join("index.html")).unwrap();
    for outside in ["http://", "https://", "<script", "url(", "@import"] {
        assert!(!page.contains(outside), "{outside} leaves the page");
    }
    for figure in &reproduction().figures {
        let link = format!("figures/{}.svg", figure.chart.id);
        assert!(
            page.contains(&link) && folder.path().join(&link).is_file(),
            "{link}"
        );
    }
    assert!(!page.contains("NaN"));

    let tables = fs::read_to_string(folder.path().join("tables.json")).unwrap();
    let tables: serde_json::Value = serde_json::from_str(&tables).unwrap();
    assert_eq!(tables["table3"].as_array().unwrap().len(), 30);

    let info = gt_log::info(&folder.path().join("logs/paper_case2_nominal.mcap")).unwrap();
    let topics: Vec<(&str, u64)> = info
        .topics
        .iter()
        .map(|topic| (topic.topic.as_str(), topic.messages))
        .collect();
    // 1800 s at 0.08 s.
    for topic in ["/plant/truth", "/plant/measured", "/plant/faults"] {
        assert!(topics.contains(&(topic, 22_500)), "{topics:?}");
    }
}

/// The whole folder, byte for byte: pages, tables, figures and logs.
#[test]
fn one_thread_writes_the_same_bytes_as_all_into_another_folder() {
    let written = |what: &Reproduction| {
        let folder = tempfile::tempdir().unwrap();
        what.write(folder.path(), &Silent).unwrap();
        folder
    };
    let pool = rayon::ThreadPoolBuilder::new()
        .num_threads(1)
        .build()
        .unwrap();
    let alone = pool.install(|| written(&reproduce(1, &Silent).unwrap()));
    let all = written(reproduction());
    let names = |folder: &Path| -> Vec<PathBuf> {
        let inside = |path: &PathBuf| path.strip_prefix(folder).unwrap().to_owned();
        files(folder).iter().map(inside).collect()
    };
    assert_eq!(names(alone.path()), names(all.path()));
    for name in names(all.path()) {
        let bytes = |folder: &Path| fs::read(folder.join(&name)).unwrap();
        assert!(
            bytes(alone.path()) == bytes(all.path()),
            "{} differs",
            name.display()
        );
    }
}
