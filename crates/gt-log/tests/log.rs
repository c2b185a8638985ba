//! Logs written and read back.

#![allow(clippy::unwrap_used, reason = "helpers of tests")]

use std::fs;
use std::path::Path;

use gt_core::Signal;
use gt_log::{
    EPOCH_NS, LogError, LogWriter, RunMetadata, Selection, Warning, columns, info, read_attachment,
    read_dataset, read_json_messages, sample_time_ns, sha256_hex,
};
use mcap::records::op;
use serde_json::json;
use tempfile::tempdir;

fn run() -> RunMetadata {
    RunMetadata {
        seed: Some(7),
        run_index: Some(3),
        config_toml: "variant = \"prototype\"\n".to_owned(),
        data_sha256: Some("ab".repeat(32)),
        ..RunMetadata::default()
    }
}

fn signals() -> Vec<Signal> {
    vec![
        Signal::new("fuel_flow_kg_s", "kg/s"),
        Signal::new("TI-101.PV", "K"),
        Signal::new("TI_101_PV", "degC"),
    ]
}

/// Values whose every bit counts: signed zero, subnormals, extremes, a NaN.
const SAMPLES: [[f64; 3]; 4] = [
    [-0.0, 5e-324, f64::MAX],
    [0.1, -2.225073858507201e-308, f64::MIN],
    [1.0 / 3.0, f64::EPSILON, 1e300],
    [f64::NAN, 273.15, -1.0],
];

fn write_log(path: &Path) -> Result<(), LogError> {
    let mut log = LogWriter::create(path, &run())?;
    log.attach(
        "config.toml",
        "application/toml",
        run().config_toml.as_bytes(),
    )?;
    let measured = log.add_topic("/plant/measured", "Measured", &signals(), 0.08, "GT1")?;
    let truth = log.add_topic("/plant/truth", "Truth", &signals()[..1], 0.08, "GT1")?;
    let alarms = log.add_json_topic("/alarms", "Alarm", &json!({"type": "object"}), "GT1")?;
    for (k, sample) in SAMPLES.iter().enumerate() {
        let time_ns = sample_time_ns(k, 0.08);
        log.write(measured, time_ns, sample)?;
        log.write(truth, time_ns, &sample[..1])?;
    }
    log.write_json(alarms, sample_time_ns(2, 0.08), &json!({"severity": 500}))?;
    log.finish()
}

fn select(inputs: &[&str], outputs: &[&str]) -> Selection {
    let own = |names: &[&str]| names.iter().map(|&name| name.to_owned()).collect();
    Selection {
        inputs: own(inputs),
        outputs: own(outputs),
        ..Selection::default()
    }
}

fn error(path: &Path, selection: &Selection) -> String {
    let error = read_dataset(path, selection).unwrap_err().to_string();
    let prefix = format!("{}: ", path.display());
    error.strip_prefix(&prefix).unwrap_or(&error).to_owned()
}

#[test]
fn every_bit_returns() {
    let folder = tempdir().unwrap();
    let path = folder.path().join("a.mcap");
    write_log(&path).unwrap();
    let imported = read_dataset(
        &path,
        &select(&["fuel_flow_kg_s"], &["TI_101_PV", "TI-101.PV"]),
    )
    .unwrap();
    let dataset = &imported.dataset;
    for (k, sample) in SAMPLES.iter().enumerate() {
        assert_eq!(
            dataset.u()[(0, k)].to_bits(),
            sample[0].to_bits(),
            "u at {k}"
        );
        assert_eq!(
            dataset.y()[(0, k)].to_bits(),
            sample[2].to_bits(),
            "y0 at {k}"
        );
        assert_eq!(
            dataset.y()[(1, k)].to_bits(),
            sample[1].to_bits(),
            "y1 at {k}"
        );
    }
    assert_eq!(dataset.inputs(), &signals()[..1]);
    assert_eq!(
        dataset.outputs(),
        [signals()[2].clone(), signals()[1].clone()]
    );
    assert_eq!(dataset.sample_time_s().to_bits(), 0.08_f64.to_bits());
    assert_eq!(dataset.start_time_s().to_bits(), 0.0_f64.to_bits());
    assert_eq!(imported.total_rows, 4);
    assert_eq!(imported.start_unix_ns, Some(i128::from(EPOCH_NS)));
    assert_eq!(imported.sha256, sha256_hex(&fs::read(&path).unwrap()));
    let invalid = Warning::InvalidSamples {
        column: "fuel_flow_kg_s".to_owned(),
        count: 1,
    };
    assert_eq!(imported.warnings, [invalid]);
}

#[test]
fn rows_keep_their_time() {
    let folder = tempdir().unwrap();
    let path = folder.path().join("a.mcap");
    write_log(&path).unwrap();
    let rows = Selection {
        rows: Some(1..3),
        ..select(&[], &["*"])
    };
    let imported = read_dataset(&path, &rows).unwrap();
    assert_eq!(imported.dataset.ny(), 3);
    assert_eq!(imported.dataset.len(), 2);
    assert_eq!(
        imported.dataset.start_time_s().to_bits(),
        0.08_f64.to_bits()
    );
    assert_eq!(
        imported.start_unix_ns,
        Some(i128::from(EPOCH_NS) + 80_000_000)
    );
    assert_eq!(
        error(
            &path,
            &Selection {
                rows: Some(2..5),
                ..select(&[], &["*"])
            }
        ),
        "expected rows A:B with 0 <= A < B <= 4, found 2:5 (0-based, half open)"
    );
}

#[test]
fn the_same_content_gives_the_same_bytes() {
    let folder = tempdir().unwrap();
    let (a, b) = (
        folder.path().join("a.mcap"),
        folder.path().join("another_name.mcap"),
    );
    write_log(&a).unwrap();
    write_log(&b).unwrap();
    assert_eq!(fs::read(&a).unwrap(), fs::read(&b).unwrap());
}

#[test]
fn metadata_and_attachments_come_before_the_first_chunk() {
    let folder = tempdir().unwrap();
    let path = folder.path().join("a.mcap");
    write_log(&path).unwrap();
    let bytes = fs::read(&path).unwrap();
    let opcodes: Vec<u8> = mcap::read::LinearReader::new(&bytes)
        .unwrap()
        .map(|record| record.unwrap().opcode())
        .take(6)
        .collect();
    let expected = [
        op::HEADER,
        op::METADATA,
        op::METADATA,
        op::METADATA,
        op::ATTACHMENT,
        op::CHUNK,
    ];
    assert_eq!(opcodes, expected);
}

#[test]
fn summary_repeats_schemas_and_channels() {
    let folder = tempdir().unwrap();
    let path = folder.path().join("a.mcap");
    write_log(&path).unwrap();
    let summary = mcap::Summary::read(&fs::read(&path).unwrap())
        .unwrap()
        .unwrap();
    let mut topics: Vec<&str> = summary
        .channels
        .values()
        .map(|c| c.topic.as_str())
        .collect();
    topics.sort_unstable();
    assert_eq!(topics, ["/alarms", "/plant/measured", "/plant/truth"]);
    assert_eq!(summary.schemas.len(), 3);
    assert_eq!(summary.stats.unwrap().message_count, 9);
    let measured = summary
        .channels
        .values()
        .find(|c| c.topic == "/plant/measured")
        .unwrap();
    let metadata =
        |key: &str| -> serde_json::Value { serde_json::from_str(&measured.metadata[key]).unwrap() };
    assert_eq!(
        metadata("tags"),
        json!({
            "fuel_flow_kg_s": "fuel_flow_kg_s",
            "TI_101_PV_2": "TI-101.PV",
            "TI_101_PV": "TI_101_PV",
        })
    );
    assert_eq!(
        metadata("units"),
        json!({"fuel_flow_kg_s": "kg/s", "TI_101_PV_2": "K", "TI_101_PV": "degC"})
    );
    assert_eq!(measured.metadata["asset"], "GT1");
    assert_eq!(measured.metadata["sample_period_s"], "0.08");
}

#[test]
fn log_time_is_publish_time_and_the_sequence_counts() {
    let folder = tempdir().unwrap();
    let path = folder.path().join("a.mcap");
    write_log(&path).unwrap();
    let bytes = fs::read(&path).unwrap();
    let found: Vec<(u32, u64, u64)> = mcap::MessageStream::new(&bytes)
        .unwrap()
        .map(Result::unwrap)
        .filter(|message| message.channel.topic == "/plant/measured")
        .map(|message| (message.sequence, message.log_time, message.publish_time))
        .collect();
    let time_ns = |k: u64| EPOCH_NS + k * 80_000_000;
    let expected: Vec<_> = (0..4)
        .map(|k| (k, time_ns(k.into()), time_ns(k.into())))
        .collect();
    assert_eq!(found, expected);
}

#[test]
fn an_unfinished_log_leaves_nothing() {
    let folder = tempdir().unwrap();
    let path = folder.path().join("a.mcap");
    let part = folder.path().join("a.mcap.part");
    let mut log = LogWriter::create(&path, &run()).unwrap();
    let topic = log.add_topic("/x", "X", &signals(), 1.0, "").unwrap();
    log.write(topic, EPOCH_NS, &SAMPLES[0]).unwrap();
    assert!(part.exists() && !path.exists());
    drop(log);
    assert!(!part.exists() && !path.exists());
    write_log(&path).unwrap();
    assert!(!part.exists() && path.exists());
}

#[test]
fn a_flushed_log_is_readable_before_it_is_finished() {
    let folder = tempdir().unwrap();
    let path = folder.path().join("a.mcap");
    let mut log = LogWriter::create(&path, &run()).unwrap();
    let topic = log.add_topic("/x", "X", &signals(), 1.0, "").unwrap();
    log.write(topic, EPOCH_NS, &SAMPLES[0]).unwrap();
    log.flush().unwrap();
    let bytes = fs::read(folder.path().join("a.mcap.part")).unwrap();
    let options = mcap::read::Options::IgnoreEndMagic;
    let messages = mcap::MessageStream::new_with_options(&bytes, options.into()).unwrap();
    assert_eq!(messages.flatten().count(), 1);
    log.finish().unwrap();
}

#[test]
fn info_tells_what_was_written() {
    let folder = tempdir().unwrap();
    let path = folder.path().join("a.mcap");
    write_log(&path).unwrap();
    let info = info(&path).unwrap();
    assert_eq!((info.profile.as_str(), info.messages), ("", 9));
    assert_eq!(
        (info.first_ns, info.last_ns),
        (Some(EPOCH_NS), Some(EPOCH_NS + 240_000_000))
    );
    assert_eq!(info.duration_s.to_bits(), 0.24_f64.to_bits());
    assert_eq!(
        info.chunks
            .compressions
            .iter()
            .map(String::as_str)
            .collect::<Vec<_>>(),
        ["zstd"]
    );
    assert_eq!(info.size_bytes, fs::metadata(&path).unwrap().len());
    let topics: Vec<_> = info
        .topics
        .iter()
        .map(|t| {
            (
                t.topic.as_str(),
                t.schema.as_str(),
                t.encoding.as_str(),
                t.messages,
            )
        })
        .collect();
    assert_eq!(
        topics,
        [
            ("/alarms", "gtfdi.v1.Alarm", "json", 1),
            ("/plant/measured", "gtfdi.v1.Measured", "protobuf", 4),
            ("/plant/truth", "gtfdi.v1.Truth", "protobuf", 4),
        ]
    );
    assert_eq!(info.topics[0].first_s, Some(0.16));
    assert_eq!(info.topics[1].fields, signals());
    let names: Vec<_> = info
        .metadata
        .iter()
        .map(|record| record.name.as_str())
        .collect();
    assert_eq!(names, ["gtfdi.run", "gtfdi.config", "gtfdi.data"]);
    let run_values = &info.metadata[0].values;
    assert_eq!(
        (
            run_values["seed"].as_str(),
            run_values["run_index"].as_str()
        ),
        ("7", "3")
    );
    assert_eq!(run_values["version"], env!("CARGO_PKG_VERSION"));
    assert_eq!(
        run_values["config_sha256"],
        sha256_hex(run().config_toml.as_bytes())
    );
    assert!(
        run_values["rustc"].starts_with("rustc "),
        "{}",
        run_values["rustc"]
    );
    assert_eq!(info.metadata[1].values["toml"], run().config_toml);
    assert_eq!(info.metadata[2].values["input_sha256"], "ab".repeat(32));
    assert_eq!(info.attachments[0].name, "config.toml");
    assert_eq!(
        info.attachments[0].size_bytes,
        run().config_toml.len() as u64
    );
    serde_json::to_string(&info).unwrap();
}

#[test]
fn attachments_and_json_messages_return() {
    let folder = tempdir().unwrap();
    let path = folder.path().join("a.mcap");
    write_log(&path).unwrap();
    assert_eq!(
        read_attachment(&path, "config.toml").unwrap(),
        run().config_toml.as_bytes()
    );
    assert!(matches!(
        read_attachment(&path, "x").unwrap_err(),
        LogError::UnknownAttachment { available, .. } if available == ["config.toml"]
    ));
    let messages = read_json_messages(&path, "/alarms").unwrap();
    assert_eq!(messages.len(), 1);
    assert_eq!(messages[0].time_ns, EPOCH_NS + 160_000_000);
    assert_eq!(messages[0].value, json!({"severity": 500}));
    assert!(matches!(
        read_json_messages(&path, "/plant/truth"),
        Err(LogError::Encoding { .. })
    ));
}

#[test]
fn columns_are_tags_with_units() {
    let folder = tempdir().unwrap();
    let path = folder.path().join("a.mcap");
    write_log(&path).unwrap();
    assert_eq!(columns(&path, None).unwrap(), signals());
    assert_eq!(
        columns(&path, Some("/plant/truth")).unwrap(),
        &signals()[..1]
    );
}

#[test]
fn wrong_topics_are_named() {
    let folder = tempdir().unwrap();
    let path = folder.path().join("a.mcap");
    write_log(&path).unwrap();
    let topic = |topic: &str| Selection {
        topic: Some(topic.to_owned()),
        ..select(&[], &["*"])
    };
    assert_eq!(
        error(&path, &topic("/plant")),
        "expected a topic `/plant`, found /alarms, /plant/measured, /plant/truth"
    );
    assert_eq!(
        error(&path, &topic("/alarms")),
        "expected 2 rows or more to tell the sample time, found 1; give it",
        "the one alarm of the log: numbers of JSON are columns too"
    );
    assert_eq!(
        error(
            &path,
            &Selection {
                time: Some("t".to_owned()),
                ..select(&[], &["*"])
            }
        ),
        "an MCAP log carries its own time; expected no time column, found `t`"
    );
}

/// A log of one signal `y` with these times and values.
fn one_signal(path: &Path, samples: &[(u64, Option<f64>)]) {
    let mut log = LogWriter::create(path, &RunMetadata::default()).unwrap();
    let topic = log
        .add_topic("/plant/measured", "Y", &Signal::named(&["y"]), 1.0, "")
        .unwrap();
    for &(time_s, value) in samples {
        log.write_partial(topic, EPOCH_NS + time_s * 1_000_000_000, &[value])
            .unwrap();
    }
    log.finish().unwrap();
}

#[test]
fn an_absent_value_is_an_error_where_it_is_selected() {
    let folder = tempdir().unwrap();
    let path = folder.path().join("a.mcap");
    one_signal(
        &path,
        &[(0, Some(1.0)), (1, Some(2.0)), (2, None), (3, Some(3.0))],
    );
    assert_eq!(
        error(&path, &select(&[], &["y"])),
        "topic `/plant/measured`, 2 s: expected a value of `y`, found none"
    );
    let before = Selection {
        rows: Some(0..2),
        ..select(&[], &["y"])
    };
    assert_eq!(
        read_dataset(&path, &before).unwrap().dataset.y().as_slice(),
        [1.0, 2.0]
    );
}

#[test]
fn times_must_be_uniform_and_a_sample_time_overrides_them() {
    let folder = tempdir().unwrap();
    let path = folder.path().join("a.mcap");
    let at = |times: &[u64]| {
        let samples: Vec<_> = times.iter().map(|&t| (t, Some(t as f64))).collect();
        one_signal(&path, &samples);
    };
    at(&[0, 1, 2, 4, 5]);
    assert_eq!(
        error(&path, &select(&[], &["y"])),
        "message 3: expected a step of 1 s (within 0.001 of it), found 2 s; select rows without a \
         gap, or give the sample time"
    );
    let given = Selection {
        sample_time_s: Some(0.5),
        ..select(&[], &["y"])
    };
    let dataset = read_dataset(&path, &given).unwrap().dataset;
    assert_eq!((dataset.sample_time_s(), dataset.len()), (0.5, 5));
    at(&[0, 1, 1]);
    assert!(error(&path, &select(&[], &["y"])).starts_with("message 2: expected a time after 1 s"));
    at(&[]);
    assert_eq!(
        error(&path, &select(&[], &["y"])),
        "topic `/plant/measured`: expected messages, found none"
    );
    at(&[0]);
    assert_eq!(
        error(&path, &select(&[], &["y"])),
        "expected 2 rows or more to tell the sample time, found 1; give it"
    );
    // Messages may be stored in another order than that of time.
    at(&[2, 0, 1]);
    let dataset = read_dataset(&path, &select(&[], &["y"])).unwrap().dataset;
    assert_eq!(dataset.y().as_slice(), [0.0, 1.0, 2.0]);
}

#[test]
fn the_writer_refuses_what_does_not_fit() {
    let folder = tempdir().unwrap();
    let mut log = LogWriter::create(&folder.path().join("a.mcap"), &run()).unwrap();
    let twice = [Signal::new("a", ""), Signal::new("a", "K")];
    assert!(matches!(
        log.add_topic("/x", "X", &twice, 1.0, ""),
        Err(LogError::DuplicateField { field, .. }) if field == "a"
    ));
    assert!(matches!(
        log.add_topic("/x", "a.b", &twice[..1], 1.0, ""),
        Err(LogError::MessageName { found }) if found == "a.b"
    ));
    assert!(matches!(
        log.add_topic("/x", "X", &twice[..1], 0.0, ""),
        Err(LogError::SampleTime { found: 0.0 })
    ));
    let topic = log.add_topic("/x", "X", &twice[..1], 1.0, "").unwrap();
    assert!(matches!(
        log.add_topic("/x", "Y", &twice[..1], 1.0, ""),
        Err(LogError::DuplicateTopic { topic }) if topic == "/x"
    ));
    assert!(matches!(
        log.write(topic, 0, &[1.0, 2.0]),
        Err(LogError::FieldCount {
            expected: 1,
            found: 2,
            ..
        })
    ));
    let mut other = LogWriter::create(&folder.path().join("b.mcap"), &run()).unwrap();
    assert!(matches!(
        other.write(topic, 0, &[1.0]),
        Err(LogError::ForeignTopic {
            expected: 0,
            found: 0
        })
    ));
    let nowhere = folder.path().join("none").join("a.mcap");
    assert!(matches!(
        LogWriter::create(&nowhere, &run()),
        Err(LogError::Io {
            action: "create",
            ..
        })
    ));
    assert!(matches!(
        LogWriter::create(folder.path(), &run()),
        Err(LogError::Directory { .. })
    ));
}
