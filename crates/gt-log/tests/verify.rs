//! Logs compared with the format: sound ones pass, and whatever is changed is named.

#![allow(clippy::unwrap_used, clippy::panic, reason = "helpers of tests")]

use std::fs;

use gt_core::Signal;
use gt_log::{
    LogWriter, ProblemKind, RunMetadata, Severity, Verification, recover, sample_time_ns, verify,
};
use mcap::records::{MessageHeader, op};
use proptest::prelude::*;
use tempfile::tempdir;

/// A log of two topics in five chunks.
fn own_log() -> Vec<u8> {
    let folder = tempdir().unwrap();
    let path = folder.path().join("a.mcap");
    let mut log = LogWriter::create(&path, &RunMetadata::default()).unwrap();
    log.attach("models/a.json", "application/json", b"{}")
        .unwrap();
    let signals = Signal::named(&["a", "b-c"]);
    let topic = log.add_topic("/x", "M", &signals, 1.0, "x").unwrap();
    let schema = serde_json::json!({"type": "object"});
    let text = log
        .add_json_topic("/alarms", "Alarm", &schema, "x")
        .unwrap();
    for k in 0..40 {
        let time = sample_time_ns(k, 1.0);
        log.write(topic, time, &[k as f64, 0.5]).unwrap();
        if k % 8 == 7 {
            log.write_json(text, time, &serde_json::json!({"k": k}))
                .unwrap();
            log.flush().unwrap();
        }
    }
    log.finish().unwrap();
    fs::read(&path).unwrap()
}

fn judge(bytes: &[u8]) -> Verification {
    let folder = tempdir().unwrap();
    let path = folder.path().join("a.mcap");
    fs::write(&path, bytes).unwrap();
    verify(&path).unwrap()
}

/// The texts of the problems of a kind.
fn texts(found: &Verification, kind: ProblemKind) -> Vec<String> {
    let own = found.problems.iter().filter(|own| own.kind == kind);
    own.map(|own| own.text.clone()).collect()
}

/// A log of this many messages by mcap's writer, which writes what it is told.
fn foreign(
    options: mcap::WriteOptions,
    write: impl FnOnce(&mut mcap::Writer<&mut std::io::Cursor<Vec<u8>>>),
) -> Vec<u8> {
    let mut bytes = std::io::Cursor::new(Vec::new());
    let mut writer = options.create(&mut bytes).unwrap();
    write(&mut writer);
    writer.finish().unwrap();
    drop(writer);
    bytes.into_inner()
}

fn send(
    writer: &mut mcap::Writer<&mut std::io::Cursor<Vec<u8>>>,
    channel: u16,
    (sequence, time): (u32, u64),
    data: &[u8],
) {
    let header = MessageHeader {
        channel_id: channel,
        sequence,
        log_time: time,
        publish_time: time,
    };
    writer.write_to_known_channel(&header, data).unwrap();
}

#[test]
fn own_logs_are_sound() {
    let found = judge(&own_log());
    assert_eq!(found.problems, []);
    assert!(found.sound && found.summary);
    assert_eq!((found.messages, found.decoded_messages), (45, 45));
    assert_eq!((found.chunks, found.attachments, found.metadata), (5, 1, 2));
    assert!(found.foreign_encodings.is_empty());
}

/// One bit, anywhere: the checksums cover every byte, or another check does.
#[test]
fn every_changed_bit_is_damage() {
    let whole = own_log();
    for place in 0..whole.len() {
        let mut bytes = whole.clone();
        bytes[place] ^= 1 << (place % 8);
        let found = judge(&bytes);
        assert!(!found.sound, "byte {place} of {}: {found:?}", whole.len());
        assert!(!found.problems.is_empty());
    }
}

#[test]
fn every_cut_is_damage() {
    let whole = own_log();
    for length in 0..whole.len() {
        assert!(
            !judge(&whole[..length]).sound,
            "{length} of {}",
            whole.len()
        );
    }
    let mut longer = whole.clone();
    longer.push(0);
    let found = judge(&longer);
    assert_eq!(
        texts(&found, ProblemKind::Magic),
        ["expected the end of the file, found 1 bytes"]
    );
    assert_eq!(found.problems[0].offset, whole.len() as u64);
}

#[test]
fn a_changed_chunk_is_named_with_its_offset() {
    let whole = own_log();
    let chunk = position(&whole, op::CHUNK, 2);
    let mut bytes = whole.clone();
    bytes[chunk + 9 + 48 + 12] ^= 4;
    let found = judge(&bytes);
    let problem = &found.problems[0];
    assert_eq!(
        (problem.kind, problem.severity),
        (ProblemKind::Chunk, Severity::Damage)
    );
    assert_eq!(problem.offset, chunk as u64);
    assert!(
        problem.text.starts_with("expected the CRC "),
        "{}",
        problem.text
    );
    // The data have a checksum too.
    let text = &texts(&found, ProblemKind::Checksum)[0];
    assert!(text.starts_with("the data: expected the CRC "), "{text}");
}

/// Where the n-th record of a kind stands.
fn position(bytes: &[u8], kind: u8, n: usize) -> usize {
    let (mut at, mut seen) = (8, 0);
    loop {
        let length = u64::from_le_bytes(bytes[at + 1..at + 9].try_into().unwrap());
        if bytes[at] == kind {
            if seen == n {
                return at;
            }
            seen += 1;
        }
        at += 9 + usize::try_from(length).unwrap();
    }
}

/// Sets bytes and takes the two checksums away, so that nothing but the change is wrong.
fn changed(whole: &[u8], place: usize, with: &[u8]) -> Vec<u8> {
    let mut bytes = whole.to_vec();
    bytes[place..place + with.len()].copy_from_slice(with);
    let end = position(whole, op::DATA_END, 0) + 9;
    bytes[end..end + 4].fill(0);
    let footer = position(whole, op::FOOTER, 0) + 9 + 16;
    bytes[footer..footer + 4].fill(0);
    bytes
}

#[test]
fn indexes_and_statistics_that_do_not_agree_are_named() {
    let whole = own_log();
    let sound = judge(&changed(&whole, 0, b""));
    assert_eq!(sound.problems, [], "without checksums");
    let one = |place: usize, with: &[u8], kind: ProblemKind| {
        let found = judge(&changed(&whole, place, with));
        assert!(!found.sound);
        let [text] = texts(&found, kind).try_into().unwrap();
        text
    };
    let statistics = position(&whole, op::STATISTICS, 0) + 9;
    assert_eq!(
        one(statistics, &46_u64.to_le_bytes(), ProblemKind::Statistics),
        "statistics: expected 46 messages, found 45"
    );
    let message_index = position(&whole, op::MESSAGE_INDEX, 0);
    let text = one(message_index + 9 + 6 + 8, &[7], ProblemKind::Index);
    assert!(
        text.starts_with("index of channel 1: no message of 1137542400000000000 ns at "),
        "{text}"
    );
    let chunk_index = position(&whole, op::CHUNK_INDEX, 1) + 9;
    let text = one(chunk_index + 24, &[1], ProblemKind::Index);
    assert!(text.contains("expected the length "), "{text}");
    let found = judge(&changed(&whole, chunk_index + 16, &[1]));
    let text = &texts(&found, ProblemKind::Index);
    assert!(
        text.iter()
            .any(|own| own.starts_with("index of a chunk: no chunk at ")),
        "{text:?}"
    );
    let attachment_index = position(&whole, op::ATTACHMENT_INDEX, 0) + 9;
    let text = one(attachment_index + 16, &[1], ProblemKind::Index);
    assert_eq!(
        text,
        format!(
            "index of the attachment `models/a.json`: no such attachment of 2 bytes at {}",
            position(&whole, op::ATTACHMENT, 0)
        )
    );
    let metadata_index = position(&whole, op::METADATA_INDEX, 0) + 9;
    let text = one(metadata_index + 8, &[1], ProblemKind::Index);
    assert!(
        text.starts_with("index of the metadata `gtfdi.run`: no such record of "),
        "{text}"
    );
    let offset = position(&whole, op::SUMMARY_OFFSET, 0) + 9;
    let text = one(offset + 9, &[1], ProblemKind::Index);
    assert!(
        text.starts_with("no 1 bytes of records of the kind 0x03 at ")
            || text.contains("of records of the kind 0x03"),
        "{text}"
    );
    let footer = position(&whole, op::FOOTER, 0) + 9;
    let text = one(footer, &[1, 0, 0, 0, 0, 0, 0, 0], ProblemKind::Index);
    assert!(text.ends_with(", found 1"), "{text}");
}

#[test]
fn a_message_that_is_not_of_its_schema_is_named() {
    let bytes = foreign(mcap::WriteOptions::new(), |writer| {
        let map = std::collections::BTreeMap::new();
        let json = writer.add_channel(0, "/json", "json", &map).unwrap();
        send(writer, json, (1, 10), b"{\"a\": 1}");
        send(writer, json, (2, 20), b"{\"a\": ");
        let other = writer.add_channel(0, "/cdr", "cdr", &map).unwrap();
        send(writer, other, (1, 10), b"\x00");
    });
    let found = judge(&bytes);
    assert_eq!((found.messages, found.decoded_messages), (3, 1));
    assert_eq!(found.foreign_encodings, ["cdr"]);
    assert_eq!(
        texts(&found, ProblemKind::Message),
        [
            "topic `/json`, message 2 at 20 ns: expected a message of its schema, found: EOF while \
             parsing a value at line 1 column 6"
        ]
    );
    assert!(!found.sound);
}

/// The format allows both, and a sequence that is zero throughout says nothing.
#[test]
fn the_order_of_messages_is_remarked_on() {
    let bytes = foreign(mcap::WriteOptions::new(), |writer| {
        let map = std::collections::BTreeMap::new();
        let a = writer.add_channel(0, "/a", "json", &map).unwrap();
        let b = writer.add_channel(0, "/b", "json", &map).unwrap();
        for (sequence, time) in [(5, 30), (6, 10), (6, 40), (2, 20)] {
            send(writer, a, (sequence, time), b"1");
            send(writer, b, (0, 30), b"1");
        }
    });
    let found = judge(&bytes);
    assert!(found.sound, "{:?}", found.problems);
    assert!(
        found
            .problems
            .iter()
            .all(|own| own.severity == Severity::Remark)
    );
    assert_eq!(
        texts(&found, ProblemKind::Order),
        [
            "topic `/a` (channel 1): 2 messages have a sequence that does not rise; the first is \
             here",
            "topic `/a` (channel 1): 2 messages have a log time before that of the message before \
             them; the first is here",
        ]
    );
}

#[test]
fn every_kind_of_log_by_the_foreign_writer_is_sound() {
    for compression in [
        None,
        Some(mcap::Compression::Lz4),
        Some(mcap::Compression::Zstd),
    ] {
        for (chunks, summary) in [(true, true), (false, true), (true, false), (false, false)] {
            let options = mcap::WriteOptions::new()
                .compression(compression)
                .use_chunks(chunks)
                .chunk_size(Some(64))
                .emit_summary_records(summary)
                .emit_summary_offsets(summary);
            let bytes = foreign(options, |writer| {
                let map = std::collections::BTreeMap::new();
                let a = writer.add_channel(0, "/a", "json", &map).unwrap();
                for k in 0..20 {
                    send(writer, a, (k, u64::from(k)), b"[1, 2, 3]");
                }
            });
            let found = judge(&bytes);
            assert_eq!(found.problems, [], "{compression:?} {chunks} {summary}");
            assert_eq!((found.messages, found.summary), (20, summary));
        }
    }
}

/// The Python writer points at the groups of attachments and metadata that are not there; a group of
/// some bytes must be.
#[test]
fn offsets_of_nothing_are_sound() {
    let whole = foreign(mcap::WriteOptions::new(), |writer| {
        let map = std::collections::BTreeMap::new();
        let a = writer.add_channel(0, "/a", "json", &map).unwrap();
        send(writer, a, (0, 0), b"[1, 2, 3]");
    });
    // The footer: its kind, its length, two offsets and a checksum; then the magic.
    let footer = whole.len() - 8 - (1 + 8 + 8 + 8 + 4);
    assert_eq!(whole[footer], op::FOOTER);
    let with_offset = |length: u64| {
        let mut bytes = whole[..footer].to_vec();
        bytes.push(op::SUMMARY_OFFSET);
        bytes.extend(17_u64.to_le_bytes());
        bytes.push(op::METADATA_INDEX);
        bytes.extend((footer as u64).to_le_bytes());
        bytes.extend(length.to_le_bytes());
        bytes.extend(&whole[footer..]);
        // 0: no checksum of the summary.
        let checksum = bytes.len() - 8 - 4;
        bytes[checksum..checksum + 4].fill(0);
        judge(&bytes)
    };
    let found = with_offset(0);
    assert_eq!(found.problems, []);
    assert!(found.sound && found.summary);
    let found = with_offset(5);
    assert_eq!(
        texts(&found, ProblemKind::Index),
        [format!(
            "no 5 bytes of records of the kind 0x0d at {footer}"
        )]
    );
}

/// The conformance files of MCAP (foxglove/mcap, tests/conformance): all are sound.
#[test]
fn published_conformance_files_are_sound() {
    let Some(folder) = std::env::var_os("GTFDI_REFERENCE_DATA").map(std::path::PathBuf::from)
    else {
        println!("skipped: published_conformance_files_are_sound: GTFDI_REFERENCE_DATA is not set");
        return;
    };
    let mut files = 0;
    for group in ["NoData", "OneMessage"] {
        for entry in fs::read_dir(folder.join("mcap").join(group)).unwrap() {
            let path = entry.unwrap().path();
            if path.extension().is_none_or(|own| own != "mcap") {
                continue;
            }
            let found = verify(&path).unwrap();
            assert_eq!(found.problems, [], "{}", path.display());
            assert_eq!(found.messages, u64::from(group == "OneMessage"));
            let out = tempdir().unwrap();
            let mended = recover(&path, &out.path().join("a.mcap")).unwrap();
            assert!(mended.sound, "{}: {:?}", path.display(), mended.losses);
            assert_eq!(mended.messages, found.messages);
            assert!(verify(&out.path().join("a.mcap")).unwrap().sound);
            files += 1;
        }
    }
    assert!(files > 6, "{files} conformance files");
}

proptest! {
    #[test]
    fn prop_any_bytes_are_an_answer(
        mut bytes in proptest::collection::vec(any::<u8>(), 0..400),
        magic in any::<bool>(),
    ) {
        if magic {
            bytes.splice(0..0, mcap::MAGIC.iter().copied());
        }
        prop_assert!(!judge(&bytes).sound);
    }

    /// What is recovered from a damaged log is sound.
    #[test]
    fn prop_what_is_recovered_is_sound(place in any::<usize>(), byte in any::<u8>(), length in 1_usize..30) {
        let mut bytes = own_log();
        let place = place % bytes.len();
        let end = (place + length).min(bytes.len());
        bytes[place..end].fill(byte);
        let folder = tempdir().unwrap();
        let (from, out) = (folder.path().join("a.mcap"), folder.path().join("b.mcap"));
        fs::write(&from, &bytes).unwrap();
        if recover(&from, &out).is_ok() {
            let found = verify(&out).unwrap();
            prop_assert!(found.sound, "{:?}", found.problems);
        }
    }
}
