//! Chunks and the indexes of their messages.

use std::collections::BTreeMap;

use mcap::records::{ChunkHeader, MessageIndex, Record, op};

use super::content::Content;
use super::problem::{ProblemKind, Problems};
use crate::chunk::unpack;
use crate::raw::Tiles;
use crate::records::parse;

/// A chunk as it stands in the file.
#[derive(Debug, Clone)]
pub(super) struct SeenChunk {
    pub(super) offset: u64,
    /// With its opcode and its length.
    pub(super) length: u64,
    pub(super) header: ChunkHeader,
    /// The offset of each index of messages behind it, by channel.
    pub(super) indexes: BTreeMap<u16, u64>,
    /// The bytes of these.
    pub(super) index_length: u64,
    /// Whether its content is known.
    pub(super) unpacked: bool,
    /// The log time and the offset of every message, by channel.
    messages: BTreeMap<u16, Vec<(u64, u64)>>,
}

impl SeenChunk {
    /// Judges a chunk, and its content as far as it can be unpacked.
    pub(super) fn of(
        offset: u64,
        length: u64,
        (header, data): (ChunkHeader, &[u8]),
        content: &mut Content,
        problems: &mut Problems,
    ) -> Self {
        let kind = ProblemKind::Chunk;
        let unpacked = unpack(&header.compression, data);
        let fault = unpacked.fault(&header);
        if let Some(cause) = &fault {
            problems.damage(offset, kind, cause.clone());
        } else if unpacked.bytes.len() as u64 != header.uncompressed_size {
            let (expected, found) = (header.uncompressed_size, unpacked.bytes.len());
            let text = format!("expected {expected} unpacked bytes, found {found}");
            problems.damage(offset, kind, text);
        }
        let mut chunk = Self {
            offset,
            length,
            header,
            indexes: BTreeMap::new(),
            index_length: 0,
            unpacked: fault.is_none(),
            messages: BTreeMap::new(),
        };
        if chunk.unpacked {
            chunk.records(&unpacked.bytes, content, problems);
        }
        chunk
    }

    fn records(&mut self, bytes: &[u8], content: &mut Content, problems: &mut Problems) {
        let (offset, kind) = (self.offset, ProblemKind::Chunk);
        let mut tiles = Tiles::new(bytes);
        let mut bounds: Option<(u64, u64)> = None;
        for (place, opcode, body) in tiles.by_ref() {
            match parse(opcode, body) {
                Ok(record @ (Record::Schema { .. } | Record::Channel(_))) => {
                    content.define(offset, record, false, problems);
                }
                Ok(Record::Message { header, data }) => {
                    let time = header.log_time;
                    bounds = Some(bounds.map_or((time, time), |(a, b)| (a.min(time), b.max(time))));
                    let own = self.messages.entry(header.channel_id).or_default();
                    own.push((time, place as u64));
                    content.message(offset, &header, &data, problems);
                }
                Ok(Record::Unknown { opcode, .. }) if opcode > op::DATA_END => {
                    let text = format!("a record of the unknown kind 0x{opcode:02x} in a chunk");
                    problems.remark(offset, kind, text);
                }
                Ok(other) => {
                    let text = format!(
                        "expected schemas, channels and messages in a chunk, found a record of \
                         the kind 0x{:02x} at {place}",
                        other.opcode()
                    );
                    problems.damage(offset, kind, text);
                }
                Err(cause) => {
                    let text = format!("the record at {place} of the unpacked chunk: {cause}");
                    problems.damage(offset, kind, text);
                }
            }
        }
        if tiles.end() < bytes.len() {
            let text = format!(
                "expected whole records, found {} bytes behind the last one",
                bytes.len() - tiles.end()
            );
            problems.damage(offset, kind, text);
        }
        let said = (self.header.message_start_time, self.header.message_end_time);
        let found = bounds.unwrap_or((0, 0));
        if said != found {
            let text = format!(
                "expected messages from {} to {} ns, found them from {} to {} ns",
                said.0, said.1, found.0, found.1
            );
            problems.damage(offset, kind, text);
        }
    }

    /// An index of messages behind the chunk.
    pub(super) fn index(
        &mut self,
        offset: u64,
        length: u64,
        index: &MessageIndex,
        problems: &mut Problems,
    ) {
        let kind = ProblemKind::Index;
        let id = index.channel_id;
        self.index_length += length;
        if self.indexes.insert(id, offset).is_some() {
            let text = format!("channel {id} has two indexes of messages behind one chunk");
            problems.damage(offset, kind, text);
        }
        if !self.unpacked {
            return;
        }
        let mut found: Vec<(u64, u64)> = index
            .records
            .iter()
            .map(|entry| (entry.log_time, entry.offset))
            .collect();
        found.sort_unstable();
        let mut expected = self.messages.get(&id).cloned().unwrap_or_default();
        expected.sort_unstable();
        if found != expected {
            let wrong = found.iter().find(|own| !expected.contains(own));
            let text = match wrong {
                Some((time, place)) => format!(
                    "index of channel {id}: no message of {time} ns at {place} of the unpacked \
                     chunk at {}",
                    self.offset
                ),
                None => format!(
                    "index of channel {id}: expected the {} messages of the chunk at {}, found {}",
                    expected.len(),
                    self.offset,
                    found.len()
                ),
            };
            problems.damage(offset, kind, text);
        }
    }

    /// What the indexes behind the chunk leave out; the messages are of no interest then.
    pub(super) fn close(&mut self, problems: &mut Problems) {
        if !self.indexes.is_empty() {
            for id in self.messages.keys() {
                if !self.indexes.contains_key(id) {
                    let text = format!(
                        "expected an index of the messages of channel {id} behind the chunk, \
                         found none"
                    );
                    problems.damage(self.offset, ProblemKind::Index, text);
                }
            }
        }
        self.messages = BTreeMap::new();
    }
}
