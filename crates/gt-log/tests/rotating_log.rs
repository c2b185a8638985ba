//! Logs in files that follow each other.

#![allow(clippy::unwrap_used, clippy::panic, reason = "helpers of tests")]

use std::fs;
use std::path::Path;

use gt_core::Signal;
use gt_log::{
    EPOCH_NS, JsonTopicHead, LogError, LogHead, LogWriter, Quality, RotatingLog, RotationOptions,
    RunMetadata, Selection, TopicHead, info, read_attachment, read_dataset, recover, recover_parts,
    verify,
};
use serde_json::json;
use tempfile::tempdir;

const SECOND: u64 = 1_000_000_000;

fn head() -> LogHead {
    LogHead {
        run: RunMetadata::default(),
        attachments: vec![(
            "models/a.json".to_owned(),
            "application/json".to_owned(),
            b"{}".to_vec(),
        )],
        topics: vec![TopicHead {
            topic: "/plant/measured".to_owned(),
            message: "Measured".to_owned(),
            fields: Signal::named(&["a", "b"]),
            sample_period_s: 1.0,
            asset: "x".to_owned(),
        }],
        quality_topics: vec![TopicHead {
            topic: "/plant/quality".to_owned(),
            message: "Quality".to_owned(),
            fields: Signal::named(&["a", "b"]),
            sample_period_s: 1.0,
            asset: "x".to_owned(),
        }],
        json_topics: vec![JsonTopicHead {
            topic: "/alarms".to_owned(),
            message: "Alarm".to_owned(),
            schema: json!({"type": "object"}),
            asset: "x".to_owned(),
        }],
    }
}

fn options(folder: &Path) -> RotationOptions {
    RotationOptions {
        span_s: 10,
        ..RotationOptions::new(folder)
    }
}

fn at(k: u64) -> u64 {
    EPOCH_NS + k * SECOND
}

/// A value without a pattern.
fn value(k: u64) -> f64 {
    f64::from_bits((1023 << 52) | ((k + 1).wrapping_mul(0x9e37_79b9_7f4a_7c15) >> 12))
}

fn write(log: &mut RotatingLog, k: u64) {
    log.write(0, at(k), &[Some(value(k)), None]).unwrap();
}

/// The names in a folder, sorted.
fn names(folder: &Path) -> Vec<String> {
    let entries = fs::read_dir(folder).unwrap();
    let mut names: Vec<String> = entries
        .map(|entry| entry.unwrap().file_name().into_string().unwrap())
        .collect();
    names.sort();
    names
}

fn values(path: &Path) -> Vec<u64> {
    let selection = Selection {
        outputs: vec!["a".to_owned()],
        sample_time_s: Some(1.0),
        ..Selection::default()
    };
    let data = read_dataset(path, &selection).unwrap().dataset;
    data.y().iter().map(|own| own.to_bits()).collect()
}

fn expected(samples: std::ops::Range<u64>) -> Vec<u64> {
    samples.map(|k| value(k).to_bits()).collect()
}

#[test]
fn each_span_is_a_file_that_is_whole_by_itself() {
    let folder = tempdir().unwrap();
    let mut log = RotatingLog::create(options(folder.path()), head()).unwrap();
    // EPOCH_NS is a multiple of the span.
    for k in 3..27 {
        write(&mut log, k);
        if k == 15 {
            log.write_json(0, at(k), &json!({"severity": 500})).unwrap();
            let qualities = [Quality::Good, Quality::Stale];
            log.write_quality(0, at(k), &qualities).unwrap();
        }
        log.tick(at(k)).unwrap();
    }
    assert_eq!(
        names(folder.path()),
        [
            "log-20060118T000003.000000000Z.mcap",
            "log-20060118T000010.000000000Z.mcap",
            "log-20060118T000020.000000000Z.mcap.part",
        ]
    );
    log.finish().unwrap();
    let files = names(folder.path());
    let spans = [3..10, 10..20, 20..27];
    for (name, span) in files.iter().zip(spans) {
        let path = folder.path().join(name);
        assert_eq!(values(&path), expected(span), "{name}");
        assert!(verify(&path).unwrap().sound, "{name}");
        assert_eq!(read_attachment(&path, "models/a.json").unwrap(), b"{}");
        let info = info(&path).unwrap();
        let topics: Vec<_> = info.topics.iter().map(|own| own.topic.as_str()).collect();
        assert_eq!(topics, ["/alarms", "/plant/measured", "/plant/quality"]);
        let of_quality = u64::from(name.contains("T000010"));
        assert_eq!(info.topics[2].messages, of_quality, "{name}");
        assert_eq!(info.metadata[0].name, "gtfdi.run");
    }
}

#[test]
fn a_tick_ends_a_file_when_no_message_comes() {
    let folder = tempdir().unwrap();
    let mut log = RotatingLog::create(options(folder.path()), head()).unwrap();
    log.tick(at(0)).unwrap();
    assert!(names(folder.path()).is_empty());
    write(&mut log, 1);
    log.tick(at(9)).unwrap();
    assert_eq!(
        names(folder.path()),
        ["log-20060118T000001.000000000Z.mcap.part"]
    );
    log.tick(at(10)).unwrap();
    assert_eq!(
        names(folder.path()),
        ["log-20060118T000001.000000000Z.mcap"]
    );
    // A late message begins a file of its own; the name that is taken stays.
    write(&mut log, 1);
    log.finish().unwrap();
    assert_eq!(
        names(folder.path()),
        [
            "log-20060118T000001.000000000Z-2.mcap",
            "log-20060118T000001.000000000Z.mcap",
        ]
    );
}

#[test]
fn many_bytes_end_a_file_too() {
    let folder = tempdir().unwrap();
    let options = RotationOptions {
        span_s: 1_000_000,
        max_bytes: 1 << 16,
        ..RotationOptions::new(folder.path())
    };
    let mut log = RotatingLog::create(options, head()).unwrap();
    for k in 0..20_000 {
        write(&mut log, k);
    }
    log.finish().unwrap();
    let files = names(folder.path());
    assert!(files.len() > 3, "{files:?}");
    let mut all = Vec::new();
    for name in &files {
        let path = folder.path().join(name);
        // The size is looked at every 256 messages, and an index comes at the end.
        let size = fs::metadata(&path).unwrap().len();
        assert!(size < 4 << 16, "{size} bytes");
        all.extend(values(&path));
    }
    assert_eq!(all, expected(0..20_000));
}

#[test]
fn old_files_are_removed_and_others_are_not_touched() {
    let folder = tempdir().unwrap();
    let others = [
        "log-20000101T000000.000000000Z.mcap.part",
        "other-20000101T000000.000000000Z.mcap",
        "log-notes.mcap",
        "log-20000101T000000Z.mcap",
    ];
    for name in others {
        fs::write(folder.path().join(name), b"not ours").unwrap();
    }
    fs::create_dir(folder.path().join("log-20000101T000000.000000000Z.mcap")).unwrap();
    let options = RotationOptions {
        keep_s: Some(25),
        ..options(folder.path())
    };
    let mut log = RotatingLog::create(options, head()).unwrap();
    for k in 0..60 {
        write(&mut log, k);
        log.tick(at(k)).unwrap();
    }
    log.finish().unwrap();
    let found = names(folder.path());
    for name in others {
        assert!(found.contains(&name.to_owned()), "{name}: {found:?}");
        assert_eq!(fs::read(folder.path().join(name)).unwrap(), b"not ours");
    }
    let own: Vec<&str> = found
        .iter()
        .map(String::as_str)
        .filter(|name| name.starts_with("log-2006"))
        .collect();
    // At 59 s, files that began 25 s ago or less are kept: those of 40 s and 50 s.
    assert_eq!(
        own,
        [
            "log-20060118T000040.000000000Z.mcap",
            "log-20060118T000050.000000000Z.mcap",
        ]
    );
}

#[test]
fn whole_files_have_no_more_bytes_than_they_may() {
    let folder = tempdir().unwrap();
    let options = RotationOptions {
        max_bytes: 1 << 16,
        keep_bytes: Some(1 << 16),
        ..options(folder.path())
    };
    let mut log = RotatingLog::create(options, head()).unwrap();
    for k in 0..2000 {
        write(&mut log, k);
        if k % 5 == 0 {
            log.tick(at(k)).unwrap();
        }
    }
    let whole = names(folder.path());
    let whole = whole.iter().filter(|name| !name.contains(".part"));
    let sizes: Vec<u64> = whole
        .map(|name| fs::metadata(folder.path().join(name)).unwrap().len())
        .collect();
    let sum: u64 = sizes.iter().sum();
    assert!(sum <= 1 << 16 && sizes.len() > 5, "{sizes:?}");
    // The newest are those that are there.
    log.finish().unwrap();
    let last = names(folder.path()).pop().unwrap();
    assert_eq!(values(&folder.path().join(last)), expected(1990..2000));
}

#[test]
fn what_was_flushed_before_a_crash_is_recovered() {
    let folder = tempdir().unwrap();
    let mut log = RotatingLog::create(options(folder.path()), head()).unwrap();
    for k in 0..15 {
        write(&mut log, k);
        if k == 12 {
            log.tick(at(k)).unwrap();
        }
    }
    let part = folder
        .path()
        .join("log-20060118T000010.000000000Z.mcap.part");
    let crashed = fs::read(&part).unwrap();
    drop(log);
    assert!(part.exists(), "an open file is left as it is");
    fs::write(&part, crashed).unwrap();
    let out = folder.path().join("log-20060118T000010.000000000Z.mcap");
    let recovery = recover(&part, &out).unwrap();
    assert!(!recovery.sound);
    assert_eq!(values(&out), expected(10..13));
    assert_eq!(read_attachment(&out, "models/a.json").unwrap(), b"{}");
    // A log that begins in the same second leaves both alone.
    let before = (fs::read(&part).unwrap(), fs::read(&out).unwrap());
    let mut log = RotatingLog::create(options(folder.path()), head()).unwrap();
    write(&mut log, 10);
    log.finish().unwrap();
    assert_eq!((fs::read(&part).unwrap(), fs::read(&out).unwrap()), before);
    assert!(
        folder
            .path()
            .join("log-20060118T000010.000000000Z-2.mcap")
            .exists()
    );
}

/// What a process left behind is made whole; what one still writes is not touched.
#[test]
fn parts_that_were_left_behind_are_recovered() {
    let folder = tempdir().unwrap();
    let path = |name: &str| folder.path().join(name);
    let mut dead = RotatingLog::create(options(folder.path()), head()).unwrap();
    for k in 10..15 {
        write(&mut dead, k);
    }
    dead.tick(at(14)).unwrap();
    drop(dead);
    let mut alive = RotatingLog::create(options(folder.path()), head()).unwrap();
    write(&mut alive, 20);
    alive.tick(at(20)).unwrap();
    // Of another log, and of nobody.
    for other in [
        "other-20060118T000010.000000000Z.mcap.part",
        "log-notes.mcap.part",
    ] {
        fs::write(path(other), "mine").unwrap();
    }
    // Power was lost before the first byte was on the disk.
    let empty = "log-20060118T000100.000000000Z.mcap.part";
    fs::write(path(empty), "").unwrap();
    let found = recover_parts(folder.path(), "log").unwrap();
    let parts: Vec<_> = found.iter().map(|own| own.part.clone()).collect();
    let dead = "log-20060118T000010.000000000Z.mcap";
    assert_eq!(parts, [path(&format!("{dead}.part")), path(empty)]);
    assert_eq!(found[0].outcome.as_ref().unwrap().messages, 5);
    assert!(matches!(
        found[1].outcome,
        Err(LogError::NothingToRecover { .. })
    ));
    assert_eq!(values(&path(dead)), expected(10..15));
    assert!(verify(&path(dead)).unwrap().sound);
    assert!(!path(&format!("{dead}.part")).exists());
    write(&mut alive, 21);
    alive.finish().unwrap();
    let alive = path("log-20060118T000020.000000000Z.mcap");
    assert_eq!(values(&alive), expected(20..22));
    assert_eq!(recover_parts(folder.path(), "log").unwrap().len(), 1);
}

/// A device that is always full stands for a full disk.
#[test]
#[cfg(target_os = "linux")]
fn a_full_disk_is_a_typed_error() {
    let folder = tempdir().unwrap();
    let path = folder.path().join("a.mcap");
    std::os::unix::fs::symlink("/dev/full", folder.path().join("a.mcap.part")).unwrap();
    // The first seek puts the first records on the device.
    let result = LogWriter::create(&path, &RunMetadata::default());
    let Err(error) = result else {
        panic!("a full device took bytes")
    };
    assert!(matches!(error, LogError::NoSpace { .. }), "{error}");
    assert_eq!(
        error.to_string(),
        format!(
            "{}: the disk is full: could not write; make room, files that are whole stay whole",
            path.display()
        )
    );
    assert!(!path.exists());
}

/// The folder goes away between two files: the error names the file, the whole ones are whole, and
/// when the folder is back the log goes on.
#[test]
fn a_write_that_fails_costs_no_whole_file() {
    let parent = tempdir().unwrap();
    let (folder, away) = (parent.path().join("logs"), parent.path().join("away"));
    fs::create_dir(&folder).unwrap();
    let mut log = RotatingLog::create(options(&folder), head()).unwrap();
    for k in 0..12 {
        write(&mut log, k);
    }
    log.tick(at(20)).unwrap();
    fs::rename(&folder, &away).unwrap();
    let error = log.write(0, at(21), &[Some(1.0), None]).unwrap_err();
    assert!(
        matches!(&error, LogError::Io { action: "create", path, .. }
            if path.ends_with("log-20060118T000021.000000000Z.mcap.part")),
        "{error}"
    );
    fs::rename(&away, &folder).unwrap();
    write(&mut log, 22);
    log.finish().unwrap();
    let files = names(&folder);
    assert_eq!(files.len(), 3, "{files:?}");
    for name in &files {
        assert!(verify(&folder.join(name)).unwrap().sound, "{name}");
    }
    assert_eq!(values(&folder.join(&files[0])), expected(0..10));
}

#[test]
fn options_that_cannot_be_are_named() {
    let folder = tempdir().unwrap();
    let good = options(folder.path());
    let refused = |options: RotationOptions| match RotatingLog::create(options, head()) {
        Err(error) => error.to_string(),
        Ok(_) => panic!("refused"),
    };
    let cases = [
        (
            RotationOptions {
                stem: "a/b".to_owned(),
                ..good.clone()
            },
            "rotation: stem: expected letters, digits, _ and -, found `a/b`",
        ),
        (
            RotationOptions {
                stem: String::new(),
                ..good.clone()
            },
            "rotation: stem: expected letters, digits, _ and -, found ``",
        ),
        (
            RotationOptions {
                span_s: 0,
                ..good.clone()
            },
            "rotation: span_s: expected 1 or more, found 0",
        ),
        (
            RotationOptions {
                max_bytes: 100,
                ..good.clone()
            },
            "rotation: max_bytes: expected 65536 or more, found 100",
        ),
        (
            RotationOptions {
                keep_s: Some(9),
                ..good.clone()
            },
            "rotation: keep_s: expected span_s (10) or more, found 9",
        ),
        (
            RotationOptions {
                keep_bytes: Some(1),
                ..good.clone()
            },
            "rotation: keep_bytes: expected max_bytes (1073741824) or more, found 1",
        ),
        (
            RotationOptions {
                folder: "no/such".into(),
                ..good.clone()
            },
            "rotation: folder: expected a folder that is there, found no/such",
        ),
    ];
    for (options, text) in cases {
        assert_eq!(refused(options), text);
    }
    let mut log = RotatingLog::create(good, head()).unwrap();
    assert!(matches!(
        log.write(3, at(0), &[]),
        Err(LogError::ForeignTopic {
            expected: 1,
            found: 3
        })
    ));
    assert!(matches!(
        log.write_quality(1, at(0), &[]),
        Err(LogError::ForeignTopic {
            expected: 1,
            found: 1
        })
    ));
    assert!(matches!(
        log.write(0, at(0), &[None]),
        Err(LogError::FieldCount {
            expected: 2,
            found: 1,
            ..
        })
    ));
    // Neither mistake costs the file.
    write(&mut log, 0);
    log.finish().unwrap();
}

/// A small disk in memory, where this process may mount one.
#[cfg(target_os = "linux")]
struct SmallDisk(tempfile::TempDir);

#[cfg(target_os = "linux")]
impl SmallDisk {
    fn new(bytes: u64) -> Option<Self> {
        let folder = tempdir().unwrap();
        let size = format!("size={bytes}");
        let mut mount = std::process::Command::new("mount");
        mount
            .args(["-t", "tmpfs", "-o", &size, "tmpfs"])
            .arg(folder.path());
        let done = mount.stderr(std::process::Stdio::null()).status();
        done.is_ok_and(|own| own.success()).then_some(Self(folder))
    }
}

#[cfg(target_os = "linux")]
impl Drop for SmallDisk {
    fn drop(&mut self) {
        let _ = std::process::Command::new("umount")
            .arg(self.0.path())
            .status();
    }
}

/// The disk is really full: whole files stay whole, what was flushed of the open one is recovered, and
/// with room again the log goes on.
#[test]
#[cfg(target_os = "linux")]
fn a_disk_that_runs_full_costs_no_whole_file() {
    let Some(disk) = SmallDisk::new(256 << 10) else {
        println!("skipped: a_disk_that_runs_full_costs_no_whole_file may not mount a small disk");
        return;
    };
    let folder = disk.0.path();
    let mut log = RotatingLog::create(options(folder), head()).unwrap();
    // Files of 10 s, some kilobytes each; flushed like a live log, so that the error comes at a tick
    // or a message.
    let (mut k, mut failed) = (0, None);
    while failed.is_none() && k < 100_000 {
        failed = log
            .write(0, at(k), &[Some(value(k)), None])
            .and_then(|()| log.tick(at(k)))
            .err();
        k += 1;
    }
    let error = failed.unwrap();
    assert!(matches!(error, LogError::NoSpace { .. }), "{k}: {error}");
    assert!(
        error
            .to_string()
            .ends_with("make room, files that are whole stay whole"),
        "{error}"
    );
    let files = names(folder);
    let whole: Vec<&String> = files
        .iter()
        .filter(|name| Path::new(name).extension().is_some_and(|own| own == "mcap"))
        .collect();
    assert!(whole.len() > 3, "{files:?}");
    for name in &whole {
        assert!(verify(&folder.join(name)).unwrap().sound, "{name}");
    }
    // Room again.
    fs::remove_file(folder.join(whole[0])).unwrap();
    fs::remove_file(folder.join(whole[1])).unwrap();
    let next = k + 100;
    write(&mut log, next);
    log.finish().unwrap();
    let last = names(folder);
    let last = last
        .iter()
        .filter(|name| Path::new(name).extension().is_some_and(|own| own == "mcap"))
        .max()
        .unwrap();
    assert_eq!(values(&folder.join(last)), expected(next..next + 1));
}
