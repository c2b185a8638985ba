//! Topics of logs as tables: what was written comes back, bit for bit.

#![allow(clippy::unwrap_used, clippy::panic, reason = "helpers of tests")]

use std::fs::{self, File};
use std::path::{Path, PathBuf};

use gt_core::Signal;
use gt_log::{
    EPOCH_NS, ExportOptions, ExportTime, Exported, LogError, LogWriter, RunMetadata, Selection,
    export, read_dataset, sample_time_ns,
};
use parquet::file::reader::{FileReader as _, SerializedFileReader};
use parquet::record::Field;
use proptest::prelude::*;
use serde_json::json;
use tempfile::{TempDir, tempdir};

/// A folder with the log `a.mcap` of these samples and of two alarms.
fn log(samples: &[[Option<f64>; 2]]) -> (TempDir, PathBuf) {
    let folder = tempdir().unwrap();
    let path = folder.path().join("a.mcap");
    let mut log = LogWriter::create(&path, &RunMetadata::default()).unwrap();
    let signals = [Signal::new("TI-1", "K"), Signal::new("p", "")];
    let topic = log
        .add_topic("/plant/measured", "M", &signals, 0.08, "x")
        .unwrap();
    let schema = json!({"type": "object"});
    let alarms = log
        .add_json_topic("/alarms", "Alarm", &schema, "x")
        .unwrap();
    for (k, sample) in samples.iter().enumerate() {
        log.write_partial(topic, sample_time_ns(k, 0.08), sample)
            .unwrap();
    }
    let first =
        json!({"source": "p", "severity": 500, "onset_s": 1.5, "why": {"a": [1, 2]}, "ack": false});
    let second =
        json!({"source": "TI-1, \"north\"", "severity": 7, "onset_s": 2, "mixed": 1, "ack": null});
    let third = json!({"source": "t", "severity": 8, "onset_s": 3.25, "mixed": "x", "ack": true});
    for (k, alarm) in [first, second, third].iter().enumerate() {
        log.write_json(alarms, sample_time_ns(k, 1.0), alarm)
            .unwrap();
    }
    log.finish().unwrap();
    (folder, path)
}

fn to(path: &Path, name: &str, options: &ExportOptions) -> Result<(PathBuf, Exported), LogError> {
    let out = path.with_file_name(name);
    let exported = export(path, &out, options)?;
    Ok((out, exported))
}

fn topic(topic: &str) -> ExportOptions {
    ExportOptions {
        topic: Some(topic.to_owned()),
        ..ExportOptions::default()
    }
}

/// The names and the rows of a Parquet file.
fn parquet(path: &Path) -> (Vec<String>, Vec<Vec<Field>>) {
    let reader = SerializedFileReader::new(File::open(path).unwrap()).unwrap();
    let rows: Vec<_> = reader
        .get_row_iter(None)
        .unwrap()
        .map(|row| row.unwrap().into_columns())
        .collect();
    let schema = reader.metadata().file_metadata().schema_descr();
    let names = schema.columns().iter().map(|own| own.name().to_owned());
    let cells = rows
        .into_iter()
        .map(|row| row.into_iter().map(|(_, field)| field).collect());
    (names.collect(), cells.collect())
}

#[test]
fn csv_tells_absent_from_invalid() {
    let samples = [
        [Some(0.1), Some(-0.0)],
        [None, Some(1e300)],
        [Some(f64::NAN), Some(f64::INFINITY)],
    ];
    let (_folder, path) = log(&samples);
    let (out, exported) = to(&path, "a.csv", &ExportOptions::default()).unwrap();
    assert_eq!(
        fs::read_to_string(&out).unwrap(),
        "time,TI-1,p\n\
         2006-01-18T00:00:00.000000000Z,0.1,-0.0\n\
         2006-01-18T00:00:00.080000000Z,,1e300\n\
         2006-01-18T00:00:00.160000000Z,NaN,inf\n"
    );
    assert_eq!((exported.rows, exported.time.as_str()), (3, "time"));
    let absent: Vec<_> = exported
        .columns
        .iter()
        .map(|own| (own.name.as_str(), own.unit.as_str(), own.kind, own.absent))
        .collect();
    assert_eq!(absent, [("TI-1", "K", "number", 1), ("p", "", "number", 0)]);
    let options = ExportOptions {
        time: ExportTime::Seconds,
        rows: Some(1..3),
        tags: vec!["p".to_owned()],
        ..ExportOptions::default()
    };
    let (out, _) = to(&path, "b.csv", &options).unwrap();
    assert_eq!(
        fs::read_to_string(&out).unwrap(),
        "time,p\n0.080000000,1e300\n0.160000000,inf\n"
    );
}

#[test]
fn parquet_has_instants_and_nulls() {
    let samples = [[Some(0.1), Some(-0.0)], [None, Some(f64::NAN)]];
    let (_folder, path) = log(&samples);
    let (out, _) = to(&path, "a.parquet", &ExportOptions::default()).unwrap();
    let (names, rows) = parquet(&out);
    assert_eq!(names, ["time", "TI-1", "p"]);
    let epoch = i64::try_from(EPOCH_NS).unwrap();
    assert_eq!(rows[0][..2], [Field::Long(epoch), Field::Double(0.1)]);
    assert!(matches!(rows[0][2], Field::Double(own) if own.to_bits() == (-0.0_f64).to_bits()));
    assert_eq!(rows[1][..2], [Field::Long(epoch + 80_000_000), Field::Null]);
    assert!(matches!(rows[1][2], Field::Double(own) if own.is_nan()));
    let reader = SerializedFileReader::new(File::open(&out).unwrap()).unwrap();
    let metadata = reader.metadata().file_metadata();
    let time = metadata.schema_descr().column(0);
    assert_eq!(
        format!("{:?}", time.logical_type_ref().unwrap()),
        format!(
            "{:?}",
            parquet::basic::LogicalType::timestamp(true, parquet::basic::TimeUnit::NANOS)
        )
    );
    let pairs = metadata.key_value_metadata().unwrap();
    assert!(
        pairs
            .iter()
            .any(|own| own.key == "unit:TI-1" && own.value.as_deref() == Some("K"))
    );
}

#[test]
fn text_topics_are_tables_too() {
    let (_folder, path) = log(&[]);
    let (out, exported) = to(&path, "a.csv", &topic("/alarms")).unwrap();
    assert_eq!(
        fs::read_to_string(&out).unwrap(),
        "time,ack,onset_s,severity,source,why,mixed\n\
         2006-01-18T00:00:00.000000000Z,false,1.5,500,p,\"{\"\"a\"\":[1,2]}\",\n\
         2006-01-18T00:00:01.000000000Z,,2.0,7,\"TI-1, \"\"north\"\"\",,1\n\
         2006-01-18T00:00:02.000000000Z,true,3.25,8,t,,\"\"\"x\"\"\"\n"
    );
    let kinds: Vec<_> = exported.columns.iter().map(|own| own.kind).collect();
    assert_eq!(
        kinds,
        ["truth", "number", "integer", "text", "text", "text"]
    );
    let (out, _) = to(&path, "a.parquet", &topic("/alarms")).unwrap();
    let (_, rows) = parquet(&out);
    assert_eq!(
        rows[0][1..],
        [
            Field::Bool(false),
            Field::Double(1.5),
            Field::Long(500),
            Field::Str("p".to_owned()),
            Field::Str("{\"a\":[1,2]}".to_owned()),
            Field::Null,
        ]
    );
    // What lies deeper is there under its own name.
    let options = ExportOptions {
        tags: vec!["why.a[1]".to_owned(), "source".to_owned()],
        ..topic("/alarms")
    };
    let (out, _) = to(&path, "b.csv", &options).unwrap();
    let text = fs::read_to_string(&out).unwrap();
    assert_eq!(
        text.lines().take(2).collect::<Vec<_>>(),
        [
            "time,why.a[1],source",
            "2006-01-18T00:00:00.000000000Z,2.0,p"
        ]
    );
}

#[test]
fn a_field_called_time_keeps_its_name() {
    let folder = tempdir().unwrap();
    let path = folder.path().join("a.mcap");
    let mut log = LogWriter::create(&path, &RunMetadata::default()).unwrap();
    let signals = Signal::named(&["time", "timestamp"]);
    let topic = log
        .add_topic("/plant/measured", "M", &signals, 1.0, "x")
        .unwrap();
    log.write(topic, EPOCH_NS, &[1.0, 2.0]).unwrap();
    log.finish().unwrap();
    let (out, exported) = to(&path, "a.csv", &ExportOptions::default()).unwrap();
    assert_eq!(exported.time, "log_time");
    assert!(
        fs::read_to_string(&out)
            .unwrap()
            .starts_with("log_time,time,timestamp\n")
    );
}

#[test]
fn mistakes_are_named() {
    let (folder, path) = log(&[[Some(1.0), Some(2.0)]]);
    let error = |name: &str, options: &ExportOptions| {
        let out = folder.path().join(name);
        let error = export(&path, &out, options).unwrap_err().to_string();
        assert!(!out.exists(), "{name}");
        let prefix = format!("{}: ", path.display());
        let prefix = error.strip_prefix(&prefix);
        prefix.unwrap_or(&error).to_owned()
    };
    let all = ExportOptions::default();
    assert!(
        error("a.txt", &all)
            .ends_with("a.txt: expected a file to write that ends in .csv or .parquet")
    );
    assert_eq!(
        error("a.csv", &topic("/x")),
        "expected a topic `/x`, found /alarms, /plant/measured"
    );
    let rows = ExportOptions {
        rows: Some(0..2),
        ..ExportOptions::default()
    };
    assert_eq!(
        error("a.csv", &rows),
        "expected rows A:B with 0 <= A < B <= 1, found 0:2 (0-based, half open)"
    );
    let tags = ExportOptions {
        tags: vec!["q".to_owned()],
        ..ExportOptions::default()
    };
    assert_eq!(
        error("a.csv", &tags),
        "expected a column `q`, found TI-1, p"
    );
    let (_folder, empty) = log(&[]);
    let out = empty.with_file_name("b.csv");
    let error = export(&empty, &out, &all).unwrap_err();
    assert!(matches!(error, LogError::NoMessages { .. }));
    let files = fs::read_dir(empty.parent().unwrap()).unwrap().count();
    assert_eq!(files, 1, "the log alone");
}

#[test]
fn a_time_beyond_the_table_is_named() {
    let folder = tempdir().unwrap();
    let path = folder.path().join("a.mcap");
    let mut log = LogWriter::create(&path, &RunMetadata::default()).unwrap();
    let topic = log
        .add_topic("/plant/measured", "M", &Signal::named(&["a"]), 1.0, "x")
        .unwrap();
    log.write(topic, u64::MAX, &[1.0]).unwrap();
    log.finish().unwrap();
    let out = folder.path().join("a.parquet");
    assert_eq!(
        export(&path, &out, &ExportOptions::default())
            .unwrap_err()
            .to_string(),
        format!(
            "{}: message 0: expected a time that the table can hold, found 18446744073709551615 ns \
             since 1970; select other rows, or write CSV with the time in seconds",
            out.display()
        )
    );
    let (out, _) = to(&path, "a.csv", &ExportOptions::default()).unwrap();
    assert!(
        fs::read_to_string(out)
            .unwrap()
            .contains("2554-07-21T23:34:33.709551615Z,1.0")
    );
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(40))]

    /// Any bits, absent ones too, through both kinds of table.
    #[test]
    fn prop_every_bit_returns(
        samples in proptest::collection::vec(proptest::array::uniform2(proptest::option::of(any::<u64>())), 1..30),
    ) {
        let samples: Vec<[Option<f64>; 2]> = samples
            .into_iter()
            .map(|own| own.map(|bits| bits.map(f64::from_bits)))
            .collect();
        let (_folder, path) = log(&samples);
        let (out, _) = to(&path, "a.parquet", &ExportOptions::default()).unwrap();
        let (_, rows) = parquet(&out);
        prop_assert_eq!(rows.len(), samples.len());
        for (row, sample) in rows.iter().zip(&samples) {
            for (cell, value) in row[1..].iter().zip(sample) {
                match (cell, value) {
                    (Field::Null, None) => {}
                    (Field::Double(own), Some(value)) => {
                        prop_assert_eq!(own.to_bits(), value.to_bits());
                    }
                    other => prop_assert!(false, "{:?}", other),
                }
            }
        }
        let (out, _) = to(&path, "a.csv", &ExportOptions::default()).unwrap();
        let text = fs::read_to_string(&out).unwrap();
        for (line, sample) in text.lines().skip(1).zip(&samples) {
            for (cell, value) in line.split(',').skip(1).zip(sample) {
                match value {
                    None => prop_assert_eq!(cell, ""),
                    Some(value) if value.is_nan() => prop_assert_eq!(cell, "NaN"),
                    Some(value) => {
                        let own: f64 = cell.parse().unwrap();
                        prop_assert_eq!(own.to_bits(), value.to_bits());
                    }
                }
            }
        }
    }
}

/// The dataset of the table is that of the log.
#[test]
fn an_exported_table_gives_the_same_dataset() {
    let samples: Vec<[Option<f64>; 2]> = (0..200)
        .map(|k| [Some((f64::from(k) * 0.1).sin()), Some(f64::from(k).sqrt())])
        .collect();
    let (_folder, path) = log(&samples);
    let selection = Selection {
        inputs: vec!["p".to_owned()],
        outputs: vec!["TI-1".to_owned()],
        ..Selection::default()
    };
    let from_log = read_dataset(&path, &selection).unwrap().dataset;
    for time in [ExportTime::Iso, ExportTime::Seconds] {
        let options = ExportOptions {
            time,
            ..ExportOptions::default()
        };
        let (out, _) = to(&path, "a.csv", &options).unwrap();
        let from_table = read_dataset(&out, &selection).unwrap().dataset;
        assert_eq!(from_table.u(), from_log.u());
        assert_eq!(from_table.y(), from_log.y());
        assert_eq!(from_table.sample_time_s().to_bits(), 0.08_f64.to_bits());
    }
}
