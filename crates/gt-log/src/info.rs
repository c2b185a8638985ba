//! What a log holds.

use std::collections::{BTreeMap, BTreeSet};
use std::io::BufReader;
use std::ops::ControlFlow;
use std::path::Path;

use gt_core::Signal;
use mcap::McapError;
use mcap::read::ChannelAccumulator;
use mcap::records::{ChunkHeader, MessageHeader, Record};
use serde::Serialize;

use crate::LogError;
use crate::fields::Survey as FieldSurvey;
use crate::records::scan;
use crate::source::{self, Hashing};

/// What a log holds.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct LogInfo {
    /// The file as it was named.
    pub file: String,
    /// Its size in bytes.
    pub size_bytes: u64,
    /// Its SHA-256 in hexadecimal digits.
    pub sha256: String,
    /// The MCAP profile.
    pub profile: String,
    /// The library that wrote it.
    pub library: String,
    /// The number of messages.
    pub messages: u64,
    /// The earliest log time in nanoseconds since 1970.
    pub first_ns: Option<u64>,
    /// The latest log time in nanoseconds since 1970.
    pub last_ns: Option<u64>,
    /// From the earliest to the latest log time, in seconds.
    pub duration_s: f64,
    /// The chunks.
    pub chunks: ChunkInfo,
    /// The topics, by name.
    pub topics: Vec<TopicInfo>,
    /// The metadata records, in the order of the file.
    pub metadata: Vec<MetadataInfo>,
    /// The attachments, in the order of the file.
    pub attachments: Vec<AttachmentInfo>,
}

/// The chunks of a log.
#[derive(Debug, Clone, Default, PartialEq, Eq, Serialize)]
pub struct ChunkInfo {
    /// How many there are.
    pub count: u64,
    /// Their compressions: `zstd`, `lz4` or `none`.
    pub compressions: BTreeSet<String>,
    /// Their bytes as stored.
    pub compressed_bytes: u64,
    /// Their bytes when unpacked, as the file says.
    pub uncompressed_bytes: u64,
}

/// A topic of a log.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct TopicInfo {
    /// The topic.
    pub topic: String,
    /// The name of its schema; empty without one.
    pub schema: String,
    /// The encoding of its messages.
    pub encoding: String,
    /// How many messages there are.
    pub messages: u64,
    /// Its numeric fields with their units, where it is Protobuf or JSON.
    pub fields: Vec<Signal>,
    /// Its earliest log time, in seconds since the log's earliest.
    pub first_s: Option<f64>,
    /// Its latest log time, in seconds since the log's earliest.
    pub last_s: Option<f64>,
}

/// A metadata record.
#[derive(Debug, Clone, PartialEq, Eq, Serialize)]
pub struct MetadataInfo {
    /// Its name.
    pub name: String,
    /// Its values.
    pub values: BTreeMap<String, String>,
}

/// An attachment.
#[derive(Debug, Clone, PartialEq, Eq, Serialize)]
pub struct AttachmentInfo {
    /// Its name.
    pub name: String,
    /// Its media type.
    pub media_type: String,
    /// Its size in bytes.
    pub size_bytes: u64,
}

/// Messages of a channel: how many, from when, to when.
#[derive(Debug, Clone, Copy, Default)]
struct Span {
    count: u64,
    bounds_ns: Option<(u64, u64)>,
}

impl Span {
    fn add(&mut self, time_ns: u64) {
        self.count += 1;
        self.join((time_ns, time_ns));
    }

    fn join(&mut self, (first, last): (u64, u64)) {
        self.bounds_ns = Some(match self.bounds_ns {
            Some((earliest, latest)) => (earliest.min(first), latest.max(last)),
            None => (first, last),
        });
    }
}

#[derive(Default)]
struct Survey {
    profile: String,
    library: String,
    chunks: ChunkInfo,
    metadata: Vec<MetadataInfo>,
    attachments: Vec<AttachmentInfo>,
    known: ChannelAccumulator<'static>,
    spans: BTreeMap<u16, Span>,
    fields: BTreeMap<u16, FieldSurvey>,
}

impl Survey {
    fn add(&mut self, path: &Path, record: Record<'_>) -> Result<(), McapError> {
        match record {
            Record::Header(header) => {
                (self.profile, self.library) = (header.profile, header.library);
            }
            Record::Chunk { header, .. } => self.add_chunk(header),
            Record::Schema { header, data } => self.known.add_schema_from_slice(header, &data)?,
            Record::Channel(channel) => {
                let id = channel.id;
                self.spans.entry(id).or_default();
                self.known.add_channel(channel)?;
                if let (Some(channel), false) = (self.known.get(id), self.fields.contains_key(&id))
                    && let Ok(fields) = FieldSurvey::of(path, &channel)
                {
                    self.fields.insert(id, fields);
                }
            }
            Record::Message { header, data } => {
                if let Some(fields) = self.fields.get_mut(&header.channel_id) {
                    fields.add(&data);
                }
                self.add_message(header)?;
            }
            Record::Metadata(metadata) => self.metadata.push(MetadataInfo {
                name: metadata.name,
                values: metadata.metadata,
            }),
            Record::Attachment { header, data, .. } => self.attachments.push(AttachmentInfo {
                name: header.name,
                media_type: header.media_type,
                size_bytes: data.len() as u64,
            }),
            _ => {}
        }
        Ok(())
    }

    fn add_chunk(&mut self, header: ChunkHeader) {
        let name = header.compression;
        self.chunks.count += 1;
        self.chunks.compressions.insert(if name.is_empty() {
            "none".to_owned()
        } else {
            name
        });
        let add = |sum: &mut u64, size| *sum = sum.saturating_add(size);
        add(&mut self.chunks.compressed_bytes, header.compressed_size);
        add(
            &mut self.chunks.uncompressed_bytes,
            header.uncompressed_size,
        );
    }

    fn add_message(&mut self, header: MessageHeader) -> Result<(), McapError> {
        let unknown = || McapError::UnknownChannel(header.sequence, header.channel_id);
        self.spans
            .get_mut(&header.channel_id)
            .ok_or_else(unknown)?
            .add(header.log_time);
        Ok(())
    }

    fn topics(&mut self, first_ns: u64) -> Vec<TopicInfo> {
        let mut surveys = std::mem::take(&mut self.fields);
        let topic = |(&id, span): (&u16, &Span)| {
            let channel = self.known.get(id)?;
            let fields = surveys.remove(&id).map(FieldSurvey::fields);
            let since_first_s = |time_ns: u64| (time_ns - first_ns) as f64 / 1e9;
            Some(TopicInfo {
                topic: channel.topic.clone(),
                schema: channel
                    .schema
                    .as_ref()
                    .map_or(String::new(), |s| s.name.clone()),
                encoding: channel.message_encoding.clone(),
                messages: span.count,
                fields: fields.map_or(Vec::new(), |fields| fields.signals),
                first_s: span.bounds_ns.map(|(first, _)| since_first_s(first)),
                last_s: span.bounds_ns.map(|(_, last)| since_first_s(last)),
            })
        };
        let mut topics: Vec<TopicInfo> = self.spans.iter().filter_map(topic).collect();
        topics.sort_by(|a, b| a.topic.cmp(&b.topic));
        topics
    }
}

/// Reads a whole MCAP log, verifies its checksums and says what it holds.
///
/// # Errors
/// A missing or broken file.
pub fn info(path: &Path) -> Result<LogInfo, LogError> {
    let (file, size_bytes) = source::open(path)?;
    let mut source = Hashing::new(BufReader::with_capacity(1 << 16, file));
    let mut survey = Survey::default();
    scan(path, &mut source, size_bytes, |record| {
        survey
            .add(path, record)
            .map(ControlFlow::Continue)
            .map_err(|cause| LogError::Corrupt {
                path: path.to_owned(),
                cause,
            })
    })?;
    let sha256 = source
        .finish()
        .map_err(|cause| LogError::io(path, "read", cause))?;

    let mut all = Span::default();
    for span in survey.spans.values() {
        all.count += span.count;
        if let Some(bounds) = span.bounds_ns {
            all.join(bounds);
        }
    }
    let (first_ns, last_ns) = all.bounds_ns.unzip();
    let topics = survey.topics(first_ns.unwrap_or(0));
    Ok(LogInfo {
        file: path.display().to_string(),
        size_bytes,
        sha256,
        profile: survey.profile,
        library: survey.library,
        messages: all.count,
        first_ns,
        last_ns,
        duration_s: all
            .bounds_ns
            .map_or(0.0, |(first, last)| (last - first) as f64 / 1e9),
        chunks: survey.chunks,
        topics,
        metadata: survey.metadata,
        attachments: survey.attachments,
    })
}
