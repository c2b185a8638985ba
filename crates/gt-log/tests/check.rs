//! What is said of damaged exports: every damage, with its place, its tag and what mends it.

#![allow(clippy::unwrap_used, reason = "helpers of tests")]

use std::fmt::Write as _;
use std::fs;

use gt_log::{
    DamageKind, DataCheck, Reading, Resample, ResampleMethod, Selection, TagKind, check,
    read_dataset,
};
use gtfdi::ident::Missing;
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
        (
            "no header, decimal comma",
            b"0;0,5;0\n1;1,5;0\n".to_vec(),
            vec!["file 1 - -"],
        ),
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
    let path = folder.path().join("a.xlsx");
    let text = |selection: &Selection| check(&path, selection).unwrap_err().to_string();
    assert_eq!(
        text(&Selection::default()),
        format!(
            "{}: expected a file that ends in .csv, .parquet or .mcap, found `.xlsx`",
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

/// A log of a stranger: JSON, a message that leaves a field out, one whose number is null, one that
/// is no JSON, and a second without a message.
#[test]
fn messages_of_strangers_are_examined() {
    let folder = tempdir().unwrap();
    let path = folder.path().join("a.mcap");
    let mut log = mcap::Writer::new(fs::File::create(&path).unwrap()).unwrap();
    let channel = log
        .add_channel(0, "/sensors", "json", &std::collections::BTreeMap::new())
        .unwrap();
    for k in 0..40_u64 {
        let data = match k {
            5 => r#"{"flow": 1.5}"#.to_owned(),
            7 => r#"{"flow": 1.5, "level": "#.to_owned(),
            _ => format!(
                r#"{{"flow": {}, "level": {}, "mode": "auto"}}"#,
                k % 3,
                k * k % 7
            ),
        };
        if k == 20 {
            continue;
        }
        let header = mcap::records::MessageHeader {
            channel_id: channel,
            sequence: 0,
            log_time: 1_000_000_000 * k,
            publish_time: 1_000_000_000 * k,
        };
        log.write_to_known_channel(&header, data.as_bytes())
            .unwrap();
    }
    log.finish().unwrap();
    drop(log);
    let topic = |topic: &str| Selection {
        topic: Some(topic.to_owned()),
        ..Selection::default()
    };
    let found = check(&path, &topic("/sensors")).unwrap();
    assert_eq!(found.layout, Some("log"));
    assert_eq!(found.rows, 39);
    let time = found.time.as_ref().unwrap();
    assert_eq!((time.count, time.gaps, time.period_s), (39, 1, Some(1.0)));
    let tags: Vec<(&str, usize, usize)> = found
        .tags
        .iter()
        .map(|tag| (tag.name.as_str(), tag.values, tag.missing))
        .collect();
    assert_eq!(tags, [("flow", 38, 0), ("level", 37, 1)]);
    let places: Vec<(DamageKind, Option<usize>, Option<&str>)> = found
        .damages
        .iter()
        .map(|damage| (damage.kind, damage.row, damage.mended_by))
        .collect();
    assert_eq!(
        places,
        [
            (DamageKind::Missing, Some(5), Some("--missing")),
            (DamageKind::Row, Some(7), None),
            (DamageKind::Gap, Some(20), Some("--missing")),
        ]
    );
    assert!(
        found.damages[0]
            .text
            .ends_with("topic `/sensors`, 5 s: expected a value of `level`, found none"),
        "{}",
        found.damages[0].text
    );
    let found = check(&path, &Selection::default()).unwrap();
    assert_eq!(found.damages[0].mended_by, Some("--topic"));
    let resampled = Selection {
        reading: Reading {
            resample: Some(mean(2.0)),
            ..Reading::default()
        },
        ..topic("/sensors")
    };
    let refused = check(&path, &resampled).unwrap_err().to_string();
    assert!(
        refused.ends_with("--resample: expected with .csv or .parquet, found an MCAP log"),
        "{refused}"
    );
}

fn mean(step_s: f64) -> Resample {
    Resample {
        step_s,
        method: ResampleMethod::Mean,
        hold_at_most_s: None,
    }
}

/// Two tags at times of their own become samples: what resampling mends is no damage any more, what
/// it leaves missing is, and words are where they are not passed over.
#[test]
fn a_table_is_examined_as_it_is_resampled() {
    let mut text = "tag,time,value\n".to_owned();
    for k in 0..40 {
        writeln!(text, "u,{k},{}", k * k % 7).unwrap();
        if !(12..16).contains(&k) {
            writeln!(text, "y,{k}.25,{}", k * k % 5).unwrap();
        }
    }
    text.push_str("y,39.5,Bad\n");
    let selection = |missing: Missing| Selection {
        missing,
        reading: Reading {
            resample: Some(mean(2.0)),
            ..Reading::default()
        },
        ..Selection::default()
    };
    let found = check_bytes(text.as_bytes(), &selection(Missing::Break));
    let resampled = found.resampled.as_ref().unwrap();
    assert_eq!((resampled.samples, resampled.resample.step_s), (20, 2.0));
    let time = found.time.as_ref().unwrap();
    assert_eq!((time.count, time.period_s, time.gaps), (20, Some(2.0), 0));
    let values: Vec<usize> = found.tags.iter().map(|tag| tag.values).collect();
    assert_eq!(values, [20, 18]);
    assert_eq!(
        found.not_compared.map(|cause| cause.to_string()).as_deref(),
        Some("expected 38 samples at which all tags have values, found 14")
    );
    assert_eq!(found.damages.len(), 1, "{:#?}", found.damages);
    assert!(
        found.damages[0].text.ends_with(
            "`y`: expected a reading for each of 20 samples, found none for 2, the first at sample 6"
        ),
        "{}",
        found.damages[0].text
    );
    // Without a break the word is refused, before anything is resampled.
    let found = check_bytes(text.as_bytes(), &selection(Missing::Refuse));
    let kinds: Vec<DamageKind> = found.damages.iter().map(|damage| damage.kind).collect();
    assert_eq!(kinds, [DamageKind::Missing, DamageKind::Missing]);
}
