//! The second pass over a file: what is sound goes into a new one.

use std::borrow::Cow;
use std::collections::BTreeMap;
use std::path::Path;

use gt_mcap::FileWriter;
use mcap::records::{MessageHeader, Metadata, Record, op};
use mcap::{Attachment, Compression, WriteOptions};

use super::definitions::Definitions;
use super::survey::{Piece, Survey};
use super::{Loss, LossKind, RecoveredTopic, Recovery, provenance};
use crate::LogError;
use crate::atomic::Part;
use crate::chunk::unpack;
use crate::raw::{RawFile, Tiles};
use crate::records::{PREFIX, parse};
use crate::writer::write as cannot_write;

/// Messages of a channel: how many, from when, to when.
#[derive(Debug, Clone, Copy)]
struct Span {
    count: u64,
    first_ns: u64,
    last_ns: u64,
}

impl Span {
    /// Of no message yet, at the time of this one.
    fn of(header: &MessageHeader) -> Self {
        Self {
            count: 0,
            first_ns: header.log_time,
            last_ns: header.log_time,
        }
    }

    fn add(&mut self, header: &MessageHeader) {
        self.count += 1;
        self.first_ns = self.first_ns.min(header.log_time);
        self.last_ns = self.last_ns.max(header.log_time);
    }

    /// Counts a message among those of its channel.
    fn count(spans: &mut BTreeMap<u16, Self>, header: &MessageHeader) {
        let span = spans
            .entry(header.channel_id)
            .or_insert_with(|| Self::of(header));
        span.add(header);
    }
}

/// Messages that are left out: when, where the first is, how many bytes they have outside chunks, and
/// what is wrong with the first.
struct Broken {
    span: Span,
    offset: u64,
    bytes: u64,
    cause: String,
}

/// Where a record comes from.
#[derive(Debug, Clone, Copy)]
struct Place {
    offset: u64,
    /// The bytes of the file that are this record's own: none within a chunk.
    bytes: u64,
    /// Whether a checksum says that it is as it was written.
    vouched: bool,
}

struct Copy<'a> {
    out: &'a Path,
    file: &'a mut RawFile,
    writer: FileWriter,
    survey: Survey,
    definitions: Definitions,
    spans: BTreeMap<u16, Span>,
    /// Messages without a channel, by its id.
    undefined: BTreeMap<u16, Span>,
    /// Messages that do not decode and that nothing vouches for, by channel.
    broken: BTreeMap<u16, Broken>,
    /// Messages that do not decode, under a checksum that is right.
    undecoded: u64,
    metadata: Vec<String>,
    attachments: Vec<String>,
}

/// Writes what the survey found to `out`.
pub(super) fn copy(
    path: &Path,
    file: &mut RawFile,
    survey: Survey,
    out: &Path,
    sha256: String,
) -> Result<Recovery, LogError> {
    // `out.part` may be the file that is read.
    let (part, sink) = Part::create_with(out, ".recovered.part")?;
    let header = survey.header.clone();
    let options = WriteOptions::new()
        .profile(header.map_or(String::new(), |header| header.profile))
        .library(concat!("gt-log/", env!("CARGO_PKG_VERSION"), " recover"))
        .compression(Some(Compression::Zstd))
        .compression_threads(0);
    let writer = FileWriter::create(sink, options).map_err(|cause| cannot_write(out, cause))?;
    let mut copy = Copy {
        out,
        file,
        writer,
        definitions: Definitions::of(path, &survey),
        survey,
        spans: BTreeMap::new(),
        undefined: BTreeMap::new(),
        broken: BTreeMap::new(),
        undecoded: 0,
        metadata: Vec::new(),
        attachments: Vec::new(),
    };
    let pieces = std::mem::take(&mut copy.survey.pieces);
    copy.lead(&pieces)?;
    copy.definitions()?;
    for piece in &pieces {
        copy.messages(piece)?;
    }
    copy.finish(path, sha256, part, &pieces)
}

impl Copy<'_> {
    /// Metadata and attachments.
    fn lead(&mut self, pieces: &[Piece]) -> Result<(), LogError> {
        let body = |file: &mut RawFile, offset, length| -> Result<Vec<u8>, LogError> {
            Ok(file.body(offset, length)?.unwrap_or_default())
        };
        for piece in pieces {
            if let Piece::Metadata { offset, length } = *piece
                && let bytes = body(self.file, offset, length)?
                && let Ok(Record::Metadata(record)) = parse(op::METADATA, &bytes)
            {
                self.put(&record)?;
            }
        }
        for piece in pieces {
            if let Piece::Attachment { offset, length } = *piece
                && let bytes = body(self.file, offset, length)?
                && let Ok(Record::Attachment { header, data, .. }) = parse(op::ATTACHMENT, &bytes)
            {
                self.attachments.push(header.name.clone());
                let attachment = Attachment {
                    log_time: header.log_time,
                    create_time: header.create_time,
                    name: header.name,
                    media_type: header.media_type,
                    data: Cow::Borrowed(&data),
                };
                self.writer
                    .attach(&attachment)
                    .map_err(|cause| cannot_write(self.out, cause))?;
            }
        }
        Ok(())
    }

    fn put(&mut self, record: &Metadata) -> Result<(), LogError> {
        self.metadata.push(record.name.clone());
        self.writer
            .write_metadata(record)
            .map_err(|cause| cannot_write(self.out, cause))
    }

    /// Schemas and channels under the ids they have.
    fn definitions(&mut self) -> Result<(), LogError> {
        for (id, (header, data)) in &self.definitions.schemas {
            self.writer
                .add_schema_with_id(*id, &header.name, &header.encoding, data)
                .map_err(|cause| cannot_write(self.out, cause))?;
        }
        for (id, known) in &self.definitions.channels {
            let channel = &known.channel;
            self.writer
                .add_channel_with_id(
                    *id,
                    channel.schema_id,
                    &channel.topic,
                    &channel.message_encoding,
                    &channel.metadata,
                )
                .map_err(|cause| cannot_write(self.out, cause))?;
        }
        Ok(())
    }

    fn messages(&mut self, piece: &Piece) -> Result<(), LogError> {
        let (offset, length, compression, vouched) = match piece {
            Piece::Chunk {
                offset,
                length,
                compression,
                vouched,
            } => (*offset, *length, compression, *vouched),
            Piece::CutChunk {
                offset,
                length,
                compression,
            } => (*offset, *length, compression, false),
            Piece::Plain { offset, length } => return self.plain(*offset, *length),
            Piece::Attachment { .. } | Piece::Metadata { .. } => return Ok(()),
        };
        let place = Place {
            offset,
            bytes: 0,
            vouched: vouched || self.survey.vouched,
        };
        let bytes = unpack(compression, &self.file.read(offset, length)?).bytes;
        for (_, opcode, body) in Tiles::new(&bytes) {
            self.record(place, opcode, body)?;
        }
        Ok(())
    }

    /// Records outside a chunk, one at a time.
    fn plain(&mut self, mut offset: u64, length: u64) -> Result<(), LogError> {
        let end = offset + length;
        while offset < end {
            let Some((opcode, length)) = self.file.prefix(offset)? else {
                break;
            };
            let Some(body) = self.file.body(offset, length)? else {
                break;
            };
            let bytes = PREFIX as u64 + length;
            let place = Place {
                offset,
                bytes,
                vouched: self.survey.vouched,
            };
            self.record(place, opcode, &body)?;
            offset += bytes;
        }
        Ok(())
    }

    fn record(&mut self, place: Place, opcode: u8, body: &[u8]) -> Result<(), LogError> {
        if opcode != op::MESSAGE {
            return Ok(());
        }
        let Ok(Record::Message { header, data }) = parse(opcode, body) else {
            return Ok(());
        };
        let id = header.channel_id;
        let Some(known) = self.definitions.channels.get(&id) else {
            Span::count(&mut self.undefined, &header);
            return Ok(());
        };
        if let Err(cause) = known.judge.decode(&data) {
            if !place.vouched {
                let broken = self.broken.entry(id).or_insert_with(|| Broken {
                    span: Span::of(&header),
                    offset: place.offset,
                    bytes: 0,
                    cause,
                });
                broken.bytes += place.bytes;
                broken.span.add(&header);
                return Ok(());
            }
            self.undecoded += 1;
        }
        Span::count(&mut self.spans, &header);
        self.writer
            .write_message(&header, &data)
            .map_err(|cause| cannot_write(self.out, cause))
    }

    /// Puts on record what the pieces could not tell of.
    fn lose_messages(&mut self) {
        let losses = &mut self.survey.losses;
        for (id, span) in &self.undefined {
            let why = self.definitions.broken.get(id);
            let why = why.map_or("is lost".to_owned(), |cause| format!("is broken: {cause}"));
            losses.push(Loss {
                offset: 0,
                bytes: 0,
                kind: LossKind::Undefined,
                first_ns: Some(span.first_ns),
                last_ns: Some(span.last_ns),
                cause: format!(
                    "{} messages of channel {id}, whose definition {why}",
                    span.count
                ),
            });
        }
        for (id, broken) in &self.broken {
            let topic = self.definitions.channels.get(id);
            let topic = topic.map_or("", |known| known.channel.topic.as_str());
            losses.push(Loss {
                offset: broken.offset,
                bytes: broken.bytes,
                kind: LossKind::Message,
                first_ns: Some(broken.span.first_ns),
                last_ns: Some(broken.span.last_ns),
                cause: format!(
                    "{} messages of topic `{topic}` do not decode by its schema, and no checksum \
                     vouches for them; of the first: {}",
                    broken.span.count, broken.cause
                ),
            });
        }
    }

    fn finish(
        mut self,
        path: &Path,
        sha256: String,
        part: Part,
        pieces: &[Piece],
    ) -> Result<Recovery, LogError> {
        self.lose_messages();
        let size_bytes = self.file.size();
        let closed = self.survey.closed;
        let losses = std::mem::take(&mut self.survey.losses);
        let sound = closed && losses.is_empty();
        if !sound {
            let record = Metadata {
                name: "gtfdi.recovery".to_owned(),
                metadata: provenance(size_bytes, &sha256, &losses),
            };
            self.put(&record)?;
        }
        let topics = self.topics();
        let undecoded_messages = self.undecoded;
        let channels = self.definitions.channels.values();
        let undecoded_channels = channels.filter(|known| !known.described).count() as u64;
        let Self {
            mut writer,
            out,
            metadata,
            attachments,
            spans,
            ..
        } = self;
        writer.finish().map_err(|cause| cannot_write(out, cause))?;
        let file = writer
            .into_file()
            .map_err(|cause| LogError::io(out, "write", cause))?;
        part.publish(file)?;
        let whole = pieces
            .iter()
            .filter(|own| matches!(own, Piece::Chunk { .. }));
        Ok(Recovery {
            file: path.display().to_string(),
            size_bytes,
            sha256,
            out: out.display().to_string(),
            sound,
            closed,
            messages: spans.values().map(|span| span.count).sum(),
            undecoded_messages,
            undecoded_channels,
            whole_chunks: whole.count() as u64,
            cut_chunk: pieces
                .iter()
                .any(|own| matches!(own, Piece::CutChunk { .. })),
            metadata,
            attachments,
            topics,
            lost_bytes: losses.iter().map(|loss| loss.bytes).sum(),
            losses,
        })
    }

    fn topics(&self) -> Vec<RecoveredTopic> {
        let channels = self.definitions.channels.iter().map(|(id, known)| {
            let span = self.spans.get(id);
            RecoveredTopic {
                topic: known.channel.topic.clone(),
                messages: span.map_or(0, |span| span.count),
                first_ns: span.map(|span| span.first_ns),
                last_ns: span.map(|span| span.last_ns),
            }
        });
        let mut topics: Vec<RecoveredTopic> = channels.collect();
        topics.sort_by(|a, b| a.topic.cmp(&b.topic));
        topics
    }
}
