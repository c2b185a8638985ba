//! Exports of historians: rows of readings, tags at their own times, names and units of a plant.

#![allow(clippy::unwrap_used, reason = "helpers of tests")]
#![allow(clippy::float_cmp, reason = "a number that is read is exact")]

use std::fs;

use gt_log::{
    Imported, Layout, Reading, Resample, ResampleMethod, Selection, TagMap, read_dataset,
};
use gtfdi::ident::Missing;
use tempfile::tempdir;

fn select(inputs: &[&str], outputs: &[&str], reading: Reading) -> Selection {
    let own = |names: &[&str]| names.iter().map(|&name| name.to_owned()).collect();
    Selection {
        inputs: own(inputs),
        outputs: own(outputs),
        reading,
        ..Selection::default()
    }
}

/// The record in a file beside a file of tags, or what is said without the file's name.
fn read_with(text: &str, tags: Option<&str>, mut selection: Selection) -> Result<Imported, String> {
    let folder = tempdir().unwrap();
    let path = folder.path().join("a.csv");
    fs::write(&path, text).unwrap();
    let short = |error: gt_log::LogError| {
        error
            .to_string()
            .replace(&format!("{}/", folder.path().display()), "")
    };
    if let Some(tags) = tags {
        let file = folder.path().join("tags.toml");
        fs::write(&file, tags).unwrap();
        selection.reading.tags = Some(TagMap::read(&file).map_err(short)?);
    }
    read_dataset(&path, &selection).map_err(short)
}

fn read(text: &str, selection: Selection) -> Result<Imported, String> {
    read_with(text, None, selection)
}

fn by(step_s: f64, method: ResampleMethod, hold_at_most_s: Option<f64>) -> Reading {
    Reading {
        resample: Some(Resample {
            step_s,
            method,
            hold_at_most_s,
        }),
        ..Reading::default()
    }
}

fn shown(values: &[f64]) -> Vec<String> {
    values.iter().map(ToString::to_string).collect()
}

const SAME_TIMES: &str = "TagName,Timestamp,Value,Status\n\
    u,2026-01-01T00:00:02Z,3,Good\n\
    u,2026-01-01T00:00:00Z,1,192\n\
    y,2026-01-01T00:00:01Z,20,Uncertain\n\
    x,never,none at all,odd\n\
    u,2026-01-01T00:00:01Z,2,\n\
    y,2026-01-01T00:00:00Z,10,good\n\
    y,2026-01-01T00:00:02Z,30,0\n";

#[test]
fn readings_at_the_same_times_make_a_record() {
    let selection = Selection {
        missing: Missing::Break,
        ..select(&["u"], &["y"], Reading::default())
    };
    // The time form is that of the first row, and rows of other tags may hold anything.
    let imported = read(SAME_TIMES, selection.clone()).unwrap();
    assert_eq!(imported.dataset.u().as_slice(), [1.0, 2.0, 3.0]);
    assert_eq!(shown(imported.dataset.y().as_slice()), ["10", "20", "NaN"]);
    assert_eq!(imported.dataset.sample_time_s(), 1.0);
    // date -u -d 2026-01-01 +%s
    assert_eq!(imported.start_unix_ns, Some(1_767_225_600_000_000_000));
    assert_eq!(imported.total_rows, 3);
    assert_eq!(
        imported.remarks(),
        [
            "`y`: 1 readings of uncertain quality, kept",
            "`y`: 1 times `quality 0`, read as missing",
            "`y` has 1 samples that are not valid (NaN)",
        ]
    );
    let rows = Selection {
        rows: Some(1..3),
        ..selection.clone()
    };
    let imported = read(SAME_TIMES, rows).unwrap();
    assert_eq!(imported.dataset.u().as_slice(), [2.0, 3.0]);
    assert_eq!(imported.start_unix_ns, Some(1_767_225_601_000_000_000));
    let strict = select(&["u"], &["y"], Reading::default());
    assert_eq!(
        read(SAME_TIMES, strict).unwrap_err(),
        "a.csv: line 8, column `Status`: expected a reading that is not bad, found the quality `0`"
    );
}

#[test]
fn rows_of_readings_that_cannot_be_used_are_named() {
    let y = || select(&[], &["y"], Reading::default());
    let head = "tag,time,value,quality\n";
    let cases = [
        (
            "y,0,1,good\ny,1,2,fine\n",
            "line 3, column `quality`: expected Good, Uncertain, Bad or an OPC quality (192 and above \
             good, 64 to 127 uncertain, below 64 bad), found `fine`",
        ),
        (
            "y,0,1,150\n",
            "line 2, column `quality`: expected Good, Uncertain, Bad or an OPC quality (192 and above \
             good, 64 to 127 uncertain, below 64 bad), found `150`",
        ),
        (
            "y,0,1,\n,1,2,\n",
            "line 3, column `tag`: expected a tag, found an empty cell",
        ),
        (
            "y,0,1,\ny,1,full,\n",
            "line 3, column `value`: expected a finite number, found `full`",
        ),
        ("y,0,1,\ny,1\n", "line 3: expected 4 fields, found 2"),
        (
            "y,0,1,\ny,1,2,\ny,1,3,\n",
            "line 4: expected a time after 1 s, found 1 s; name another time column, or give the \
             sample time",
        ),
        ("x,0,1,\n", "expected a column `y`, found x"),
        ("", "expected data rows below the header, found none"),
    ];
    for (rows, expected) in cases {
        let error = read(&format!("{head}{rows}"), y()).unwrap_err();
        assert_eq!(error, format!("a.csv: {expected}"));
    }
    let long = Reading {
        layout: Some(Layout::Long),
        ..Reading::default()
    };
    assert_eq!(
        read("time,y\n0,1\n", select(&[], &["y"], long)).unwrap_err(),
        "a.csv: --layout long: expected columns tag, time and value, found time, y; name the time \
         column (--time), or leave --layout out"
    );
    let wide = Reading {
        layout: Some(Layout::Wide),
        ..Reading::default()
    };
    let imported = read(
        "tag,time,value\n7,0,1\n8,1,2\n",
        select(&["tag"], &["value"], wide),
    );
    assert_eq!(imported.unwrap().dataset.u().as_slice(), [7.0, 8.0]);
}

#[test]
fn tags_at_their_own_times_are_resampled() {
    let text = "tag,time,value\nu,100,1\nu,100.5,3\nu,102,5\ny,100.25,10\ny,101,20\n\
                y,104.5,30\n";
    assert_eq!(
        read(text, select(&["u"], &["y"], Reading::default())).unwrap_err(),
        "a.csv: expected all tags at the same times, found 3 readings of `u` and 3 of `y` at other \
         times; give --resample with the sample time you want"
    );
    let imported = read(
        text,
        select(&["u"], &["y"], by(1.0, ResampleMethod::Mean, None)),
    )
    .unwrap();
    assert_eq!(
        shown(imported.dataset.u().as_slice()),
        ["2", "NaN", "5", "NaN", "NaN"]
    );
    assert_eq!(
        shown(imported.dataset.y().as_slice()),
        ["10", "20", "NaN", "NaN", "30"]
    );
    assert_eq!(imported.dataset.start_time_s(), 100.0);
    assert_eq!(
        imported.remarks(),
        [
            "`u` has 3 samples that are not valid (NaN)",
            "`y` has 2 samples that are not valid (NaN)",
            "resampled `u`: 1 as they stand, 1 averaged from 2, 3 missing",
            "resampled `y`: 3 as they stand, 2 missing",
        ]
    );
    let hold = by(1.0, ResampleMethod::Hold, Some(2.0));
    let rows = Selection {
        rows: Some(1..4),
        ..select(&["u"], &["y"], hold)
    };
    let imported = read(text, rows).unwrap();
    assert_eq!(shown(imported.dataset.u().as_slice()), ["3", "5", "5"]);
    assert_eq!(shown(imported.dataset.y().as_slice()), ["20", "20", "20"]);
    assert_eq!(
        (imported.total_rows, imported.dataset.start_time_s()),
        (5, 101.0)
    );
}

#[test]
fn columns_at_odd_times_are_resampled() {
    let text = "time,y\n2026-01-01T00:00:00Z,1\n2026-01-01T00:00:00.7Z,2\n\
                2026-01-01T00:00:02Z,4\n2026-01-01T00:00:02Z,6\n";
    let linear = by(0.5, ResampleMethod::Linear, Some(2.0));
    let imported = read(text, select(&[], &["y"], linear.clone())).unwrap();
    assert_eq!(imported.dataset.sample_time_s(), 0.5);
    assert_eq!(imported.start_unix_ns, Some(1_767_225_600_000_000_000));
    let y = imported.dataset.y().as_slice();
    assert_eq!((y.len(), y[0], y[4]), (5, 1.0, 6.0));
    assert!((y[1] - (1.0 + 0.5 / 0.7)).abs() < 1e-12);
    let refused = [
        (
            "time,y\n0,1\n2,2\n1,3\n",
            select(&[], &["y"], linear.clone()),
            "a.csv: line 4: expected a time after 2 s, found 1 s; name another time column, or give \
             the sample time",
        ),
        (
            "n,y\n0,1\n1,2\n",
            select(&[], &["y"], linear.clone()),
            "a.csv: --resample: expected a time column, found none; name it (--time)",
        ),
        (
            "time,y\n0,1\n1e12,2\n",
            select(&[], &["y"], linear.clone()),
            "a.csv: --resample: expected at most 50000000 samples, found 2000000000001; give a longer \
             step, or look for a wrong time",
        ),
        (
            "time,y\n0,1\n1,2\n",
            Selection {
                sample_time_s: Some(1.0),
                ..select(&[], &["y"], linear)
            },
            "--resample: expected without --sample-time, found both",
        ),
    ];
    for (text, selection, expected) in refused {
        assert_eq!(read(text, selection).unwrap_err(), expected);
    }
}

#[test]
fn a_map_of_tags_gives_names_units_and_ranges() {
    let text = "time,10FT1.PV,10TT1.PV,other\n0,3600,10,1\n1,-5,20,2\n2,7200,30,3\n";
    let tags = r#"
        [tags."10FT1.PV"]
        name = "fuel_flow"
        unit = "kg/h"
        to = "kg/s"
        low = 0.0
        high = 9000.0

        [tags."10TT1.PV"]
        name = "inlet"
        scale = 0.5
        offset = -1.0
        unit = "degC"
    "#;
    let all = select(&["fuel_flow"], &["inlet", "o*"], Reading::default());
    let imported = read_with(text, Some(tags), all).unwrap();
    assert_eq!(shown(imported.dataset.u().as_slice()), ["1", "NaN", "2"]);
    assert_eq!(
        imported.dataset.y().as_slice(),
        [4.0, 1.0, 9.0, 2.0, 14.0, 3.0]
    );
    let units: Vec<&str> = imported
        .dataset
        .inputs()
        .iter()
        .chain(imported.dataset.outputs())
        .map(|signal| signal.unit.as_str())
        .collect();
    assert_eq!(units, ["kg/s", "degC", ""]);
    assert_eq!(
        imported.remarks()[0],
        "`fuel_flow`: 1 readings outside the range of the tags' file, read as missing"
    );
    let long = "tag,time,value\n10FT1.PV,0,3600\n10TT1.PV,0,4\n10FT1.PV,1,1800\n10TT1.PV,1,6\n";
    let both = select(&["fuel_flow"], &["inlet"], Reading::default());
    let imported = read_with(long, Some(tags), both).unwrap();
    assert_eq!(imported.dataset.u().as_slice(), [1.0, 0.5]);
    assert_eq!(imported.dataset.y().as_slice(), [1.0, 2.0]);
}

#[test]
fn maps_of_tags_that_cannot_be_followed_are_named() {
    let text = "time,FT1,PT1,y\n0,1,2,3\n1,2,3,4\n";
    let refused = |tags: &str| {
        read_with(text, Some(tags), select(&[], &["y"], Reading::default())).unwrap_err()
    };
    let one = |rule: &str| refused(&format!("[tags.FT1]\n{rule}\n"));
    assert_eq!(
        refused("[tags.FT2]\nname = \"flow\"\n"),
        "tags.toml: tag `FT2`: expected a tag of a.csv, found none of that name; near are FT1, PT1, y"
    );
    assert_eq!(
        one("unit = \"kg/h\"\nto = \"bar\""),
        "tags.toml: tag `FT1`: expected units of one kind, found `kg/h` (a mass flow) and `bar` (a \
         pressure)"
    );
    assert_eq!(
        one("unit = \"barg\"\nto = \"bar\""),
        "tags.toml: tag `FT1`: expected absolute pressures, found `barg` to `bar`: the ambient \
         pressure is not known; keep the unit, or give scale and offset"
    );
    assert!(one("unit = \"furlong\"\nto = \"bar\"").starts_with(
        "tags.toml: tag `FT1`: unit: expected a unit that is known (temperatures K, degC"
    ));
    assert!(one("to = \"bar\"").ends_with("found ``"));
    assert_eq!(
        one("scale = 0.0"),
        "tags.toml: tag `FT1`: scale: expected another number than 0"
    );
    assert_eq!(
        one("to = \"bar\"\nscale = 2.0"),
        "tags.toml: tag `FT1`: expected to, or scale and offset, found both"
    );
    assert_eq!(
        one("low = 2.0\nhigh = 1.0"),
        "tags.toml: tag `FT1`: expected low < high, found 2 and 1"
    );
    assert_eq!(
        one("low = nan"),
        "tags.toml: tag `FT1`: expected finite numbers, found NaN"
    );
    assert_eq!(
        one("name = \"PT1\""),
        "tags.toml: tag `FT1`: expected a name that no other tag of a.csv has, found `PT1`"
    );
    assert_eq!(
        refused("[tags.FT1]\nname = \"a\"\n[tags.PT1]\nname = \"a\"\n"),
        "tags.toml: tag `PT1`: expected a name of its own, found `a`, as for `FT1`"
    );
    assert!(one("nam = \"a\"").contains("unknown field `nam`"));
    assert!(refused("tags = 1").starts_with("tags.toml: expected a section [tags.\"TAG\"] for"));
}

#[test]
fn gaps_are_filled_with_missing_samples() {
    let text = "time,y\n10,1\n12,2\n18,3\n20,4\n";
    let allowed = Selection {
        missing: Missing::Break,
        ..select(&[], &["y"], Reading::default())
    };
    let path = std::path::Path::new("a.csv");
    let imported = read(text, allowed.clone()).unwrap().filled(path).unwrap();
    let y = imported.dataset.y().as_slice();
    assert_eq!(shown(y), ["1", "2", "NaN", "NaN", "3", "4"]);
    assert_eq!(
        (imported.dataset.start_time_s(), imported.gaps.len()),
        (10.0, 0)
    );
    let odd = "time,y\n10,1\n12,2\n14,2\n19,3\n21,4\n";
    let error = read(odd, allowed).unwrap().filled(path).unwrap_err();
    assert_eq!(
        error.to_string(),
        "a.csv: sample 3: expected a gap of a whole number of sample times (2 s), found 2.5; \
         --resample makes samples of one period"
    );
}
