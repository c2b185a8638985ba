//! Damaged logs, mended: what was flushed is there again, bit for bit.

#![allow(clippy::unwrap_used, clippy::panic, reason = "helpers of tests")]

use std::fs;
use std::path::Path;

use gt_core::Signal;
use gt_log::{
    LogError, LogWriter, LossKind, Recovery, RunMetadata, Selection, info, read_attachment,
    read_dataset, recover, sample_time_ns,
};
use mcap::records::op;
use proptest::prelude::*;
use tempfile::tempdir;

const MODEL: &[u8] = b"{\"model\": [1.0, 2.0, 3.0]}";

/// A value without a pattern, so that nothing packs well.
fn value(k: usize) -> f64 {
    let mixed = (k as u64 + 1).wrapping_mul(0x9e37_79b9_7f4a_7c15);
    f64::from_bits((1023 << 52) | (mixed >> 12))
}

/// The bytes of a log that is flushed every `every` of `samples` samples, before and after it is
/// finished, and how many bytes there are after each flush.
fn flushed(samples: usize, every: usize) -> (Vec<u8>, Vec<u8>, Vec<usize>) {
    let folder = tempdir().unwrap();
    let path = folder.path().join("a.mcap");
    let part = folder.path().join("a.mcap.part");
    let mut log = LogWriter::create(&path, &RunMetadata::default()).unwrap();
    log.attach("models/a.json", "application/json", MODEL)
        .unwrap();
    let signals = Signal::named(&["a", "b-c"]);
    let topic = log
        .add_topic("/plant/measured", "M", &signals, 1.0, "x")
        .unwrap();
    let mut ends = Vec::new();
    for k in 0..samples {
        log.write(topic, sample_time_ns(k, 1.0), &[value(k), -value(k)])
            .unwrap();
        if (k + 1) % every == 0 {
            log.flush().unwrap();
            ends.push(usize::try_from(fs::metadata(&part).unwrap().len()).unwrap());
        }
    }
    let open = fs::read(&part).unwrap();
    log.finish().unwrap();
    (open, fs::read(&path).unwrap(), ends)
}

/// Recovers `bytes`, and reads the result with this crate's reader and with mcap's own.
fn mend(bytes: &[u8]) -> Result<(Recovery, Vec<u64>), LogError> {
    let folder = tempdir().unwrap();
    let (from, out) = (
        folder.path().join("a.mcap.part"),
        folder.path().join("a.mcap"),
    );
    fs::write(&from, bytes).unwrap();
    let result = recover(&from, &out);
    assert_eq!(fs::read(&from).unwrap(), bytes, "the input is as it was");
    if result.is_err() {
        assert!(!out.exists(), "nothing half written");
    }
    let recovery = result?;
    let whole = fs::read(&out).unwrap();
    let files: Vec<_> = fs::read_dir(folder.path()).unwrap().collect();
    assert_eq!(files.len(), 2, "no file is left over");
    let own = info(&out).unwrap();
    let foreign: Vec<_> = mcap::MessageStream::new(&whole)
        .unwrap()
        .map(Result::unwrap)
        .collect();
    let summary = mcap::Summary::read(&whole).unwrap().unwrap();
    assert_eq!(summary.stats.unwrap().message_count, recovery.messages);
    assert_eq!(own.messages, recovery.messages);
    assert_eq!(foreign.len() as u64, recovery.messages);
    Ok((recovery, values(&out, own.messages)))
}

/// The bits of the first signal.
fn values(path: &Path, messages: u64) -> Vec<u64> {
    if messages == 0 {
        return Vec::new();
    }
    let selection = Selection {
        outputs: vec!["*".to_owned()],
        sample_time_s: Some(1.0),
        ..Selection::default()
    };
    let data = read_dataset(path, &selection).unwrap().dataset;
    let (a, b) = (data.y().row(0), data.y().row(1));
    assert!(
        a.iter()
            .zip(b.iter())
            .all(|(a, b)| a.to_bits() == (-b).to_bits())
    );
    a.iter().map(|value| value.to_bits()).collect()
}

fn expected(count: usize) -> Vec<u64> {
    (0..count).map(|k| value(k).to_bits()).collect()
}

/// Numbers of a linear congruential generator (Knuth's MMIX).
fn places(seed: u64, count: usize, below: usize) -> Vec<usize> {
    let mut state = seed;
    let next = || {
        state = state
            .wrapping_mul(6364136223846793005)
            .wrapping_add(1442695040888963407);
        usize::try_from(state >> 33).unwrap() % below
    };
    std::iter::repeat_with(next).take(count).collect()
}

#[test]
fn a_sound_log_loses_nothing() {
    let (_, whole, _) = flushed(100, 7);
    let (recovery, found) = mend(&whole).unwrap();
    assert!(recovery.sound && recovery.closed, "{recovery:?}");
    assert_eq!((recovery.lost_bytes, recovery.losses.len()), (0, 0));
    assert_eq!(recovery.metadata, ["gtfdi.run", "gtfdi.config"]);
    assert_eq!(recovery.attachments, ["models/a.json"]);
    assert_eq!(found, expected(100));
}

/// Cut at 200 places, and at each boundary: every sample that was flushed before the cut is there,
/// and whatever else is there is the beginning of the rest.
#[test]
fn every_flushed_sample_is_recovered_wherever_the_log_is_cut() {
    let (open, whole, ends) = flushed(300, 6);
    assert_eq!(
        whole[..open.len()],
        open,
        "the last flush left no open chunk"
    );
    let mut cuts = places(7, 200, whole.len());
    cuts.extend(ends.iter().flat_map(|end| [*end, end - 1, end + 1]));
    let mut more = 0;
    for cut in cuts {
        let flushed = 6 * ends.iter().filter(|end| **end <= cut).count();
        match mend(&whole[..cut]) {
            Ok((recovery, found)) => {
                assert!(!recovery.closed, "cut at {cut}");
                assert!(
                    found.len() >= flushed,
                    "cut at {cut}: {} of {flushed}",
                    found.len()
                );
                assert_eq!(found, expected(found.len()), "cut at {cut}");
                more += usize::from(found.len() > flushed);
            }
            Err(error) => {
                assert!(
                    matches!(error, LogError::NothingToRecover { .. }),
                    "{error}"
                );
                assert!(cut < ends[0], "cut at {cut}: {error}");
            }
        }
    }
    // Cuts within the indexes behind a chunk, at least.
    assert!(more > 0);
}

/// A chunk of many blocks of zstd: those before the cut are there.
#[test]
fn the_blocks_before_a_cut_within_a_chunk_are_recovered() {
    let (open, whole, ends) = flushed(20_000, 20_000);
    // The index of the messages, behind the chunk, has nearly half of the bytes.
    let cut = ends[0] * 2 / 5;
    for bytes in [&whole[..cut], &open[..cut]] {
        let (recovery, found) = mend(bytes).unwrap();
        assert!(recovery.cut_chunk && !recovery.sound, "{recovery:?}");
        assert!(found.len() > 5_000, "{} samples", found.len());
        assert_eq!(found, expected(found.len()));
        let loss = &recovery.losses[0];
        assert_eq!(loss.kind, LossKind::EndOfChunk);
        assert!(
            loss.cause.ends_with(&format!(
                "with {} messages (no checksum vouches for them: those that decode are written)",
                found.len()
            )),
            "{}",
            loss.cause
        );
        assert_eq!(recovery.attachments, ["models/a.json"]);
    }
}

/// What a crash leaves: the head of the chunk says 2^64 - 1 bytes.
#[test]
fn a_chunk_that_was_never_closed_is_read_as_far_as_it_goes() {
    let folder = tempdir().unwrap();
    let path = folder.path().join("a.mcap");
    let part = folder.path().join("a.mcap.part");
    let mut log = LogWriter::create(&path, &RunMetadata::default()).unwrap();
    let signals = Signal::named(&["a", "b-c"]);
    let topic = log
        .add_topic("/plant/measured", "M", &signals, 1.0, "x")
        .unwrap();
    for k in 0..20_000 {
        log.write(topic, sample_time_ns(k, 1.0), &[value(k), -value(k)])
            .unwrap();
    }
    let open = fs::read(&part).unwrap();
    drop(log);
    let (recovery, found) = mend(&open).unwrap();
    assert!(recovery.cut_chunk && !recovery.closed);
    assert!(found.len() > 10_000, "{} samples", found.len());
    assert_eq!(found, expected(found.len()));
}

/// One bit anywhere: all chunks but one are there, and no value is another.
#[test]
fn a_changed_bit_costs_one_chunk_at_most() {
    let (_, whole, ends) = flushed(120, 6);
    let first_end = ends[0];
    for place in places(11, 300, whole.len()) {
        let mut bytes = whole.clone();
        bytes[place] ^= 1 << (place % 8);
        let (recovery, found) = mend(&bytes).unwrap();
        let all = expected(120);
        let lost: Vec<_> = all.iter().filter(|own| !found.contains(own)).collect();
        // The definitions stand in the first chunk and in the summary.
        assert!(
            lost.len() <= 6,
            "{place}: {} lost: {recovery:?}",
            lost.len()
        );
        assert!(found.iter().all(|own| all.contains(own)), "{place}");
        if !lost.is_empty() {
            assert!(!recovery.sound, "{place}");
            let chunk = recovery
                .losses
                .iter()
                .find(|own| own.kind == LossKind::Chunk);
            let chunk = chunk.unwrap_or_else(|| panic!("{place}: {:?}", recovery.losses));
            assert!(chunk.bytes > 0, "{place} (first chunk ends at {first_end})");
        }
    }
}

#[test]
fn a_chunk_with_another_checksum_is_named_with_its_times() {
    let (_, whole, ends) = flushed(18, 6);
    // The second chunk: its data begin 9 + 28 + 4 + 4 + 8 bytes behind the first flush's end.
    let mut bytes = whole.clone();
    bytes[ends[0] + 53 + 20] ^= 0x10;
    let (recovery, found) = mend(&bytes).unwrap();
    let mut rest = expected(18);
    rest.drain(6..12);
    assert_eq!(found, rest);
    let [loss] = recovery.losses.as_slice() else {
        panic!("one loss, found {:?}", recovery.losses)
    };
    assert_eq!((loss.offset, loss.kind), (ends[0] as u64, LossKind::Chunk));
    assert_eq!(loss.first_ns, Some(sample_time_ns(6, 1.0)));
    assert_eq!(loss.last_ns, Some(sample_time_ns(11, 1.0)));
    assert!(loss.cause.contains("expected the CRC"), "{}", loss.cause);
    assert!(recovery.closed && !recovery.sound);
    assert_eq!(recovery.lost_bytes, loss.bytes);
}

#[test]
fn attachments_and_metadata_survive_and_the_loss_is_on_record() {
    let (_, whole, ends) = flushed(60, 6);
    let folder = tempdir().unwrap();
    let (from, out) = (folder.path().join("cut.mcap"), folder.path().join("b.mcap"));
    fs::write(&from, &whole[..ends[3] - 5]).unwrap();
    recover(&from, &out).unwrap();
    assert_eq!(read_attachment(&out, "models/a.json").unwrap(), MODEL);
    let info = info(&out).unwrap();
    let names: Vec<_> = info.metadata.iter().map(|own| own.name.as_str()).collect();
    assert_eq!(names, ["gtfdi.run", "gtfdi.config", "gtfdi.recovery"]);
    let values = &info.metadata[2].values;
    assert_eq!(values["source_bytes"], (ends[3] - 5).to_string());
    assert_eq!(
        values["source_sha256"],
        gt_log::sha256_hex(&whole[..ends[3] - 5])
    );
    assert_eq!(info.topics[0].fields, Signal::named(&["a", "b-c"]));
    // The same file gives the same bytes.
    let again = folder.path().join("c.mcap");
    recover(&from, &again).unwrap();
    assert_eq!(fs::read(&out).unwrap(), fs::read(&again).unwrap());
}

#[test]
fn a_damaged_attachment_is_left_out_and_named() {
    let (_, whole, _) = flushed(6, 6);
    let place = whole
        .windows(MODEL.len())
        .position(|own| own == MODEL)
        .unwrap();
    let mut bytes = whole.clone();
    bytes[place + 3] ^= 1;
    let (recovery, found) = mend(&bytes).unwrap();
    assert_eq!(found, expected(6));
    assert!(recovery.attachments.is_empty());
    assert_eq!(recovery.losses[0].kind, LossKind::Attachment);
    assert!(
        recovery.losses[0].cause.contains("Attachment CRC"),
        "{}",
        recovery.losses[0].cause
    );
}

#[test]
fn a_changed_record_without_a_checksum_is_told_by_that_of_the_data() {
    let (_, whole, _) = flushed(6, 6);
    // The key after its length, and then the value after its own.
    let key = b"\x07\0\0\0version";
    let place = whole.windows(11).position(|own| own == key).unwrap();
    let mut bytes = whole.clone();
    bytes[place + 16] ^= 1;
    let (recovery, found) = mend(&bytes).unwrap();
    assert_eq!(found, expected(6));
    assert!(!recovery.sound);
    assert!(
        recovery.losses[0]
            .cause
            .contains("something without a checksum of its own was changed"),
        "{:?}",
        recovery.losses
    );
}

#[test]
fn it_refuses_its_own_input_and_files_without_a_record() {
    let folder = tempdir().unwrap();
    let path = folder.path().join("a.mcap");
    fs::write(&path, flushed(6, 6).1).unwrap();
    let before = fs::read(&path).unwrap();
    let error = recover(&path, &path).unwrap_err().to_string();
    assert_eq!(
        error,
        format!(
            "{}: expected another file to write than the one that is read; give another name",
            path.display()
        )
    );
    assert_eq!(fs::read(&path).unwrap(), before);
    let text = folder.path().join("text.mcap");
    fs::write(&text, "time,y\n0,1\n").unwrap();
    let error = recover(&text, &folder.path().join("b.mcap")).unwrap_err();
    assert_eq!(
        error.to_string(),
        format!(
            "{}: expected the records of an MCAP file, found none in 11 bytes",
            text.display()
        )
    );
    let missing = folder.path().join("none.mcap");
    let error = recover(&missing, &folder.path().join("b.mcap")).unwrap_err();
    assert!(matches!(error, LogError::NotFound { .. }));
}

/// The same messages with other chunks, by another writer.
fn foreign(compression: Option<mcap::Compression>, use_chunks: bool) -> Vec<u8> {
    let own = flushed(60, 60).1;
    let mut bytes = std::io::Cursor::new(Vec::new());
    let options = mcap::WriteOptions::new()
        .compression(compression)
        .chunk_size(Some(300))
        .use_chunks(use_chunks);
    let mut writer = options.create(&mut bytes).unwrap();
    for message in mcap::MessageStream::new(&own).unwrap() {
        writer.write(&message.unwrap()).unwrap();
    }
    writer.finish().unwrap();
    drop(writer);
    bytes.into_inner()
}

#[test]
fn foreign_logs_are_mended_too() {
    let kinds = [
        foreign(None, true),
        foreign(None, false),
        foreign(Some(mcap::Compression::Lz4), true),
    ];
    for (kind, whole) in kinds.iter().enumerate() {
        let (recovery, found) = mend(whole).unwrap();
        assert!(recovery.sound, "{kind}: {recovery:?}");
        assert_eq!(found, expected(60), "{kind}");
        for cut in places(3, 60, whole.len()) {
            if let Ok((_, found)) = mend(&whole[..cut]) {
                assert_eq!(found, expected(found.len()), "{kind}: cut at {cut}");
                // Nine tenths of the messages of what is there, in whatever chunks.
                let share = cut * 50 / whole.len();
                assert!(found.len() + 30 > share, "{kind}: {} at {cut}", found.len());
            }
        }
    }
}

/// A record of a kind that nobody knows is passed over and told.
#[test]
fn records_of_unknown_kinds_are_named() {
    let mut bytes = std::io::Cursor::new(Vec::new());
    let mut writer = mcap::WriteOptions::new().create(&mut bytes).unwrap();
    let within = mcap::write::PrivateRecordOptions::IncludeInChunks;
    let (inside, outside) = (within.into(), !(within | within));
    writer
        .write_private_record(0x99, b"private", inside)
        .unwrap();
    writer
        .write_private_record(0x98, b"private", outside)
        .unwrap();
    writer.finish().unwrap();
    drop(writer);
    let bytes = bytes.into_inner();
    let folder = tempdir().unwrap();
    let (from, out) = (folder.path().join("a.mcap"), folder.path().join("b.mcap"));
    fs::write(&from, &bytes).unwrap();
    let recovery = recover(&from, &out).unwrap();
    let [loss] = recovery.losses.as_slice() else {
        panic!("one loss, found {:?}", recovery.losses)
    };
    assert_eq!(loss.kind, LossKind::UnknownRecord);
    assert_eq!(loss.cause, "the opcode 0x98 is not known");
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(48))]

    /// Bytes overwritten, cut out and put in: no panic, nothing half written, no value that never was.
    #[test]
    fn prop_no_value_is_invented(
        edits in proptest::collection::vec((any::<usize>(), 0_u8..4, any::<u8>(), 1_usize..40), 1..5),
    ) {
        let (_, mut bytes, _) = flushed(60, 6);
        for (place, kind, byte, length) in edits {
            let place = place % bytes.len();
            let end = (place + length).min(bytes.len());
            match kind {
                0 => bytes[place..end].fill(byte),
                1 => drop(bytes.drain(place..end)),
                2 => drop(bytes.splice(place..place, vec![byte; length])),
                _ => bytes.truncate(place.max(1)),
            }
            if bytes.is_empty() {
                break;
            }
        }
        if let Ok((_, found)) = mend(&bytes) {
            let all = expected(60);
            prop_assert!(found.iter().all(|own| all.contains(own)));
        }
    }

    #[test]
    fn prop_any_bytes_are_an_answer(
        mut bytes in proptest::collection::vec(any::<u8>(), 0..400),
        magic in any::<bool>(),
    ) {
        if magic {
            bytes.splice(0..0, mcap::MAGIC.iter().copied());
        }
        let folder = tempdir().unwrap();
        let (from, out) = (folder.path().join("a.mcap"), folder.path().join("b.mcap"));
        fs::write(&from, &bytes).unwrap();
        if let Err(error) = recover(&from, &out) {
            prop_assert!(!error.to_string().is_empty());
            prop_assert!(!out.exists());
        }
    }
}

#[test]
fn the_opcode_of_a_chunk_does_not_matter_where_its_checksum_agrees() {
    let (_, whole, ends) = flushed(18, 6);
    for place in [ends[0], ends[0] + 1, ends[0] + 8, ends[0] + 9 + 29] {
        let mut bytes = whole.clone();
        assert_eq!(whole[ends[0]], op::CHUNK);
        bytes[place] ^= 0x80;
        let (recovery, found) = mend(&bytes).unwrap();
        if place == ends[0] + 9 + 29 {
            // The length of the name of its compression: there is no way to unpack it.
            assert_eq!(found.len(), 12);
        } else {
            assert_eq!(found, expected(18), "{place}: {recovery:?}");
        }
    }
}

/// A log of one JSON topic, without chunks or in one, whose messages are these.
fn json_log(messages: &[&str], use_chunks: bool) -> Vec<u8> {
    let mut bytes = std::io::Cursor::new(Vec::new());
    let options = mcap::WriteOptions::new()
        .compression(None)
        .use_chunks(use_chunks);
    let mut writer = options.create(&mut bytes).unwrap();
    let id = writer
        .add_channel(0, "/level", "json", &std::collections::BTreeMap::new())
        .unwrap();
    for (sequence, text) in (1_u32..).zip(messages) {
        let header = mcap::records::MessageHeader {
            channel_id: id,
            sequence,
            log_time: u64::from(sequence),
            publish_time: u64::from(sequence),
        };
        writer
            .write_to_known_channel(&header, text.as_bytes())
            .unwrap();
    }
    writer.finish().unwrap();
    drop(writer);
    bytes.into_inner()
}

/// Recovers `bytes`; beside the result what `verify` finds wrong with definitions and messages of the
/// recovered log, which must be sound otherwise.
fn mend_and_verify(bytes: &[u8]) -> (Recovery, Vec<String>) {
    let folder = tempdir().unwrap();
    let (from, out) = (folder.path().join("a.mcap"), folder.path().join("b.mcap"));
    fs::write(&from, bytes).unwrap();
    let recovery = recover(&from, &out).unwrap();
    let found = gt_log::verify(&out).unwrap();
    let of_content = |kind| {
        matches!(
            kind,
            gt_log::ProblemKind::Definition | gt_log::ProblemKind::Message
        )
    };
    let own = found.problems.iter();
    assert!(own.clone().all(|own| of_content(own.kind)), "{found:?}");
    (recovery, own.map(|own| own.text.clone()).collect())
}

fn replaced(bytes: &[u8], from: &[u8], to: &[u8]) -> Vec<u8> {
    assert_eq!(from.len(), to.len());
    let mut own = bytes.windows(from.len());
    let place = own.position(|window| window == from).unwrap();
    [&bytes[..place], to, &bytes[place + from.len()..]].concat()
}

#[test]
fn without_a_checksum_a_message_is_written_if_it_decodes() {
    let whole = json_log(&["{\"a\": 1}", "{\"a\": 2}", "{\"a\": 3}"], false);
    let changed = replaced(&whole, b"{\"a\": 2}", b"{\"a: 2}}");
    let (recovery, problems) = mend_and_verify(&changed);
    assert_eq!((recovery.messages, recovery.undecoded_messages), (2, 0));
    assert_eq!(problems, [""; 0]);
    let loss = recovery.losses.last().unwrap();
    assert_eq!((loss.kind, loss.first_ns), (LossKind::Message, Some(2)));
    // Opcode, length, the message's head of 22 bytes, its text.
    assert_eq!(loss.bytes, 9 + 22 + 8);
    assert!(
        loss.cause.starts_with(
            "1 messages of topic `/level` do not decode by its schema, and no checksum vouches for \
             them; of the first: "
        ),
        "{}",
        loss.cause
    );
    // The same in a chunk that is cut off within its last message.
    let whole = json_log(&["{\"a\": 1}", "{\"a: 2}}", "{\"a\": 3}"], true);
    let last = whole.windows(8).position(|own| own == b"{\"a\": 3}");
    let (recovery, problems) = mend_and_verify(&whole[..last.unwrap() + 4]);
    assert!(!recovery.closed);
    assert_eq!((recovery.messages, recovery.undecoded_messages), (1, 0));
    assert_eq!(problems, [""; 0]);
}

#[test]
fn under_a_checksum_a_message_is_written_as_it_stands() {
    for use_chunks in [false, true] {
        let whole = json_log(&["{\"a\": 1}", "{\"a: 2}}"], use_chunks);
        let (recovery, problems) = mend_and_verify(&whole);
        assert!(recovery.sound, "{recovery:?}");
        assert_eq!((recovery.messages, recovery.undecoded_messages), (2, 1));
        let [problem] = problems.as_slice() else {
            panic!("one problem, found {problems:?}")
        };
        assert!(
            problem.starts_with("topic `/level`, message 2"),
            "{problem}"
        );
    }
}

#[test]
fn a_definition_that_was_changed_gives_way_to_its_copy_in_the_summary() {
    let whole = foreign(None, false);
    // The name of the message in the schema record, by its length before it: the descriptor has none
    // of that name then.
    let (name, other) = (b"\x0a\0\0\0gtfdi.v1.M", b"\x0a\0\0\0gtfdi.v1.N");
    let (recovery, found) = mend(&replaced(&whole, name, other)).unwrap();
    assert_eq!(found, expected(60));
    assert_eq!((recovery.undecoded_channels, recovery.closed), (0, true));
    assert!(!recovery.sound, "the checksum of the data tells");
    // Without a summary there is no copy: the messages are lost, and named.
    let end = whole
        .windows(9)
        .position(|own| own == b"\x0f\x04\0\0\0\0\0\0\0");
    let changed = replaced(&whole[..end.unwrap()], name, other);
    let (recovery, problems) = mend_and_verify(&changed);
    assert_eq!((recovery.messages, problems.len()), (0, 0));
    let loss = recovery.losses.last().unwrap();
    assert_eq!(loss.kind, LossKind::Undefined);
    assert!(
        loss.cause
            .starts_with("60 messages of channel 1, whose definition is broken: "),
        "{}",
        loss.cause
    );
}
