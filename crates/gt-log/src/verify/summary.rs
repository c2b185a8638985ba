//! What the summary says, and what there is.

use std::collections::BTreeSet;

use mcap::records::{
    AttachmentHeader, AttachmentIndex, ChunkIndex, Footer, MetadataIndex, Record, Statistics,
    SummaryOffset, op,
};

use super::chunk::SeenChunk;
use super::content::Content;
use super::problem::{ProblemKind, Problems};

/// The records that the summary speaks of, and the summary.
#[derive(Default)]
pub(super) struct Summary {
    pub(super) chunks: Vec<SeenChunk>,
    /// Offset and length of the record, size of the data.
    pub(super) attachments: Vec<(u64, u64, u64, AttachmentHeader)>,
    /// Offset and length of the record, name.
    pub(super) metadata: Vec<(u64, u64, String)>,
    pub(super) statistics: Option<(u64, Statistics)>,
    pub(super) chunk_indexes: Vec<(u64, ChunkIndex)>,
    pub(super) attachment_indexes: Vec<(u64, AttachmentIndex)>,
    pub(super) metadata_indexes: Vec<(u64, MetadataIndex)>,
    pub(super) offsets: Vec<(u64, SummaryOffset)>,
    schemas: BTreeSet<u16>,
    channels: BTreeSet<u16>,
    /// Records of one kind in a row: opcode, offset, length.
    groups: Vec<(u8, u64, u64)>,
}

impl Summary {
    pub(super) fn is_there(&self) -> bool {
        self.groups.iter().any(|own| own.0 != op::FOOTER)
    }

    pub(super) fn group(&mut self, offset: u64, length: u64, opcode: u8) {
        match self.groups.last_mut() {
            Some((own, _, whole)) if *own == opcode => *whole += length,
            _ => self.groups.push((opcode, offset, length)),
        }
    }

    /// A schema or channel that the summary repeats.
    pub(super) fn repeated(&mut self, record: &Record<'_>) {
        match record {
            Record::Schema { header, .. } => drop(self.schemas.insert(header.id)),
            Record::Channel(channel) => drop(self.channels.insert(channel.id)),
            _ => {}
        }
    }

    /// The offsets of the footer, where the summary begins at `first`.
    pub(super) fn check_footer(
        &self,
        at: u64,
        footer: &Footer,
        first: Option<u64>,
        problems: &mut Problems,
    ) {
        let starts = |opcode: u8| self.groups.iter().find(|own| own.0 == opcode);
        let summary = match self.groups.first() {
            Some((op::FOOTER, ..)) | None => 0,
            Some((_, offset, _)) => *offset,
        };
        let offsets = starts(op::SUMMARY_OFFSET).map_or(0, |own| own.1);
        // A summary of nothing may be said to begin where it would.
        let nothing = summary == 0 && Some(footer.summary_start) == first;
        if footer.summary_start != summary && !nothing {
            let text = format!(
                "footer: expected the summary at {summary}, found {}",
                footer.summary_start
            );
            problems.damage(at, ProblemKind::Index, text);
        }
        if footer.summary_offset_start != offsets
            && !(offsets == 0 && footer.summary_offset_start == at)
        {
            let text = format!(
                "footer: expected the offsets of the summary at {offsets}, found {}",
                footer.summary_offset_start
            );
            problems.damage(at, ProblemKind::Index, text);
        }
        for (offset, own) in &self.offsets {
            let said = (own.group_opcode, own.group_start, own.group_length);
            // Some writers also point at the groups of which there is none.
            let nothing = own.group_length == 0 && starts(own.group_opcode).is_none();
            if !nothing && !self.groups.contains(&said) {
                let text = format!(
                    "no {} bytes of records of the kind 0x{:02x} at {}",
                    own.group_length, own.group_opcode, own.group_start
                );
                problems.damage(*offset, ProblemKind::Index, text);
            }
        }
    }

    /// Everything else.
    pub(super) fn check(&self, content: &Content, problems: &mut Problems) {
        self.check_chunks(problems);
        self.check_attachments(problems);
        self.check_metadata(problems);
        if let Some((offset, statistics)) = &self.statistics {
            // What could not be unpacked is counted by nobody.
            if self.chunks.iter().all(|chunk| chunk.unpacked) {
                self.check_statistics(*offset, statistics, content, problems);
            }
        }
        let kind = ProblemKind::Index;
        if !self.schemas.is_empty() {
            for id in content
                .schemas
                .keys()
                .filter(|id| !self.schemas.contains(id))
            {
                problems.damage(0, kind, format!("the summary leaves schema {id} out"));
            }
        }
        if !self.channels.is_empty() && self.channels.len() < content.channel_count() {
            let (own, all) = (self.channels.len(), content.channel_count());
            problems.damage(0, kind, format!("the summary has {own} of {all} channels"));
        }
    }

    fn check_chunks(&self, problems: &mut Problems) {
        let kind = ProblemKind::Index;
        let mut seen = BTreeSet::new();
        for (offset, index) in &self.chunk_indexes {
            let at = index.chunk_start_offset;
            let found = self.chunks.binary_search_by_key(&at, |chunk| chunk.offset);
            let Some(chunk) = found.ok().map(|place| &self.chunks[place]) else {
                problems.damage(*offset, kind, format!("index of a chunk: no chunk at {at}"));
                continue;
            };
            seen.insert(at);
            let header = &chunk.header;
            let pairs = [
                ("length", index.chunk_length, chunk.length),
                (
                    "first time",
                    index.message_start_time,
                    header.message_start_time,
                ),
                ("last time", index.message_end_time, header.message_end_time),
                ("packed size", index.compressed_size, header.compressed_size),
                ("size", index.uncompressed_size, header.uncompressed_size),
                (
                    "length of the indexes",
                    index.message_index_length,
                    chunk.index_length,
                ),
            ];
            for (what, said, found) in pairs {
                if said != found {
                    let text = format!(
                        "index of the chunk at {at}: expected the {what} {said}, found {found}"
                    );
                    problems.damage(*offset, kind, text);
                }
            }
            if index.compression != header.compression {
                let (said, found) = (&index.compression, &header.compression);
                let text = format!(
                    "index of the chunk at {at}: expected the compression `{said}`, found `{found}`"
                );
                problems.damage(*offset, kind, text);
            }
            if index.message_index_offsets != chunk.indexes {
                let text = format!(
                    "index of the chunk at {at}: expected indexes of messages at {:?} by channel, \
                     found {:?}",
                    index.message_index_offsets, chunk.indexes
                );
                problems.damage(*offset, kind, text);
            }
        }
        let left = self.chunks.iter().filter(|own| !seen.contains(&own.offset));
        leaves_out(
            &self.chunk_indexes,
            left.map(|own| own.offset),
            "chunk",
            problems,
        );
    }

    fn check_attachments(&self, problems: &mut Problems) {
        let mut seen = BTreeSet::new();
        for (offset, index) in &self.attachment_indexes {
            let found = self
                .attachments
                .binary_search_by_key(&index.offset, |own| own.0);
            let own = found.is_ok_and(|place| {
                let (_, length, size, header) = &self.attachments[place];
                (*length, *size) == (index.length, index.data_size)
                    && header.log_time == index.log_time
                    && header.create_time == index.create_time
                    && header.name == index.name
                    && header.media_type == index.media_type
            });
            seen.insert(index.offset);
            if !own {
                let text = format!(
                    "index of the attachment `{}`: no such attachment of {} bytes at {}",
                    index.name, index.data_size, index.offset
                );
                problems.damage(*offset, ProblemKind::Index, text);
            }
        }
        let left = self.attachments.iter().filter(|own| !seen.contains(&own.0));
        leaves_out(
            &self.attachment_indexes,
            left.map(|own| own.0),
            "attachment",
            problems,
        );
    }

    fn check_metadata(&self, problems: &mut Problems) {
        let mut seen = BTreeSet::new();
        for (offset, index) in &self.metadata_indexes {
            seen.insert(index.offset);
            let found = self
                .metadata
                .binary_search_by_key(&index.offset, |own| own.0);
            let own = found.is_ok_and(|place| {
                let (_, length, name) = &self.metadata[place];
                (*length, name) == (index.length, &index.name)
            });
            if !own {
                let text = format!(
                    "index of the metadata `{}`: no such record of {} bytes at {}",
                    index.name, index.length, index.offset
                );
                problems.damage(*offset, ProblemKind::Index, text);
            }
        }
        let left = self.metadata.iter().filter(|own| !seen.contains(&own.0));
        leaves_out(
            &self.metadata_indexes,
            left.map(|own| own.0),
            "metadata record",
            problems,
        );
    }

    fn check_statistics(
        &self,
        offset: u64,
        statistics: &Statistics,
        content: &Content,
        problems: &mut Problems,
    ) {
        let bounds = content.bounds.unwrap_or((0, 0));
        let pairs = [
            ("messages", statistics.message_count, content.messages),
            (
                "schemas",
                statistics.schema_count.into(),
                content.schemas.len() as u64,
            ),
            (
                "channels",
                statistics.channel_count.into(),
                content.channel_count() as u64,
            ),
            (
                "attachments",
                statistics.attachment_count.into(),
                self.attachments.len() as u64,
            ),
            (
                "metadata records",
                statistics.metadata_count.into(),
                self.metadata.len() as u64,
            ),
            (
                "chunks",
                statistics.chunk_count.into(),
                self.chunks.len() as u64,
            ),
            (
                "ns as the first time",
                statistics.message_start_time,
                bounds.0,
            ),
            ("ns as the last time", statistics.message_end_time, bounds.1),
        ];
        for (what, said, found) in pairs {
            if said != found {
                let text = format!("statistics: expected {said} {what}, found {found}");
                problems.damage(offset, ProblemKind::Statistics, text);
            }
        }
        let mut said = statistics.channel_message_counts.clone();
        said.retain(|_, count| *count > 0);
        let found = content.counts();
        if said != found {
            let text =
                format!("statistics: expected {said:?} messages by channel, found {found:?}");
            problems.damage(offset, ProblemKind::Statistics, text);
        }
    }
}

/// What indexes leave out, where there are any.
fn leaves_out<T>(
    indexes: &[T],
    left: impl Iterator<Item = u64>,
    what: &str,
    problems: &mut Problems,
) {
    if indexes.is_empty() {
        return;
    }
    for offset in left {
        let text = format!("the summary has no index of this {what}, but of others");
        problems.damage(offset, ProblemKind::Index, text);
    }
}
