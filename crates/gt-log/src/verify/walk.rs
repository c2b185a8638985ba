//! The walk over a file, record by record.

use std::path::Path;

use mcap::MAGIC;
use mcap::records::{Footer, Record, op};
use sha2::{Digest, Sha256};

use super::Verification;
use super::chunk::SeenChunk;
use super::content::Content;
use super::problem::{ProblemKind, Problems};
use super::summary::Summary;
use crate::LogError;
use crate::raw::RawFile;
use crate::records::{PREFIX, parse};
use crate::source::hex;

/// What the walk has seen.
pub(super) struct Walk {
    problems: Problems,
    content: Content,
    summary: Summary,
    records: u64,
    chunks: u64,
    /// Where the data end, and their checksum.
    data_end: Option<(u64, u32)>,
    /// Where the footer stands.
    footer: Option<(u64, Footer)>,
    /// The chunk whose indexes may follow.
    current: Option<SeenChunk>,
}

impl Walk {
    pub(super) fn new(path: &Path) -> Self {
        Self {
            problems: Problems::default(),
            content: Content::new(path),
            summary: Summary::default(),
            records: 0,
            chunks: 0,
            data_end: None,
            footer: None,
            current: None,
        }
    }

    /// Walks over a whole file.
    pub(super) fn run(&mut self, file: &mut RawFile) -> Result<(), LogError> {
        let start = file.read(0, MAGIC.len() as u64)?;
        if start != MAGIC {
            let text = format!("expected the first bytes of an MCAP file, found {start:02x?}");
            self.problems.damage(0, ProblemKind::Magic, text);
            return Ok(());
        }
        let mut offset = MAGIC.len() as u64;
        while self.footer.is_none() {
            let Some((opcode, length)) = file.prefix(offset)? else {
                self.cut(offset, file.size());
                break;
            };
            let Some(body) = file.body(offset, length)? else {
                let left = file.size() - offset - (PREFIX as u64);
                let text = format!(
                    "a record of the kind 0x{opcode:02x}: expected {length} bytes, found {left} \
                     before the end of the file; `gtfdi log recover` writes what is sound"
                );
                self.problems.damage(offset, ProblemKind::Record, text);
                break;
            };
            self.record(offset, opcode, &body);
            offset += PREFIX as u64 + length;
        }
        self.close_chunk();
        if let Some((at, footer)) = self.footer {
            self.end(file, offset)?;
            let first = self.data_end.map(|(end, _)| end + PREFIX as u64 + 4);
            self.summary
                .check_footer(at, &footer, first, &mut self.problems);
            self.summary.check(&self.content, &mut self.problems);
        }
        self.content.order(&mut self.problems);
        Ok(())
    }

    fn cut(&mut self, offset: u64, size: u64) {
        let text = format!(
            "expected the end of the data and a footer, found the end of the file after {size} \
             bytes; `gtfdi log recover` writes what is sound"
        );
        self.problems.damage(offset, ProblemKind::Record, text);
    }

    fn close_chunk(&mut self) {
        if let Some(mut chunk) = self.current.take() {
            chunk.close(&mut self.problems);
            self.summary.chunks.push(chunk);
        }
    }

    fn record(&mut self, offset: u64, opcode: u8, body: &[u8]) {
        self.records += 1;
        if opcode != op::MESSAGE_INDEX {
            self.close_chunk();
        }
        let length = (PREFIX + body.len()) as u64;
        let kind = ProblemKind::Record;
        if (self.records == 1) != (opcode == op::HEADER) {
            let text = format!(
                "expected the header first and nowhere else, found a record of the kind \
                 0x{opcode:02x}"
            );
            self.problems.damage(offset, kind, text);
        }
        let record = match parse(opcode, body) {
            Ok(record) => record,
            Err(cause) => {
                let kind = match opcode {
                    op::ATTACHMENT => ProblemKind::Attachment,
                    op::CHUNK => ProblemKind::Chunk,
                    _ => kind,
                };
                let text = format!("a record of the kind 0x{opcode:02x}: {cause}");
                self.problems.damage(offset, kind, text);
                return;
            }
        };
        if self.data_end.is_some() {
            self.in_summary(offset, length, record);
        } else {
            self.in_data(offset, length, record);
        }
    }

    fn in_data(&mut self, offset: u64, length: u64, record: Record<'_>) {
        match record {
            Record::Header(_) => {}
            Record::Schema { .. } | Record::Channel(_) => {
                self.content
                    .define(offset, record, false, &mut self.problems);
            }
            Record::Message { header, data } => {
                self.content
                    .message(offset, &header, &data, &mut self.problems);
            }
            Record::Chunk { header, data } => {
                self.chunks += 1;
                let own = (header, &data[..]);
                let chunk =
                    SeenChunk::of(offset, length, own, &mut self.content, &mut self.problems);
                self.current = Some(chunk);
            }
            Record::MessageIndex(index) => match &mut self.current {
                Some(chunk) => chunk.index(offset, length, &index, &mut self.problems),
                None => self.problems.damage(
                    offset,
                    ProblemKind::Index,
                    "expected a chunk before an index of messages, found none",
                ),
            },
            Record::Attachment { header, data, .. } => {
                let size = data.len() as u64;
                self.summary
                    .attachments
                    .push((offset, length, size, header));
            }
            Record::Metadata(record) => {
                self.summary.metadata.push((offset, length, record.name));
            }
            Record::DataEnd(end) => self.data_end = Some((offset, end.data_section_crc)),
            Record::Unknown { opcode, .. } => self.unknown(offset, opcode),
            Record::Footer(footer) => {
                self.problems.damage(
                    offset,
                    ProblemKind::Record,
                    "expected the end of the data before the footer, found none",
                );
                self.footer = Some((offset, footer));
            }
            other => {
                let text = format!(
                    "expected a record of the data, found one of the kind 0x{:02x}",
                    other.opcode()
                );
                self.problems.damage(offset, ProblemKind::Record, text);
            }
        }
    }

    fn in_summary(&mut self, offset: u64, length: u64, record: Record<'_>) {
        self.summary.group(offset, length, record.opcode());
        match record {
            Record::Schema { .. } | Record::Channel(_) => {
                self.summary.repeated(&record);
                self.content
                    .define(offset, record, true, &mut self.problems);
            }
            Record::Statistics(statistics) => {
                if self
                    .summary
                    .statistics
                    .replace((offset, statistics))
                    .is_some()
                {
                    let text = "expected the statistics once, found them twice";
                    self.problems.damage(offset, ProblemKind::Statistics, text);
                }
            }
            Record::ChunkIndex(index) => self.summary.chunk_indexes.push((offset, index)),
            Record::AttachmentIndex(index) => self.summary.attachment_indexes.push((offset, index)),
            Record::MetadataIndex(index) => self.summary.metadata_indexes.push((offset, index)),
            Record::SummaryOffset(own) => self.summary.offsets.push((offset, own)),
            Record::Footer(footer) => self.footer = Some((offset, footer)),
            Record::Unknown { opcode, .. } => self.unknown(offset, opcode),
            other => {
                let text = format!(
                    "expected a record of the summary, found one of the kind 0x{:02x}",
                    other.opcode()
                );
                self.problems.damage(offset, ProblemKind::Record, text);
            }
        }
    }

    fn unknown(&mut self, offset: u64, opcode: u8) {
        let text = format!("a record of the unknown kind 0x{opcode:02x}");
        self.problems.remark(offset, ProblemKind::Record, text);
    }

    /// The last bytes of the file.
    fn end(&mut self, file: &mut RawFile, offset: u64) -> Result<(), LogError> {
        let end = file.read(offset, MAGIC.len() as u64)?;
        if end != MAGIC {
            let text = format!("expected the last bytes of an MCAP file, found {end:02x?}");
            self.problems.damage(offset, ProblemKind::Magic, text);
        }
        let after = offset + MAGIC.len() as u64;
        if file.size() > after {
            let text = format!(
                "expected the end of the file, found {} bytes",
                file.size() - after
            );
            self.problems.damage(after, ProblemKind::Magic, text);
        }
        Ok(())
    }

    /// The checksums of the data and of the summary; the SHA-256 of the whole file.
    pub(super) fn check_sums(&mut self, file: &mut RawFile) -> Result<String, LogError> {
        let data = 0..self.data_end.map_or(0, |(offset, _)| offset);
        // From the end of the data on, through the footer's two offsets.
        let summary = match (self.data_end, self.footer) {
            (Some((end, _)), Some((footer, _))) => {
                end + PREFIX as u64 + 4..footer + PREFIX as u64 + 16
            }
            _ => 0..0,
        };
        let mut sha = Sha256::new();
        let mut data_crc = crc32fast::Hasher::new();
        let mut summary_crc = crc32fast::Hasher::new();
        let mut at = 0_u64;
        let size = file.size();
        file.blocks(size, |block| {
            sha.update(block);
            data_crc.update(overlap(block, at, &data));
            summary_crc.update(overlap(block, at, &summary));
            at += block.len() as u64;
        })?;
        if let Some((offset, expected)) = self.data_end {
            self.check_crc(offset, "data", expected, data_crc.finalize());
        }
        if let (Some((offset, footer)), false) = (self.footer, summary.is_empty()) {
            let found = summary_crc.finalize();
            self.check_crc(offset, "summary", footer.summary_crc, found);
        }
        Ok(hex(&sha.finalize()))
    }

    fn check_crc(&mut self, offset: u64, what: &str, expected: u32, found: u32) {
        if expected != 0 && expected != found {
            let text = format!("the {what}: expected the CRC {expected:08x}, found {found:08x}");
            self.problems.damage(offset, ProblemKind::Checksum, text);
        }
    }

    pub(super) fn finish(mut self, path: &Path, size: u64, sha256: String) -> Verification {
        self.problems.listed.sort_by_key(|problem| problem.offset);
        Verification {
            file: path.display().to_string(),
            size_bytes: size,
            sha256,
            sound: !self.problems.damaged,
            messages: self.content.messages,
            decoded_messages: self.content.decoded,
            foreign_encodings: self.content.foreign.into_iter().collect(),
            chunks: self.chunks,
            attachments: self.summary.attachments.len() as u64,
            metadata: self.summary.metadata.len() as u64,
            summary: self.summary.is_there(),
            problems: self.problems.listed,
            more_problems: self.problems.more,
        }
    }
}

/// The bytes of a block that begins at `at` which lie in `range`.
fn overlap<'b>(block: &'b [u8], at: u64, range: &std::ops::Range<u64>) -> &'b [u8] {
    let within = |place: u64| {
        usize::try_from(place.saturating_sub(at)).map_or(block.len(), |own| own.min(block.len()))
    };
    block
        .get(within(range.start)..within(range.end))
        .unwrap_or_default()
}
