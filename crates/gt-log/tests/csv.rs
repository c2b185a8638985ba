//! CSV files: what is read, and what is said of those that cannot be.

#![allow(clippy::unwrap_used, reason = "helpers of tests")]
#![allow(clippy::float_cmp, reason = "a number that is read is exact")]

use std::fs;
use std::path::{Path, PathBuf};

use gt_log::{LogError, Selection, TimeGap, Warning, columns, read_dataset, sha256_hex};
use gtfdi::ident::Missing;
use tempfile::{TempDir, tempdir};

struct File {
    _folder: TempDir,
    path: PathBuf,
}

fn file(bytes: impl AsRef<[u8]>) -> File {
    let folder = tempdir().unwrap();
    let path = folder.path().join("a.csv");
    fs::write(&path, bytes).unwrap();
    File {
        _folder: folder,
        path,
    }
}

fn select(inputs: &[&str], outputs: &[&str]) -> Selection {
    let own = |names: &[&str]| names.iter().map(|&name| name.to_owned()).collect();
    Selection {
        inputs: own(inputs),
        outputs: own(outputs),
        ..Selection::default()
    }
}

/// What is said of `bytes`, without the file's name.
fn error(bytes: impl AsRef<[u8]>, selection: &Selection) -> String {
    let file = file(bytes);
    let error = read_dataset(&file.path, selection).unwrap_err().to_string();
    let prefix = format!("{}: ", file.path.display());
    error.strip_prefix(&prefix).unwrap_or(&error).to_owned()
}

fn y_of(bytes: impl AsRef<[u8]>) -> Vec<f64> {
    let imported = read_dataset(&file(bytes).path, &select(&[], &["y"])).unwrap();
    imported.dataset.y().as_slice().to_vec()
}

#[test]
fn numbers_are_read_in_every_usual_dress() {
    assert_eq!(
        y_of("y\n1\n-1.2e-001\n+3.5E+002\n .5 \n\"7\"\n5.\n"),
        [1.0, -0.12, 350.0, 0.5, 7.0, 5.0]
    );
    assert_eq!(y_of("\u{feff}u,y\r\n1,2\r\n3,4\r\n\r\n  \r\n"), [2.0, 4.0]);
    assert_eq!(y_of("u,y\r1,2\r3,4"), [2.0, 4.0]);
    assert_eq!(y_of("\n\nu ; \"y\"\n1;2\n3;4\n"), [2.0, 4.0]);
    assert_eq!(y_of("u\ty\n1\t2\n3\t4\n"), [2.0, 4.0]);
    // A tag with a comma inside quotes does not make the comma the delimiter.
    assert_eq!(y_of("\"u, left\";y\n1;2\n3;4\n"), [2.0, 4.0]);
}

#[test]
fn without_a_time_the_samples_count() {
    let file = file("u,y\n1,2\n3,4\n5,6\n");
    let imported = read_dataset(&file.path, &select(&["u"], &["y"])).unwrap();
    assert_eq!(imported.warnings, [Warning::TimeInSamples]);
    assert_eq!(imported.dataset.sample_time_s(), 1.0);
    assert_eq!(imported.dataset.u().as_slice(), [1.0, 3.0, 5.0]);
    assert_eq!((imported.total_rows, imported.start_unix_ns), (3, None));
    assert_eq!(imported.sha256, sha256_hex(b"u,y\n1,2\n3,4\n5,6\n"));
    let given = Selection {
        sample_time_s: Some(0.08),
        rows: Some(1..3),
        ..select(&["u"], &["y"])
    };
    let imported = read_dataset(&file.path, &given).unwrap();
    assert!(imported.warnings.is_empty());
    assert_eq!(imported.dataset.start_time_s(), 0.08);
}

#[test]
fn the_time_column_gives_the_sample_time() {
    for name in ["time", "Time", "t", "TIMESTAMP"] {
        let file = file(format!("{name},y\n2.00,1\n2.08,2\n2.16,3\n2.24,4\n"));
        let imported = read_dataset(&file.path, &select(&[], &["*"])).unwrap();
        // 0.08 to the last bit, though 2.08 - 2.00 is not.
        assert_eq!(
            imported.dataset.sample_time_s().to_bits(),
            0.08_f64.to_bits()
        );
        assert_eq!(imported.dataset.start_time_s(), 2.0);
        assert_eq!(imported.dataset.ny(), 1, "`*` passes over {name}");
        assert!(imported.warnings.is_empty());
    }
    let named = Selection {
        time: Some("clock".to_owned()),
        ..select(&[], &["y"])
    };
    let file = file("clock,t,y\n0,9,1\n0.5,9,2\n");
    assert_eq!(
        read_dataset(&file.path, &named)
            .unwrap()
            .dataset
            .sample_time_s(),
        0.5
    );
}

#[test]
fn a_temperature_called_t_is_no_time_when_it_is_selected() {
    let file = file("T,y\n300,1\n299,2\n");
    let imported = read_dataset(&file.path, &select(&["T"], &["y"])).unwrap();
    assert_eq!(imported.dataset.u().as_slice(), [300.0, 299.0]);
    assert_eq!(imported.warnings, [Warning::TimeInSamples]);
}

#[test]
fn instants_are_read_in_iso_8601() {
    let file = file(
        "time,y\n2026-01-02T03:04:05.000Z,1\n2026-01-02T03:04:05.080Z,2\n\
         2026-01-02T04:04:05.160+01:00,3\n",
    );
    let imported = read_dataset(&file.path, &select(&[], &["y"])).unwrap();
    assert_eq!(
        imported.dataset.sample_time_s().to_bits(),
        0.08_f64.to_bits()
    );
    // date -u -d 2026-01-02T03:04:05 +%s
    assert_eq!(imported.start_unix_ns, Some(1_767_323_045_000_000_000));
    assert_eq!(
        error("time,y\n2026-01-02 03:04:05,1\n6,2\n", &select(&[], &["y"])),
        "line 3, column `time`: expected seconds or an ISO 8601 time, all alike, found `6`; another \
         form is read with --time-format"
    );
    assert_eq!(
        error("time,y\n2 January 2026,1\n", &select(&[], &["y"])),
        "line 2, column `time`: expected seconds or an ISO 8601 time, all alike, found \
         `2 January 2026`; another form is read with --time-format"
    );
}

#[test]
fn other_columns_and_rows_need_not_be_numbers() {
    let text = "u,comment,y\nbad,,\n1,start,2\n3,\"a, b\",4\nshort\n";
    let rows = Selection {
        rows: Some(1..3),
        ..select(&["u"], &["y"])
    };
    let imported = read_dataset(&file(text).path, &rows).unwrap();
    assert_eq!(imported.dataset.u().as_slice(), [1.0, 3.0]);
    assert_eq!(imported.total_rows, 4);
}

#[test]
fn cells_that_are_no_numbers_are_named() {
    let y = select(&["u"], &["y"]);
    let cases = [
        (
            "u,y\n1,2\n3,off\n",
            "line 3, column `y`: expected a finite number, found `off`",
        ),
        (
            "u,y\n1,2\n3,\n",
            "line 3, column `y`: expected a finite number, found an empty cell",
        ),
        (
            "u,y\nNaN,2\n",
            "line 2, column `u`: expected a finite number, found `NaN`",
        ),
        (
            "u,y\n1,-inf\n",
            "line 2, column `y`: expected a finite number, found `-inf`",
        ),
        (
            "u,y\n1,1e999\n",
            "line 2, column `y`: expected a finite number, found `1e999`",
        ),
        (
            "u;y\n1.5;2,5\n",
            "line 2, column `y`: expected a number with a decimal point, found `2,5`; if the comma \
             is the decimal sign, give --decimal comma",
        ),
    ];
    for (text, expected) in cases {
        assert_eq!(error(text, &y), expected, "{text:?}");
    }
}

#[test]
fn lines_are_counted_past_quotes_blanks_and_every_line_end() {
    let y = select(&[], &["y"]);
    let bad = |line| format!("line {line}, column `y`: expected a finite number, found `x`");
    assert_eq!(error("c,y\n\"a\nb\",1\nc,x\n", &y), bad(4));
    assert_eq!(error("\r\n\r\nc,y\r\na,1\r\nc,x\r\n", &y), bad(5));
    assert_eq!(error("c,y\ra,1\rb,1\rc,x", &y), bad(4));
    assert_eq!(error("\u{feff}c,y\na,x\n", &y), bad(2));
    // A blank line inside is a lost sample, not nothing.
    assert_eq!(
        error("c,y\na,1\n\nc,3\n", &y),
        "line 3: expected 2 fields, found 0"
    );
    assert_eq!(
        error("c,y\r\na,1\r\n\r\n \r\nc,3\r\n", &y),
        "line 3: expected 2 fields, found 0"
    );
    assert_eq!(
        error("y\n1\n\n3\n", &y),
        "line 3, column `y`: expected a finite number, found an empty cell"
    );
}

#[test]
fn files_that_are_no_table_are_named() {
    let y = select(&[], &["y"]);
    let cases: [(&[u8], &str); 11] = [
        (b"", "expected a header row of tags, found an empty file"),
        (
            b"\n \n",
            "expected a header row of tags, found an empty file",
        ),
        (b"u,y\n", "expected data rows below the header, found none"),
        (
            b"6.41,4.77\n3.41,4.76\n",
            "line 1: expected a header row of tags, found the numbers `6.41,4.77`",
        ),
        (
            b"0;0,5;0\n1;1,5;0\n",
            "line 1: expected a header row of tags, found the numbers `0;0,5;0`",
        ),
        (
            b"u,y,u\n1,2,3\n",
            "line 1: expected every tag once, found `u` twice",
        ),
        (b"u,y\n1,2\n3\n", "line 3: expected 2 fields, found 1"),
        (b"u,y\n1,2\n3,4,5\n", "line 3: expected 2 fields, found 3"),
        (
            b"u,y\n1,\x002\n",
            "line 2: expected UTF-8 text, found the byte 0x00 at offset 6 (a binary file, or text \
             in another encoding: --encoding windows-1252, --encoding utf-16le)",
        ),
        (
            b"u,y in \xb0C\n1,2\n",
            "line 1: expected UTF-8 text, found the byte 0xb0 at offset 7 (a binary file, or text \
             in another encoding: --encoding windows-1252, --encoding utf-16le)",
        ),
        (b"u,y\n1,2\n\"3,4\n", "line 3: expected 2 fields, found 1"),
    ];
    for (bytes, expected) in cases {
        assert_eq!(
            error(bytes, &y),
            expected,
            "{:?}",
            String::from_utf8_lossy(bytes)
        );
    }
}

#[test]
fn selections_that_do_not_fit_are_named() {
    let text = "u1,u2,y,\n1,2,3,\n4,5,6,\n";
    let cases = [
        (
            select(&["u3"], &["y"]),
            "expected a column `u3`, found u1, u2, y",
        ),
        (
            select(&["v*"], &["y"]),
            "expected a column that matches `v*`, found u1, u2, y",
        ),
        (
            select(&["u1"], &["u1"]),
            "`u1` is selected as input and as output; expected one of them",
        ),
        (
            select(&["u1", "u1"], &["y"]),
            "`u1` is selected twice as input; expected once",
        ),
        (
            select(&[], &[]),
            "expected inputs or outputs to be selected, found neither; there are u1, u2, y",
        ),
        (
            select(&["u[1"], &["y"]),
            "expected a pattern like `xmv*` or `y[12]`, found `u[1`: invalid range pattern",
        ),
        (
            Selection {
                time: Some("clock".to_owned()),
                ..select(&["u1"], &["y"])
            },
            "expected a column `clock`, found u1, u2, y",
        ),
        (
            Selection {
                sample_time_s: Some(0.0),
                ..select(&["u1"], &["y"])
            },
            "expected a positive, finite sample time in seconds, found 0",
        ),
        (
            Selection {
                rows: Some(1..3),
                ..select(&["u1"], &["y"])
            },
            "expected rows A:B with 0 <= A < B <= 2, found 1:3 (0-based, half open)",
        ),
        (
            Selection {
                rows: Some(1..1),
                ..select(&["u1"], &["y"])
            },
            "expected rows A:B with 0 <= A < B <= 2, found 1:1 (0-based, half open)",
        ),
    ];
    for (selection, expected) in cases {
        assert_eq!(error(text, &selection), expected);
    }
    let picked = read_dataset(&file(text).path, &select(&["u2", "u*"], &["y"])).unwrap();
    let names: Vec<_> = picked
        .dataset
        .inputs()
        .iter()
        .map(|s| s.name.as_str())
        .collect();
    assert_eq!(
        names,
        ["u2", "u1"],
        "a pattern does not repeat what is there"
    );
}

/// Where missing samples and gaps may be: cells are NaN and counted, pieces carry their own times.
#[test]
fn missing_samples_and_gaps_are_kept_where_they_may_be() {
    let text = "time,u,y\n10,1,2\n12,,4\n14,5,NaN\n16,7,8\n30,9,10\n32,11,12\n33.5,13,14\n";
    let allowed = Selection {
        missing: Missing::Break,
        ..select(&["u"], &["y"])
    };
    assert_eq!(
        error(text, &allowed),
        "line 8: expected a step of 2 s (within 0.001 of it), found 1.5 s; select rows without a \
         gap, or give the sample time; --resample makes samples of one period"
    );
    let gaps = text.strip_suffix("33.5,13,14\n").unwrap();
    let file = file(gaps);
    let imported = read_dataset(&file.path, &allowed).unwrap();
    let invalid = |column: &str| Warning::InvalidSamples {
        column: column.to_owned(),
        count: 1,
    };
    assert_eq!(imported.warnings, [invalid("u"), invalid("y")]);
    assert_eq!(imported.dataset.sample_time_s(), 2.0);
    assert!(imported.dataset.u()[1].is_nan() && imported.dataset.y()[2].is_nan());
    let gap = TimeGap {
        sample: 4,
        since_first_s: 20.0,
    };
    assert_eq!(imported.gaps, [gap]);
    let starts = |rows: std::ops::Range<usize>| -> Vec<(f64, usize)> {
        let pieces = imported.pieces(rows).unwrap();
        pieces
            .iter()
            .map(|piece| (piece.start_time_s(), piece.len()))
            .collect()
    };
    assert_eq!(starts(0..6), [(10.0, 4), (30.0, 2)]);
    assert_eq!(starts(1..4), [(12.0, 3)]);
    assert_eq!(starts(3..5), [(16.0, 1), (30.0, 1)]);
    assert_eq!(starts(5..6), [(32.0, 1)]);
    assert!(imported.pieces(5..7).is_err());
    // Infinity is no missing sample, and by default neither cells nor gaps may be missing.
    assert_eq!(
        error("u,y\n1,2\n3,-inf\n", &allowed),
        "line 3, column `y`: expected a finite number, found `-inf`"
    );
    assert_eq!(
        error(gaps, &select(&["u"], &["y"])),
        "line 3, column `u`: expected a finite number, found an empty cell"
    );
}

#[test]
fn times_that_are_not_uniform_are_named() {
    let y = select(&[], &["y"]);
    let with = |times: &[&str]| error(format!("t,y\n{},1\n", times.join(",1\n")), &y);
    let backwards = "name another time column, or give the sample time";
    assert_eq!(
        with(&["0", "1", "1", "2"]),
        format!("line 4: expected a time after 1 s, found 1 s; {backwards}")
    );
    assert_eq!(
        with(&["0", "1", "0.5"]),
        format!("line 4: expected a time after 1 s, found 0.5 s; {backwards}")
    );
    assert_eq!(
        with(&["0", "1", "2", "4", "5"]),
        "line 5: expected a step of 1 s (within 0.001 of it), found 2 s; select rows without a \
         gap, or give the sample time; --resample makes samples of one period"
    );
    assert_eq!(
        with(&["0"]),
        "expected 2 rows or more to tell the sample time, found 1; give it"
    );
    assert_eq!(
        with(&["0", ""]),
        "line 3, column `t`: expected a finite number, found an empty cell"
    );
}

#[test]
fn files_that_are_not_there_are_named() {
    let folder = tempdir().unwrap();
    let y = select(&[], &["y"]);
    let named = |name: &str| read_dataset(&folder.path().join(name), &y).unwrap_err();
    assert!(matches!(named("none.csv"), LogError::NotFound { path } if path.ends_with("none.csv")));
    fs::create_dir(folder.path().join("folder.csv")).unwrap();
    assert!(matches!(named("folder.csv"), LogError::Directory { .. }));
    assert!(matches!(named("a.parquet"), LogError::NotFound { .. }));
    assert!(
        named("a.xlsx")
            .to_string()
            .ends_with("ends in .csv, .parquet or .mcap, found `.xlsx`")
    );
    assert!(
        named("a")
            .to_string()
            .ends_with("ends in .csv, .parquet or .mcap, found no extension")
    );
    assert!(columns(Path::new("a.txt"), None).is_err());
}

#[test]
fn columns_of_csv_are_the_header() {
    let file = file("time,TI-101.PV,,y\n0,1,2,3\n");
    let names: Vec<_> = columns(&file.path, None)
        .unwrap()
        .into_iter()
        .map(|s| s.name)
        .collect();
    assert_eq!(names, ["time", "TI-101.PV", "y"]);
}
