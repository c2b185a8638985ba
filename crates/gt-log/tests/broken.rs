//! No bytes make a reader panic, and none that were changed pass for sound.

#![allow(clippy::unwrap_used, clippy::panic, reason = "helpers of tests")]

use std::fs;
use std::path::Path;
use std::sync::OnceLock;

use gt_core::Signal;
use gt_log::{LogError, LogWriter, RunMetadata, Selection, columns, info, read_attachment};
use gt_log::{read_dataset, read_json_messages, sample_time_ns};
use proptest::collection::vec;
use proptest::prelude::*;
use tempfile::tempdir;

fn everything() -> Selection {
    Selection {
        outputs: vec!["*".to_owned()],
        ..Selection::default()
    }
}

/// A log as this crate writes it.
fn own_log() -> &'static [u8] {
    static LOG: OnceLock<Vec<u8>> = OnceLock::new();
    LOG.get_or_init(|| {
        let folder = tempdir().unwrap();
        let path = folder.path().join("a.mcap");
        let mut log = LogWriter::create(&path, &RunMetadata::default()).unwrap();
        log.attach("models/a.json", "application/json", b"{}")
            .unwrap();
        let signals = Signal::named(&["a", "b-c"]);
        let topic = log
            .add_topic("/plant/measured", "M", &signals, 1.0, "x")
            .unwrap();
        for k in 0..40 {
            log.write(topic, sample_time_ns(k, 1.0), &[k as f64, 0.5])
                .unwrap();
        }
        log.finish().unwrap();
        fs::read(&path).unwrap()
    })
}

/// The same content with one kind of chunks.
fn foreign_log(compression: Option<mcap::Compression>, use_chunks: bool) -> Vec<u8> {
    let own = own_log();
    let mut bytes = std::io::Cursor::new(Vec::new());
    let options = mcap::WriteOptions::new()
        .compression(compression)
        .use_chunks(use_chunks);
    let mut writer = options.create(&mut bytes).unwrap();
    for message in mcap::MessageStream::new(own).unwrap() {
        writer.write(&message.unwrap()).unwrap();
    }
    writer.finish().unwrap();
    drop(writer);
    bytes.into_inner()
}

fn logs() -> &'static [Vec<u8>] {
    static LOGS: OnceLock<Vec<Vec<u8>>> = OnceLock::new();
    LOGS.get_or_init(|| {
        vec![
            own_log().to_vec(),
            foreign_log(None, true),
            foreign_log(None, false),
            foreign_log(Some(mcap::Compression::Lz4), true),
        ]
    })
}

/// Every reader on the same bytes.
fn try_all(bytes: &[u8], name: &str) -> Result<(), LogError> {
    let folder = tempdir().unwrap();
    let path = folder.path().join(name);
    fs::write(&path, bytes).unwrap();
    let results = [
        columns(&path, None).map(drop),
        info(&path).map(drop),
        read_json_messages(&path, "/plant/measured").map(drop),
        read_attachment(&path, "models/a.json").map(drop),
    ];
    for result in results {
        if let Err(error) = result {
            assert!(!error.to_string().is_empty());
        }
    }
    read_dataset(&path, &everything()).map(drop)
}

#[test]
fn every_kind_of_chunk_is_read() {
    for (index, log) in logs().iter().enumerate() {
        try_all(log, "a.mcap").unwrap_or_else(|error| panic!("log {index}: {error}"));
    }
}

#[test]
fn a_log_cut_anywhere_is_named() {
    let log = own_log();
    for length in 0..log.len() {
        let error = try_all(&log[..length], "a.mcap").unwrap_err();
        assert!(
            matches!(error, LogError::Truncated { size, .. } if size == length as u64),
            "{length} of {}: {error}",
            log.len()
        );
    }
}

/// A chunk that is longer than what is left of the file.
#[test]
fn a_log_cut_within_a_large_chunk_is_named() {
    let folder = tempdir().unwrap();
    let path = folder.path().join("a.mcap");
    let mut log = LogWriter::create(&path, &RunMetadata::default()).unwrap();
    let signals = Signal::named(&["a"]);
    let topic = log
        .add_topic("/plant/measured", "M", &signals, 1.0, "x")
        .unwrap();
    for k in 0..4000 {
        let value = f64::from_bits(
            (1023 << 52) + (k as u64).wrapping_mul(0x9e37_79b9_7f4a_7c15) % (1 << 52),
        );
        log.write(topic, sample_time_ns(k, 1.0), &[value]).unwrap();
    }
    log.finish().unwrap();
    let log = fs::read(&path).unwrap();
    assert!(
        log.len() > 10_000,
        "{} bytes hold no large chunk",
        log.len()
    );
    for length in [log.len() / 2, log.len() / 10, log.len() - 5000] {
        let error = try_all(&log[..length], "a.mcap").unwrap_err();
        assert!(
            matches!(error, LogError::Truncated { size, .. } if size == length as u64),
            "{length} of {}: {error}",
            log.len()
        );
    }
}

#[test]
fn a_changed_byte_is_found_by_a_checksum_or_changes_nothing() {
    let folder = tempdir().unwrap();
    let path = folder.path().join("a.mcap");
    let log = own_log();
    fs::write(&path, log).unwrap();
    let sound = read_dataset(&path, &everything()).unwrap().dataset;
    let mut unseen = 0;
    for index in 0..log.len() {
        let mut changed = log.to_vec();
        changed[index] ^= 0x10;
        fs::write(&path, changed).unwrap();
        match read_dataset(&path, &everything()) {
            Err(_) => {}
            Ok(imported) => {
                assert_eq!(imported.dataset, sound, "byte {index}");
                unseen += 1;
            }
        }
    }
    // A CRC of the data section and one of the summary cover all but themselves.
    assert!(unseen <= 8, "{unseen} changes unseen");
}

#[test]
fn other_files_are_no_logs() {
    let error = try_all(b"u,y\n1,2\n3,4\n", "a.mcap").unwrap_err();
    assert!(matches!(error, LogError::Magic { found, .. } if found == b"u,y\n1,2\n"));
    let error = try_all(b"u,y", "a.mcap").unwrap_err();
    assert!(matches!(error, LogError::Magic { found, .. } if found == b"u,y"));
}

/// Magic, header, then one record.
fn with_record(opcode: u8, body: &[u8]) -> Vec<u8> {
    let mut bytes = mcap::MAGIC.to_vec();
    for (opcode, body) in [(1, &[0; 8][..]), (opcode, body)] {
        bytes.push(opcode);
        bytes.extend_from_slice(&(body.len() as u64).to_le_bytes());
        bytes.extend_from_slice(body);
    }
    bytes
}

#[test]
fn records_that_make_the_library_panic_are_errors() {
    use mcap::records::op;
    // An attachment without room for its checksum.
    let attachment = with_record(op::ATTACHMENT, &[0; 32]);
    // A record that reaches past its uncompressed chunk, into the padding behind it.
    let mut chunk = [0; 28].to_vec();
    chunk.extend_from_slice(&0_u32.to_le_bytes());
    chunk.extend_from_slice(&9_u64.to_le_bytes());
    chunk.push(op::MESSAGE);
    chunk.extend_from_slice(&100_u64.to_le_bytes());
    chunk.extend_from_slice(&[0; 300]);
    let chunk = with_record(op::CHUNK, &chunk);
    // A string of 4 GiB, a map of 4 GiB, a pair in it that ends too late.
    let string = with_record(op::METADATA, &[0xff, 0xff, 0xff, 0xff]);
    let map = with_record(op::METADATA, &[0, 0, 0, 0, 0xff, 0xff, 0xff, 0xff]);
    let pair = with_record(
        op::METADATA,
        &[0, 0, 0, 0, 4, 0, 0, 0, 0xff, 0xff, 0xff, 0x7f],
    );
    for bytes in [attachment, chunk, string, map, pair] {
        let error = try_all(&bytes, "a.mcap").unwrap_err();
        assert!(matches!(error, LogError::Corrupt { .. }), "{error}");
    }
}

/// Recomputes nothing: the reader must survive the records before a checksum can tell.
fn change(
    bytes: &[u8],
    changes: &[(prop::sample::Index, u8)],
    cut: Option<prop::sample::Index>,
) -> Vec<u8> {
    let mut changed = bytes.to_vec();
    for (index, byte) in changes {
        let index = index.index(changed.len());
        changed[index] = *byte;
    }
    if let Some(cut) = cut {
        changed.truncate(cut.index(bytes.len()));
    }
    changed
}

proptest! {
    #![proptest_config(ProptestConfig {
        cases: 400,
        failure_persistence: None,
        ..ProptestConfig::default()
    })]

    #[test]
    fn prop_changed_logs_do_not_panic(
        which in 0_usize..4,
        changes in vec((any::<prop::sample::Index>(), any::<u8>()), 0..6),
        cut in proptest::option::of(any::<prop::sample::Index>()),
    ) {
        let _ = try_all(&change(&logs()[which], &changes, cut), "a.mcap");
    }

    #[test]
    fn prop_random_bytes_are_no_log(bytes in vec(any::<u8>(), 0..300), magic in any::<bool>()) {
        let mut log = if magic { mcap::MAGIC.to_vec() } else { Vec::new() };
        log.extend_from_slice(&bytes);
        prop_assert!(try_all(&log, "a.mcap").is_err());
    }

    #[test]
    fn prop_random_records_do_not_panic(opcode in 0_u8..20, body in vec(any::<u8>(), 0..80)) {
        prop_assert!(try_all(&with_record(opcode, &body), "a.mcap").is_err());
    }

    #[test]
    fn prop_random_bytes_in_csv_do_not_panic(bytes in vec(any::<u8>(), 0..200)) {
        let _ = try_all(&bytes, "a.csv");
    }

    #[test]
    fn prop_random_text_in_csv_does_not_panic(text in "[ty,;\"\\r\\n0-9.eE+-]{0,120}") {
        let _ = try_all(text.as_bytes(), "a.csv");
    }

    #[test]
    fn prop_changed_csv_does_not_panic(
        changes in vec((any::<prop::sample::Index>(), any::<u8>()), 0..4),
        cut in proptest::option::of(any::<prop::sample::Index>()),
    ) {
        let csv = b"time,u,y\r\n0,1,2\r\n1,\"3\",4\r\n2,5,6e-001\r\n";
        let _ = try_all(&change(csv, &changes, cut), "a.csv");
    }
}

#[test]
fn a_path_is_never_a_reason_to_panic() {
    for name in ["", "/", ".", "a\0b.csv", "x.mcap"] {
        assert!(read_dataset(Path::new(name), &everything()).is_err());
        assert!(info(Path::new(name)).is_err());
    }
}
