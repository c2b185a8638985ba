//! Where the records go on after bytes that are none.

use mcap::records::{Record, op};

use crate::LogError;
use crate::chunk::{HEAD_LIMIT, head};
use crate::raw::{RawFile, prefix};
use crate::records::{PREFIX, parse};

/// Bytes that are read at a time.
const BLOCK: u64 = 1 << 16;
/// Fields of a later version that a known record may end with.
const PADDING_LIMIT: u64 = 1 << 10;
/// Metadata, schemas and channels are shorter.
const PLAIN_LIMIT: u64 = 64 << 20;

/// The first offset from `from` on at which a record stands that gives itself away: by lengths that
/// agree with each other, or by a checksum. Among `plain` records are schemas, channels and messages
/// too; within a chunk that is not packed they are its own.
pub(super) fn resync(file: &mut RawFile, from: u64, plain: bool) -> Result<Option<u64>, LogError> {
    let size = file.size();
    let mut start = from;
    while start + (PREFIX as u64) <= size {
        let block = file.read(start, BLOCK)?;
        let places = block.len().saturating_sub(PREFIX - 1);
        for place in 0..places {
            let Some((opcode, length)) = prefix(&block[place..]) else {
                break;
            };
            let offset = start + place as u64;
            if length <= size - offset - (PREFIX as u64)
                && is_candidate(opcode, length, plain)
                && is_record(file, offset, opcode, length)?
            {
                return Ok(Some(offset));
            }
        }
        if places == 0 {
            break;
        }
        start += places as u64;
    }
    Ok(None)
}

/// Whether a record of this length may have this opcode.
fn is_candidate(opcode: u8, length: u64, plain: bool) -> bool {
    match opcode {
        op::CHUNK => length >= 28 + 4 + 8,
        op::ATTACHMENT => length >= 16 + 8 + 8 + 4,
        op::METADATA => (8..=PLAIN_LIMIT).contains(&length),
        op::MESSAGE_INDEX => length >= 6,
        op::DATA_END => length == 4,
        op::FOOTER => length == 20,
        op::SCHEMA => plain && (14..=PLAIN_LIMIT).contains(&length),
        op::CHANNEL => plain && (16..=PLAIN_LIMIT).contains(&length),
        op::MESSAGE => plain && length >= 22,
        _ => false,
    }
}

/// Whether the record at `offset`, which lies within the file, is one.
fn is_record(file: &mut RawFile, offset: u64, opcode: u8, length: u64) -> Result<bool, LogError> {
    let start = offset + PREFIX as u64;
    match opcode {
        op::CHUNK => {
            let bytes = file.read(start, HEAD_LIMIT.min(length))?;
            Ok(head(&bytes).is_some_and(|(header, end)| {
                let data = length - end as u64;
                header.compressed_size <= data && data - header.compressed_size <= PADDING_LIMIT
            }))
        }
        op::MESSAGE_INDEX => {
            let bytes = file.read(start + 2, 4)?;
            let entries = bytes.first_chunk::<4>().map(|own| u32::from_le_bytes(*own));
            Ok(entries.is_some_and(|own| own % 16 == 0 && u64::from(own) + 6 == length))
        }
        op::FOOTER => Ok(file.read(start + length, 8)? == mcap::MAGIC),
        op::DATA_END | op::MESSAGE => follows(file, start + length),
        _ => {
            let body = file.read(start, length)?;
            Ok(match parse(opcode, &body) {
                Ok(Record::Attachment { crc, .. }) => crc != 0,
                Ok(Record::Metadata(record)) => {
                    let pairs = record.metadata.iter();
                    let pairs: usize = pairs.map(|(k, v)| 8 + k.len() + v.len()).sum();
                    8 + record.name.len() + pairs == body.len()
                }
                Ok(Record::Schema { header, data }) => {
                    let strings = header.name.len() + header.encoding.len();
                    header.id != 0 && 2 + 8 + strings + 4 + data.len() == body.len()
                }
                Ok(Record::Channel(channel)) => {
                    let pairs = channel.metadata.iter();
                    let pairs: usize = pairs.map(|(k, v)| 8 + k.len() + v.len()).sum();
                    let strings = channel.topic.len() + channel.message_encoding.len();
                    4 + 8 + strings + 4 + pairs == body.len()
                }
                _ => false,
            })
        }
    }
}

/// Whether a record may begin at `offset`, or the file ends there.
fn follows(file: &mut RawFile, offset: u64) -> Result<bool, LogError> {
    let left = file.size().saturating_sub(offset);
    Ok(match file.prefix(offset)? {
        Some((opcode, length)) => {
            (op::HEADER..=op::DATA_END).contains(&opcode) && length <= left - (PREFIX as u64)
        }
        None => left == 0,
    })
}
