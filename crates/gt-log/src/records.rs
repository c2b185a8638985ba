//! The records of an MCAP file, one after the other, with every checksum verified.
//!
//! `mcap` reads sound files well, but panics or asks for absurd amounts of memory on some broken
//! ones: a record that reaches past its uncompressed chunk, an attachment shorter than its header,
//! a record near 2^64 bytes inside a compressed chunk, a string of 4 GiB. What is checked here
//! keeps it from those.

use std::io::{self, Read};
use std::ops::ControlFlow;
use std::path::Path;

use mcap::records::{Record, op};
use mcap::sans_io::linear_reader::{LinearReadEvent, LinearReader, LinearReaderOptions};
use mcap::{MAGIC, McapError, parse_record};

use crate::LogError;

/// Opcode and length of a record.
pub(crate) const PREFIX: usize = 1 + 8;
/// No record of a log comes near this; a length beyond it is a broken one.
const RECORD_LIMIT: usize = 256 << 20;

/// Calls `visit` with every record of the data section in the order of the file: a chunk first as
/// itself, then its records. After a `Break` nothing more is read.
pub(crate) fn scan<R: Read>(
    path: &Path,
    mut source: R,
    size: u64,
    mut visit: impl FnMut(Record<'_>) -> Result<ControlFlow<()>, LogError>,
) -> Result<(), LogError> {
    let limit = usize::try_from(size).unwrap_or(usize::MAX).max(1024);
    let mut reader = LinearReader::new_with_options(
        LinearReaderOptions::default()
            .with_emit_chunks(true)
            .with_validate_data_section_crc(true)
            .with_validate_summary_section_crc(true)
            .with_record_length_limit(limit),
    );
    let corrupt = |cause| LogError::Corrupt {
        path: path.to_owned(),
        cause,
    };
    let mut first = Vec::new();
    let mut begun = false;
    let mut in_data = true;
    while let Some(event) = reader.next_event() {
        match event {
            Ok(LinearReadEvent::ReadRequest(need)) => {
                let target = reader.insert(need);
                let count = read_some(&mut source, target)
                    .map_err(|cause| LogError::io(path, "read", cause))?;
                if first.len() < MAGIC.len() {
                    let missing = MAGIC.len() - first.len();
                    first.extend_from_slice(&target[..count.min(missing)]);
                }
                reader.notify_read(count);
            }
            Ok(LinearReadEvent::Record { opcode, data }) => {
                begun = true;
                if opcode == op::DATA_END {
                    // The summary repeats what has been seen; it is only checked.
                    in_data = false;
                }
                if !in_data {
                    continue;
                }
                let record = parse(opcode, data).map_err(corrupt)?;
                let is_chunk = opcode == op::CHUNK;
                if visit(record)?.is_break() {
                    return Ok(());
                }
                if is_chunk && scan_chunk(data, &corrupt, &mut visit)?.is_break() {
                    return Ok(());
                }
            }
            // The limit is the file's size: a longer record is one whose end is not there.
            Err(McapError::UnexpectedEof | McapError::RecordTooLarge { .. })
                if MAGIC.starts_with(&first) =>
            {
                return Err(LogError::Truncated {
                    path: path.to_owned(),
                    size,
                });
            }
            Err(McapError::BadMagic | McapError::UnexpectedEof) if !begun => {
                return Err(LogError::Magic {
                    path: path.to_owned(),
                    found: first,
                });
            }
            Err(cause) => return Err(corrupt(cause)),
        }
    }
    Ok(())
}

fn read_some<R: Read>(source: &mut R, target: &mut [u8]) -> io::Result<usize> {
    loop {
        match source.read(target) {
            Err(cause) if cause.kind() == io::ErrorKind::Interrupted => {}
            result => return result,
        }
    }
}

/// A record of its body, where its strings and maps lie within that.
pub(crate) fn parse(opcode: u8, body: &[u8]) -> Result<Record<'_>, McapError> {
    if !is_within(opcode, body) {
        return Err(McapError::UnexpectedEof);
    }
    parse_record(opcode, body)
}

/// Whether the strings and maps of a record lie within its body.
fn is_within(opcode: u8, body: &[u8]) -> bool {
    // Bytes before the strings, how many strings, bytes after them.
    let (before, strings, after) = match opcode {
        op::HEADER => (0, 2, 0),
        op::SCHEMA => (2, 2, 4),
        op::CHANNEL => (4, 2, 4),
        op::METADATA => (0, 1, 4),
        op::CHUNK => (28, 1, 8),
        op::ATTACHMENT => (16, 2, 8 + 4),
        op::ATTACHMENT_INDEX => (40, 2, 0),
        op::METADATA_INDEX => (16, 1, 0),
        op::CHUNK_INDEX => return is_chunk_index(body),
        _ => return true,
    };
    let Some(rest) = body
        .get(before..)
        .and_then(|rest| skip_strings(rest, strings))
    else {
        return false;
    };
    if rest.len() < after {
        return false;
    }
    !matches!(opcode, op::CHANNEL | op::METADATA) || is_map(rest)
}

/// Whether the offsets and the compression of a chunk's index lie within its body.
fn is_chunk_index(body: &[u8]) -> bool {
    let after_offsets = body
        .get(32..)
        .and_then(|rest| rest.split_first_chunk::<4>())
        .and_then(|(length, rest)| rest.get(usize::try_from(u32::from_le_bytes(*length)).ok()?..));
    after_offsets
        .and_then(|rest| rest.get(8..))
        .and_then(|rest| skip_strings(rest, 1))
        .is_some_and(|rest| rest.len() >= 16)
}

/// What follows `count` strings, each its length in 4 bytes and then its bytes.
fn skip_strings(mut rest: &[u8], count: usize) -> Option<&[u8]> {
    for _ in 0..count {
        let (length, after) = rest.split_first_chunk::<4>()?;
        rest = after.get(usize::try_from(u32::from_le_bytes(*length)).ok()?..)?;
    }
    Some(rest)
}

/// Whether the bytes begin with a map: its length in 4 bytes, then pairs of strings.
fn is_map(bytes: &[u8]) -> bool {
    let pairs = bytes
        .split_first_chunk::<4>()
        .and_then(|(length, rest)| rest.get(..usize::try_from(u32::from_le_bytes(*length)).ok()?));
    let Some(mut pairs) = pairs else { return false };
    while !pairs.is_empty() {
        let Some(rest) = skip_strings(pairs, 2) else {
            return false;
        };
        pairs = rest;
    }
    true
}

fn scan_chunk(
    body: &[u8],
    corrupt: &impl Fn(McapError) -> LogError,
    visit: &mut impl FnMut(Record<'_>) -> Result<ControlFlow<()>, LogError>,
) -> Result<ControlFlow<()>, LogError> {
    let Record::Chunk { header, data } = parse_record(op::CHUNK, body).map_err(corrupt)? else {
        return Ok(ControlFlow::Continue(()));
    };
    if header.compression.is_empty() && !is_tiled(&data) {
        return Err(corrupt(McapError::UnexpectedEoc));
    }
    // The chunk goes through a reader of its own, which decompresses within limits.
    let mut reader = LinearReader::new_with_options(
        LinearReaderOptions::default()
            .with_skip_start_magic(true)
            .with_skip_end_magic(true)
            .with_validate_chunk_crcs(true)
            .with_record_length_limit(RECORD_LIMIT.max(body.len())),
    );
    let mut prefix = vec![op::CHUNK];
    prefix.extend_from_slice(&(body.len() as u64).to_le_bytes());
    let mut source = prefix.as_slice().chain(body);
    while let Some(event) = reader.next_event() {
        match event.map_err(corrupt)? {
            LinearReadEvent::ReadRequest(need) => {
                // Reading from memory cannot fail.
                let count = read_some(&mut source, reader.insert(need)).unwrap_or(0);
                reader.notify_read(count);
            }
            LinearReadEvent::Record { opcode, data } => {
                if matches!(opcode, op::SCHEMA | op::CHANNEL | op::MESSAGE)
                    && visit(parse(opcode, data).map_err(corrupt)?)?.is_break()
                {
                    return Ok(ControlFlow::Break(()));
                }
            }
        }
    }
    Ok(ControlFlow::Continue(()))
}

/// Whether records fill the bytes exactly.
fn is_tiled(mut data: &[u8]) -> bool {
    while !data.is_empty() {
        let Some(length) = data.get(1..).and_then(|rest| rest.first_chunk::<8>()) else {
            return false;
        };
        let end = usize::try_from(u64::from_le_bytes(*length))
            .ok()
            .and_then(|length| length.checked_add(PREFIX));
        let Some(rest) = end.and_then(|end| data.get(end..)) else {
            return false;
        };
        data = rest;
    }
    true
}
