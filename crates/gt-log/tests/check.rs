//! What is said of damaged exports: every damage, with its place, its tag and what mends it.

#![allow(clippy::unwrap_used, reason = "helpers of tests")]

use std::fmt::Write as _;
use std::fs;

use gt_log::{DamageKind, DataCheck, Reading, Selection, TagKind, check, read_dataset};
use proptest::prelude::*;
use tempfile::tempdir;

fn check_bytes(bytes: &[u8], selection: &Selection) -> DataCheck {
    let folder = tempdir().unwrap();
    let path = folder.path().join("a.csv");
    fs::write(&path, bytes).unwrap();
    check(&path, selection).unwrap()
}

/// A damage as `kind line tag option`.
fn damages(found: &DataCheck) -> Vec<String> {
    let damage = |damage: &gt_log::Damage| {
        let kind = serde_json::to_value(damage.kind).unwrap();
        let line = damage.line.map_or("-".to_owned(), |line| line.to_string());
        let tag = damage.tag.as_deref().unwrap_or("-");
        let kind = kind.as_str().unwrap().to_owned();
        format!("{kind} {line} {tag} {}", damage.mended_by.unwrap_or("-"))
    };
    found.damages.iter().map(damage).collect()
}

/// A sound export of 12 rows; the header is line 1.
fn sound() -> Vec<String> {
    let mut lines = vec!["time,u,y".to_owned()];
    let row = |k: u32| {
        format!(
            "2026-03-04T10:00:{:02}Z,{}.5,{}",
            5 * k % 60,
            k % 5,
            k * k % 7
        )
    };
    lines.extend((0..12).map(row));
    lines
}

/// The export with some of its lines, from 1, replaced.
fn damaged(changes: &[(usize, &str)]) -> Vec<u8> {
    let mut lines = sound();
    for &(line, text) in changes {
        text.clone_into(&mut lines[line - 1]);
    }
    (lines.join("\n") + "\n").into_bytes()
}

/// The export with a column of times.
fn with_times(times: &[&str]) -> Vec<u8> {
    let mut text = "time,y\n".to_owned();
    for (k, time) in times.iter().enumerate() {
        writeln!(text, "{time},{}", k % 3).unwrap();
    }
    text.into_bytes()
}

/// An export's name, its bytes and its damages.
type Case = (&'static str, Vec<u8>, Vec<&'static str>);

/// Damages of cells.
fn damaged_cells() -> Vec<Case> {
    vec![
        ("sound", damaged(&[]), vec![]),
        (
            "empty cell",
            damaged(&[(4, "2026-03-04T10:00:10Z,,4")]),
            vec!["missing 4 u --missing"],
        ),
        (
            "bad word",
            damaged(&[(5, "2026-03-04T10:00:15Z,1,Bad Input")]),
            vec!["missing 5 y --missing"],
        ),
        (
            "NaN",
            damaged(&[(5, "2026-03-04T10:00:15Z,NaN,1")]),
            vec!["missing 5 u --missing"],
        ),
        (
            "text",
            damaged(&[(6, "2026-03-04T10:00:20Z,stuck,1")]),
            vec!["number 6 u --bad-values"],
        ),
        (
            "infinity",
            damaged(&[(6, "2026-03-04T10:00:20Z,1,-inf")]),
            vec!["number 6 y -"],
        ),
        (
            "overflow",
            damaged(&[(6, "2026-03-04T10:00:20Z,1,1e999")]),
            vec!["number 6 y -"],
        ),
        (
            "thousands",
            damaged(&[(6, "2026-03-04T10:00:20Z,\"1,234.5\",1")]),
            vec!["number 6 u -"],
        ),
        (
            "decimal comma",
            damaged(&[(6, "2026-03-04T10:00:20Z,\"1,5\",1")]),
            vec!["number 6 u --decimal"],
        ),
    ]
}

/// Damages of rows and times.
fn damaged_rows() -> Vec<Case> {
    vec![
        // Without a row a time is missing too.
        (
            "short row",
            damaged(&[(7, "2026-03-04T10:00:25Z,1")]),
            vec!["row 7 - -", "gap 8 time --missing"],
        ),
        (
            "long row",
            damaged(&[(7, "2026-03-04T10:00:25Z,1,2,3")]),
            vec!["row 7 - -", "gap 8 time --missing"],
        ),
        (
            "blank line",
            damaged(&[(7, "")]),
            vec!["row 7 - -", "gap 8 time --missing"],
        ),
        (
            "no time",
            damaged(&[(13, ",1,2")]),
            vec!["missing 13 time --missing"],
        ),
        (
            "odd time",
            damaged(&[(13, "noon,1,2")]),
            vec!["time 13 time --time-format"],
        ),
        (
            "repeated time",
            damaged(&[(8, "2026-03-04T10:00:25Z,1,2")]),
            vec!["duplicate 8 time --resample", "gap 9 time --missing"],
        ),
        (
            "backward time",
            damaged(&[(8, "2026-03-04T09:00:30Z,1,2")]),
            vec!["backward 8 time -", "gap 9 time --missing"],
        ),
        (
            "gap",
            with_times(&["0", "1", "2", "9", "10", "11"]),
            vec!["gap 5 time --missing"],
        ),
        (
            "short step",
            with_times(&["0", "1", "2", "2.5", "3.5", "4.5"]),
            vec!["step 5 time --resample"],
        ),
    ]
}

/// Damages of whole files, and of several things at once.
fn damaged_files() -> Vec<Case> {
    let latin = [&b"time,u,y in \xb0C\n"[..], &damaged(&[])[9..]].concat();
    let preamble = [&b"Report\n\n"[..], &damaged(&[])].concat();
    let long = |rows: &str| format!("tag,time,value,quality\n{rows}").into_bytes();
    vec![
        (
            "day or month",
            with_times(&["03/04/2026 00:00:01", "03/04/2026 00:00:02"]),
            vec!["file - - --time-format"],
        ),
        ("encoding", latin, vec!["file 1 - --encoding"]),
        ("preamble", preamble, vec!["file 1 - --header-line"]),
        (
            "binary",
            b"u,y\n1,\x002\n".to_vec(),
            vec!["file 2 - --encoding"],
        ),
        ("empty file", b"".to_vec(), vec!["file - - -"]),
        ("no rows", b"u,y\n".to_vec(), vec!["file - - -"]),
        ("no header", b"1.5,2\n3,4\n".to_vec(), vec!["file 1 - -"]),
        ("tag twice", b"u,y,u\n1,2,3\n".to_vec(), vec!["file 1 - -"]),
        (
            "bad quality",
            long("y,0,1,192\ny,1,2,0\ny,2,3,192\n"),
            vec!["quality 3 y --missing"],
        ),
        (
            "odd quality",
            long("y,0,1,192\ny,1,2,fine\ny,2,3,192\n"),
            vec!["quality 3 y -"],
        ),
        (
            "no tag",
            long("y,0,1,192\n,1,2,192\ny,1,3,192\ny,2,3,192\n"),
            vec!["tag 3 tag -"],
        ),
        (
            "own times",
            long("y,0,1,192\nu,0.5,2,192\ny,1,3,192\nu,2,3,192\n"),
            vec!["file - - --resample"],
        ),
        (
            "all at once",
            damaged(&[
                (3, "2026-03-04T10:00:05Z,Bad,x"),
                (5, "2026-03-04T10:00:15Z,1"),
                (9, "2026-03-04T10:00:30Z,inf,2"),
                (13, "soon,\"1,000\",Shutdown"),
            ]),
            vec![
                "missing 3 u --missing",
                "number 3 y --bad-values",
                "row 5 - -",
                "gap 6 time --missing",
                "duplicate 9 time --resample",
                "number 9 u -",
                "gap 10 time --missing",
                "time 13 time --time-format",
                "number 13 u -",
                "missing 13 y --missing",
            ],
        ),
    ]
}

#[test]
fn damaged_exports_are_told_apart() {
    let cases = [damaged_cells(), damaged_rows(), damaged_files()].concat();
    assert!(cases.len() > 20);
    for (name, bytes, expected) in cases {
        let found = check_bytes(&bytes, &Selection::default());
        assert_eq!(damages(&found), expected, "{name}: {:#?}", found.damages);
        for damage in &found.damages {
            assert!(damage.text.contains("a.csv: "), "{name}: {}", damage.text);
            if let Some(line) = damage.line {
                assert!(
                    damage.text.contains(&format!("line {line}")),
                    "{name}: {}",
                    damage.text
                );
            }
        }
    }
}

#[test]
fn what_is_there_is_described() {
    let mut text = "sep=;\ntime;wave;frozen;still;note;odd\ns;bar;degC;-;;\n".to_owned();
    for k in 0..400 {
        let wave = f64::from(k * k % 97) + f64::from(k * 31 % 89) / 8.0;
        let frozen = if (100..180).contains(&k) {
            5.0
        } else {
            f64::from(k * 7 % 50)
        };
        let odd = if k == 250 { 1e6 } else { f64::from(k * k % 11) };
        let time = if k < 300 { k } else { k + 20 };
        writeln!(text, "{time};{wave};{frozen};3;run {k};{odd}").unwrap();
    }
    let text = text.replace('.', ",");
    let found = check_bytes(text.as_bytes(), &Selection::default());
    assert_eq!(
        (
            found.layout,
            found.encoding,
            found.separator,
            found.decimal,
            found.unit_line,
            found.rows
        ),
        (
            Some("wide"),
            Some("UTF-8"),
            Some(';'),
            Some("comma"),
            Some(3),
            400
        )
    );
    let time = found.time.as_ref().unwrap();
    assert_eq!(
        (time.column.as_str(), time.count, time.gaps),
        ("time", 400, 1)
    );
    assert_eq!((time.period_s, time.span_s), (Some(1.0), 419.0));
    assert_eq!(
        time.longest_gap.map(|gap| (gap.seconds, gap.line)),
        Some((21.0, Some(304)))
    );
    assert!((time.off_period_share - 1.0 / 399.0).abs() < 1e-12);
    let tag = |name: &str| found.tags.iter().find(|tag| tag.name == name).unwrap();
    let wave = tag("wave");
    assert_eq!(
        (wave.unit.as_str(), wave.kind, wave.values),
        ("bar", TagKind::Number, 400)
    );
    assert_eq!(
        (wave.quantisation_step, wave.excitation_order),
        (Some(0.125), Some(20))
    );
    let frozen = tag("frozen");
    assert!(frozen.frozen && !wave.frozen);
    assert_eq!(
        frozen.longest_run.map(|run| (run.samples, run.line)),
        Some((80, Some(104)))
    );
    assert!(tag("still").constant && tag("note").kind == TagKind::Text);
    let outliers: Vec<Option<u64>> = tag("odd").outliers.iter().map(|o| o.line).collect();
    assert_eq!(outliers, [Some(254)]);
    assert_eq!(damages(&found), ["gap 304 time --missing"]);
}

#[test]
fn tags_are_named_and_columns_of_texts_are_damages_where_they_are_selected() {
    let folder = tempdir().unwrap();
    let tags = folder.path().join("tags.toml");
    let rule = "[tags.F]\nname = \"flow\"\nunit = \"kg/h\"\nto = \"kg/s\"\nhigh = 7200.0\n";
    fs::write(&tags, rule).unwrap();
    let selection = Selection {
        reading: Reading {
            tags: Some(gt_log::TagMap::read(&tags).unwrap()),
            ..Reading::default()
        },
        ..Selection::default()
    };
    let wide = "time,F,note\n0,3600,a\n1,7200,b\n2,9000,c\n";
    let long = "tag,time,value\nF,0,3600\nF,1,7200\nF,2,9000\n";
    for text in [wide, long] {
        let found = check_bytes(text.as_bytes(), &selection);
        let flow = &found.tags[0];
        assert_eq!((flow.name.as_str(), flow.unit.as_str()), ("flow", "kg/s"));
        assert_eq!(
            (flow.minimum, flow.maximum, flow.missing),
            (Some(1.0), Some(2.0), 1)
        );
        assert!(found.damages.is_empty(), "{:#?}", found.damages);
    }
    let chosen = Selection {
        outputs: vec!["note".to_owned()],
        ..Selection::default()
    };
    let found = check_bytes(wide.as_bytes(), &chosen);
    let expected = [2, 3, 4].map(|line| format!("number {line} note --bad-values"));
    assert_eq!(damages(&found), expected);
    let thousands = "y\n\"1,234\"\n\"5,678\"\n";
    let found = check_bytes(thousands.as_bytes(), &Selection::default());
    assert_eq!(damages(&found), ["number 2 y -", "number 3 y -"]);
}

#[test]
fn what_is_no_table_is_refused() {
    let folder = tempdir().unwrap();
    let path = folder.path().join("a.mcap");
    let text = |selection: &Selection| check(&path, selection).unwrap_err().to_string();
    assert_eq!(
        text(&Selection::default()),
        format!(
            "{}: expected a file that ends in .csv or .parquet, found `.mcap`",
            path.display()
        )
    );
    let bad = Selection {
        reading: Reading {
            encoding: Some("no".to_owned()),
            ..Reading::default()
        },
        ..Selection::default()
    };
    assert!(text(&bad).starts_with("--encoding: expected a label"));
}

proptest! {
    /// No text makes the check panic, and where it finds nothing the file can be read.
    #[test]
    fn prop_what_is_sound_can_be_read(
        text in "(time,u,y|tag,time,value|[,;\\t\n\"]|[0-9]{1,3}|[.:/-]|Bad|a,b\n|[0-9],[0-9],[0-9]\n){0,40}",
    ) {
        let folder = tempdir().unwrap();
        let path = folder.path().join("a.csv");
        fs::write(&path, &text).unwrap();
        let found = check(&path, &Selection::default()).unwrap();
        let numbers = found.tags.iter().filter(|tag| tag.kind == TagKind::Number);
        let outputs: Vec<String> = numbers.map(|tag| tag.name.clone()).collect();
        let times = found.time.as_ref().map_or(2, |time| time.count);
        if found.damages.is_empty() && !outputs.is_empty() && times > 1 {
            let selection = Selection { outputs, ..Selection::default() };
            let read = read_dataset(&path, &selection);
            prop_assert!(read.is_ok(), "{text:?}: {}", read.unwrap_err());
        }
        for damage in &found.damages {
            prop_assert!(damage.kind == DamageKind::File || damage.line.is_some());
        }
    }
}
