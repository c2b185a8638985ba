//! What logs say beside the samples: qualities, remarks, models, their version.

#![allow(clippy::unwrap_used, reason = "helpers of tests")]

use std::collections::BTreeMap;
use std::fs::File;
use std::io::BufWriter;
use std::path::Path;

use gt_core::{Dataset, Signal};
use gt_log::{
    EPOCH_NS, LogWriter, LoggedModel, ModelFile, Quality, RunMetadata, Selection, info,
    read_attachment, read_dataset, read_json_messages, sample_time_ns, sha256_hex, verify,
    write_run,
};
use gtfdi::ident::{Arx, OrderKind, validate};
use gtfdi::plant::{Channel, Fault, Mode, Run, Scenario, Shape, Step, simulate};
use mcap::records::Metadata;
use tempfile::tempdir;

/// A run of 64 s whose sensor t3 is dead from 1.6 s on, for 0.8 s.
fn run_with_dropout() -> Run {
    let t3 = Channel::named("t3").unwrap();
    let mut fault = Fault::sensor(t3, Mode::Dropout, 1.6, Shape::Step(Step { size: 1.0 }));
    fault.end_s = Some(2.4);
    simulate(&Scenario {
        duration_s: 64.0,
        faults: vec![fault],
        ..Scenario::default()
    })
    .unwrap()
}

fn topic(path: &Path, topic: &str) -> Dataset {
    let select = Selection {
        outputs: vec!["*".to_owned()],
        topic: Some(topic.to_owned()),
        // The messages are not evenly spaced.
        sample_time_s: Some(1.0),
        ..Selection::default()
    };
    read_dataset(path, &select).unwrap().dataset
}

#[test]
fn qualities_are_told_where_they_change_and_once_a_minute() {
    let folder = tempdir().unwrap();
    let path = folder.path().join("run.mcap");
    let run = run_with_dropout();
    write_run(&path, &run, &RunMetadata::default()).unwrap();
    let quality = topic(&path, "/plant/quality");
    let names: Vec<&Signal> = run
        .measured
        .inputs()
        .iter()
        .chain(run.measured.outputs())
        .collect();
    assert_eq!(quality.ny(), names.len());
    // The start, the death, the return, and the minute.
    let lost: Vec<usize> = (0..run.measured.len())
        .filter(|k| run.measured.y().column(*k).iter().any(|own| own.is_nan()))
        .collect();
    let (first, last) = (lost[0], lost[lost.len() - 1]);
    assert_eq!((first, last, lost.len()), (20, 29, 10));
    assert_eq!(quality.len(), 4);
    let summary = info(&path).unwrap();
    let own = summary
        .topics
        .iter()
        .find(|own| own.topic == "/plant/quality")
        .unwrap();
    assert_eq!((own.messages, own.first_s), (4, Some(0.0)));
    // Of all that is told only t3 is ever bad, and only while it is.
    for k in 0..quality.len() {
        for (row, signal) in quality.outputs().iter().enumerate() {
            let bad = signal.name == "t3" && k == 1;
            let expected = if bad { Quality::Bad } else { Quality::Good };
            let found = quality.y()[(row, k)];
            assert_eq!(
                found.to_bits(),
                f64::from(expected.number()).to_bits(),
                "{k} {}",
                signal.name
            );
        }
    }
    let sound = verify(&path).unwrap();
    assert!(sound.problems.is_empty(), "{:?}", sound.problems);
}

#[test]
fn every_quality_comes_back_and_wrong_counts_are_named() {
    let folder = tempdir().unwrap();
    let path = folder.path().join("q.mcap");
    let mut log = LogWriter::create(&path, &RunMetadata::default()).unwrap();
    let signals = Signal::named(&["TI-101.PV", "b", "c", "d", "e"]);
    let id = log
        .add_quality_topic("/plant/quality", &signals, 1.0, "GT1")
        .unwrap();
    let all = [
        Quality::Good,
        Quality::Uncertain,
        Quality::Bad,
        Quality::Stale,
        Quality::Interpolated,
    ];
    for k in 0..2 {
        log.write_quality(id, sample_time_ns(k, 1.0), &all).unwrap();
    }
    let error = log.write_quality(id, 0, &all[..2]).unwrap_err();
    assert_eq!(
        error.to_string(),
        "topic `/plant/quality`: expected 5 values, found 2"
    );
    let error = log
        .add_quality_topic("/plant/quality", &signals, 1.0, "GT1")
        .unwrap_err();
    assert!(error.to_string().contains("/plant/quality"), "{error}");
    log.finish().unwrap();
    let found = topic(&path, "/plant/quality");
    assert_eq!(found.outputs()[0].name, "TI-101.PV");
    for k in 0..2 {
        let column: Vec<f64> = found.y().column(k).iter().copied().collect();
        assert_eq!(column, [0.0, 1.0, 2.0, 3.0, 4.0]);
    }
}

#[test]
fn remarks_are_messages_of_foxglove_log() {
    let folder = tempdir().unwrap();
    let path = folder.path().join("run.mcap");
    let run = simulate(&Scenario {
        duration_s: 0.8,
        ..Scenario::default()
    })
    .unwrap();
    let metadata = RunMetadata {
        warnings: vec!["the record is short".to_owned(), "a second one".to_owned()],
        ..RunMetadata::default()
    };
    write_run(&path, &run, &metadata).unwrap();
    let messages = read_json_messages(&path, "/log").unwrap();
    let texts: Vec<&str> = messages
        .iter()
        .map(|own| own.value["message"].as_str().unwrap())
        .collect();
    assert_eq!(texts, ["the record is short", "a second one"]);
    for own in &messages {
        assert_eq!(own.time_ns, EPOCH_NS);
        assert_eq!(own.value["level"], 3);
        assert_eq!(own.value["name"], "gas-turbine");
        assert_eq!(own.value["timestamp"]["sec"], EPOCH_NS / 1_000_000_000);
    }
    let summary = info(&path).unwrap();
    let own = summary
        .topics
        .iter()
        .find(|own| own.topic == "/log")
        .unwrap();
    assert_eq!(own.schema, "foxglove.Log");
    // Without a remark there is no topic.
    write_run(&path, &run, &RunMetadata::default()).unwrap();
    assert!(
        info(&path)
            .unwrap()
            .topics
            .iter()
            .all(|own| own.topic != "/log")
    );
}

#[test]
fn models_are_attached_and_told() {
    let folder = tempdir().unwrap();
    let path = folder.path().join("run.mcap");
    let run = simulate(&Scenario {
        duration_s: 60.0,
        ..Scenario::default()
    })
    .unwrap();
    let record = run
        .measured
        .select(&["a_v", "M_f"], &["q_c", "t3"])
        .unwrap();
    let structure = OrderKind::Diagonal { nk: vec![1, 0] }
        .structure(3, 2)
        .unwrap();
    let model = Arx::new(structure).fit(&record).unwrap();
    let fits = validate(&model, &record).unwrap().outputs;
    let logged = LoggedModel {
        file: ModelFile::arx(model, None).unwrap(),
        fit_prediction_percent: fits.iter().map(|own| own.fit_prediction_percent).collect(),
        fit_simulation_percent: fits.iter().map(|own| own.fit_simulation_percent).collect(),
    };
    let metadata = RunMetadata {
        models: vec![logged.clone()],
        ..RunMetadata::default()
    };
    write_run(&path, &run, &metadata).unwrap();
    let messages = read_json_messages(&path, "/ident/model").unwrap();
    assert_eq!(messages.len(), 1);
    let told = &messages[0].value;
    assert_eq!(told["id"], logged.file.id.as_str());
    assert_eq!(told["kind"], "arx");
    assert_eq!(told["inputs"], serde_json::json!(["a_v", "M_f"]));
    assert_eq!(told["outputs"], serde_json::json!(["q_c", "t3"]));
    assert_eq!(told["orders"], serde_json::json!([3, 3]));
    assert_eq!(
        told["fit_prediction_percent"],
        serde_json::json!(logged.fit_prediction_percent)
    );
    let name = format!("models/{}.json", logged.file.id);
    assert_eq!(told["attachment"], name.as_str());
    let bytes = read_attachment(&path, &name).unwrap();
    assert_eq!(told["sha256"], sha256_hex(&bytes).as_str());
    let back: ModelFile = serde_json::from_slice(&bytes).unwrap();
    assert_eq!(back, logged.file);
}

/// A log whose record of the run has these values, and two samples.
fn log_with(path: &Path, values: &[(&str, &str)]) {
    let file = BufWriter::new(File::create(path).unwrap());
    let mut writer = mcap::Writer::new(file).unwrap();
    let metadata: BTreeMap<String, String> = values
        .iter()
        .map(|(key, value)| ((*key).to_owned(), (*value).to_owned()))
        .collect();
    let name = "gtfdi.run".to_owned();
    writer.write_metadata(&Metadata { name, metadata }).unwrap();
    let channel = writer
        .add_channel(0, "/plant/measured", "json", &BTreeMap::new())
        .unwrap();
    for k in 0..2_u32 {
        let time_ns = sample_time_ns(usize::try_from(k).unwrap(), 0.5);
        let header = mcap::records::MessageHeader {
            channel_id: channel,
            sequence: k,
            log_time: time_ns,
            publish_time: time_ns,
        };
        writer
            .write_to_known_channel(&header, b"{\"y\": 1.5}")
            .unwrap();
    }
    writer.finish().unwrap();
}

#[test]
fn a_log_of_a_later_version_is_refused_and_an_older_one_is_read() {
    let folder = tempdir().unwrap();
    let path = folder.path().join("run.mcap");
    let select = Selection {
        outputs: vec!["y".to_owned()],
        ..Selection::default()
    };
    for old in [
        &[][..],
        &[("version", "0.0.9")],
        &[("log_version", "1")],
        &[("log_version", "0")],
    ] {
        log_with(&path, old);
        assert_eq!(
            read_dataset(&path, &select).unwrap().dataset.len(),
            2,
            "{old:?}"
        );
    }
    for new in ["2", "1.5", "x", "", "99999999999999999999"] {
        log_with(&path, &[("log_version", new)]);
        let expected = format!(
            "{}: expected a log of version 1 or before, found version {new}: read it with the gtfdi \
             that wrote it, or a later one",
            path.display()
        );
        let error = read_dataset(&path, &select).unwrap_err();
        assert_eq!(error.to_string(), expected);
        let error = gt_log::columns(&path, None).unwrap_err();
        assert_eq!(error.to_string(), expected);
        let error = read_json_messages(&path, "/plant/measured").unwrap_err();
        assert_eq!(error.to_string(), expected);
        let out = folder.path().join("run.csv");
        let error = gt_log::export(&path, &out, &gt_log::ExportOptions::default()).unwrap_err();
        assert_eq!(error.to_string(), expected);
        assert!(!out.exists());
        // What is in it can still be looked at.
        assert_eq!(info(&path).unwrap().topics.len(), 1);
    }
}
