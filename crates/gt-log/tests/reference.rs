//! Public records and the conformance files of MCAP, from `GTFDI_REFERENCE_DATA`.

#![allow(clippy::unwrap_used, reason = "helpers of tests")]
#![allow(clippy::float_cmp, reason = "a number that is read is exact")]

use std::fs;
use std::path::PathBuf;

use gt_log::{LogError, Selection, info, read_attachment, read_dataset};

/// The folder of reference data; says by name which test is skipped without it.
fn reference(test: &str) -> Option<PathBuf> {
    let folder = std::env::var_os("GTFDI_REFERENCE_DATA").map(PathBuf::from);
    if folder.is_none() {
        println!("skipped: {test}: GTFDI_REFERENCE_DATA is not set");
    }
    folder
}

fn select(inputs: &[&str], outputs: &[&str]) -> Selection {
    let own = |names: &[&str]| names.iter().map(|&name| name.to_owned()).collect();
    Selection {
        inputs: own(inputs),
        outputs: own(outputs),
        ..Selection::default()
    }
}

#[test]
fn published_dryer_record_is_read() {
    let Some(folder) = reference("published_dryer_record_is_read") else {
        return;
    };
    let imported = read_dataset(&folder.join("dryer.csv"), &select(&["u"], &["y"])).unwrap();
    let dataset = imported.dataset;
    assert_eq!((dataset.nu(), dataset.ny(), dataset.len()), (1, 1, 1000));
    assert_eq!((dataset.u()[0], dataset.y()[0]), (6.41, 4.7660989));
}

#[test]
fn published_winding_record_has_exponents_of_three_digits() {
    let name = "published_winding_record_has_exponents_of_three_digits";
    let Some(folder) = reference(name) else {
        return;
    };
    let selection = Selection {
        sample_time_s: Some(0.1),
        ..select(&["u?"], &["y*"])
    };
    let imported = read_dataset(&folder.join("winding.csv"), &selection).unwrap();
    let dataset = imported.dataset;
    assert_eq!((dataset.nu(), dataset.ny(), dataset.len()), (5, 2, 2500));
    assert_eq!(
        (dataset.u()[(0, 0)], dataset.u()[(1, 0)]),
        (-1.2025481, 0.80914798)
    );
    assert_eq!(dataset.y()[(1, 0)], -0.51069);
}

#[test]
fn published_tennessee_eastman_columns_match_globs() {
    let name = "published_tennessee_eastman_columns_match_globs";
    let Some(folder) = reference(name) else {
        return;
    };
    let selection = Selection {
        rows: Some(0..10),
        ..select(&["xmv*"], &["xmeas*"])
    };
    let imported = read_dataset(&folder.join("tep").join("d00.csv"), &selection).unwrap();
    // Downs and Vogel (1993): 41 measurements; 12 valves, of which the set has 11.
    assert_eq!((imported.dataset.nu(), imported.dataset.ny()), (11, 41));
    assert_eq!(imported.dataset.len(), 10);
}

/// What the conformance file's own list of records says.
fn expected(records: &serde_json::Value, kind: &str) -> usize {
    let records = records["records"].as_array().unwrap();
    records
        .iter()
        .filter(|record| record["type"] == kind)
        .count()
}

#[test]
fn published_conformance_files_hold_what_they_should() {
    let name = "published_conformance_files_hold_what_they_should";
    let Some(folder) = reference(name) else {
        return;
    };
    let mut files = 0;
    for group in ["NoData", "OneMessage"] {
        for entry in fs::read_dir(folder.join("mcap").join(group)).unwrap() {
            let path = entry.unwrap().path();
            if path.extension().is_none_or(|extension| extension != "mcap") {
                continue;
            }
            let json = fs::read(path.with_extension("json")).unwrap();
            let records: serde_json::Value = serde_json::from_slice(&json).unwrap();
            let found = info(&path).unwrap_or_else(|error| panic!("{error}"));
            assert_eq!(
                found.messages,
                u64::from(group == "OneMessage"),
                "{}",
                path.display()
            );
            assert_eq!(found.attachments.len(), expected(&records, "Attachment"));
            assert_eq!(found.metadata.len(), expected(&records, "Metadata"));
            // The list has what is in a chunk, the features say whether there is one.
            let features = records["meta"]["variant"]["features"].as_array().unwrap();
            let chunked = features.iter().any(|feature| feature == "ch");
            assert_eq!(found.chunks.count, u64::from(chunked), "{}", path.display());
            let read = read_dataset(&path, &select(&[], &["*"])).unwrap_err();
            assert!(matches!(read, LogError::UnknownTopic { .. }), "{read}");
            assert!(read_attachment(&path, "none").is_err());
            files += 1;
        }
    }
    assert!(files > 6, "{files} conformance files");
}
