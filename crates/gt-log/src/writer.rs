//! Writing logs.

use std::borrow::Cow;
use std::collections::{BTreeMap, HashSet};
use std::path::Path;

use gt_core::Signal;
use gt_mcap::{FileWriter, Layout};
use mcap::records::{MessageHeader, Metadata};
use mcap::{Attachment, Compression, McapError, WriteOptions};
use serde::Serialize;

use crate::atomic::Part;
use crate::error::is_full;
use crate::model_log::LoggedModel;
use crate::quality::Quality;
use crate::schema::{FieldKind, MessageSchema, TAGS_KEY, UNITS_KEY, is_message_name};
use crate::{EPOCH_NS, LogError, build_info, sha256_hex};

/// The version of what logs hold; it rises when a reader of the one before would misread them.
pub(crate) const LOG_VERSION: u64 = 1;
/// The metadata record of the run.
pub(crate) const RUN_RECORD: &str = "gtfdi.run";
/// Its key with [`LOG_VERSION`]; a log without it is of version 1.
pub(crate) const VERSION_KEY: &str = "log_version";

/// What a log says of the run that wrote it, in metadata records before everything else, so that
/// a log that is cut off still has it.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct RunMetadata {
    /// The seed of a simulated run.
    pub seed: Option<u64>,
    /// Which run of a campaign this is.
    pub run_index: Option<u64>,
    /// The whole configuration, as TOML.
    pub config_toml: String,
    /// The SHA-256 of the input data, where there were any.
    pub data_sha256: Option<String>,
    /// What was remarked on the run, for `/log`.
    pub warnings: Vec<String>,
    /// The models behind what is in the log, for `/ident/model`; each is attached.
    pub models: Vec<LoggedModel>,
    /// How good the samples of each channel are, inputs first, for `/plant/quality`; where nothing is
    /// said of a sample, it is good if it is finite. A value that is not is bad in any case.
    pub qualities: Vec<Vec<Quality>>,
}

impl RunMetadata {
    /// `gtfdi.run`, `gtfdi.config` and, with input data, `gtfdi.data`.
    fn records(&self) -> Vec<Metadata> {
        let build = build_info();
        let mut run = BTreeMap::from([
            (VERSION_KEY.to_owned(), LOG_VERSION.to_string()),
            ("version".to_owned(), build.version.to_owned()),
            ("git".to_owned(), build.git.to_owned()),
            ("rustc".to_owned(), build.rustc.to_owned()),
            (
                "config_sha256".to_owned(),
                sha256_hex(self.config_toml.as_bytes()),
            ),
        ]);
        for (key, value) in [("seed", self.seed), ("run_index", self.run_index)] {
            if let Some(value) = value {
                run.insert(key.to_owned(), value.to_string());
            }
        }
        let record = |name: &str, metadata| Metadata {
            name: name.to_owned(),
            metadata,
        };
        let config = BTreeMap::from([("toml".to_owned(), self.config_toml.clone())]);
        let mut records = vec![record(RUN_RECORD, run), record("gtfdi.config", config)];
        if let Some(sha256) = &self.data_sha256 {
            let data = BTreeMap::from([("input_sha256".to_owned(), sha256.clone())]);
            records.push(record("gtfdi.data", data));
        }
        records
    }
}

/// What the chunks of a log are packed with.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum LogCompression {
    /// Nothing: fastest to write.
    None,
    /// LZ4: little smaller on readings of sensors, and quick.
    Lz4,
    /// Zstandard: the smallest.
    #[default]
    Zstd,
}

/// A topic of doubles, for [`LogWriter::write`].
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub struct TopicId(usize);

/// A topic of qualities, for [`LogWriter::write_quality`].
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub struct QualityTopicId(usize);

/// A topic of JSON, for [`LogWriter::write_json`].
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub struct JsonTopicId(usize);

#[derive(Debug)]
struct Topic {
    name: String,
    channel_id: u16,
    /// Of no field for a topic of JSON.
    layout: Layout,
    sequence: u32,
}

/// Writes an MCAP log: profile "", zstd unless asked otherwise, Protobuf messages of `optional double` fields.
///
/// The file is `NAME.part` until [`LogWriter::finish`]; dropped before that, it is removed. No
/// path, clock or number of threads enters the bytes: the same calls give the same file. That
/// holds as long as [`LogWriter::flush`], which closes a chunk, is not called by the clock.
///
/// Call in this order: [`LogWriter::create`], [`LogWriter::attach`] (so that a log that is cut off
/// keeps its models), [`LogWriter::add_topic`], [`LogWriter::write`], [`LogWriter::finish`].
pub struct LogWriter {
    // Dropped before `part`, which removes the file it writes to.
    inner: FileWriter,
    part: Part,
    topics: Vec<Topic>,
    buffer: Vec<u8>,
}

impl LogWriter {
    /// Opens `path.part` and writes the metadata records of the run.
    ///
    /// # Errors
    /// [`LogError::Io`], [`LogError::Directory`] or [`LogError::Write`].
    pub fn create(path: &Path, run: &RunMetadata) -> Result<Self, LogError> {
        Self::create_with(path, run, LogCompression::default())
    }

    /// As [`LogWriter::create`], with another compression.
    ///
    /// # Errors
    /// As [`LogWriter::create`].
    pub fn create_with(
        path: &Path,
        run: &RunMetadata,
        compression: LogCompression,
    ) -> Result<Self, LogError> {
        let (part, file) = Part::create(path)?;
        let options = WriteOptions::new()
            .profile("")
            .library(concat!("gt-log/", env!("CARGO_PKG_VERSION")))
            .compression(match compression {
                LogCompression::None => None,
                LogCompression::Lz4 => Some(Compression::Lz4),
                LogCompression::Zstd => Some(Compression::Zstd),
            })
            // Other counts would make the bytes depend on the machine.
            .compression_threads(0)
            // The Python reader that seeks fails without them.
            .repeat_schemas(true)
            .repeat_channels(true);
        let inner = FileWriter::create(file, options).map_err(|cause| write(path, cause))?;
        let mut writer = Self {
            inner,
            part,
            topics: Vec::new(),
            buffer: Vec::new(),
        };
        for record in run.records() {
            writer
                .inner
                .write_metadata(&record)
                .map_err(|cause| write(path, cause))?;
        }
        Ok(writer)
    }

    /// Adds a metadata record; it belongs before the attachments.
    ///
    /// # Errors
    /// [`LogError::Write`].
    pub(crate) fn note(
        &mut self,
        name: &str,
        values: BTreeMap<String, String>,
    ) -> Result<(), LogError> {
        let record = Metadata {
            name: name.to_owned(),
            metadata: values,
        };
        self.inner
            .write_metadata(&record)
            .map_err(|cause| write(self.part.target(), cause))
    }

    /// Adds an attachment, such as `models/<id>.json` (`application/json`) or `config.toml`
    /// (`application/toml`). Its times are [`EPOCH_NS`].
    ///
    /// # Errors
    /// [`LogError::Write`].
    pub fn attach(&mut self, name: &str, media_type: &str, bytes: &[u8]) -> Result<(), LogError> {
        let attachment = Attachment {
            log_time: EPOCH_NS,
            create_time: EPOCH_NS,
            name: name.to_owned(),
            media_type: media_type.to_owned(),
            data: Cow::Borrowed(bytes),
        };
        self.inner
            .attach(&attachment)
            .map_err(|cause| write(self.part.target(), cause))
    }

    /// Adds a topic whose messages have a double for each of `fields`.
    ///
    /// `message` is the name of the Protobuf message in `gtfdi.v1`, such as `Measured`. Fields are
    /// named after the tags where Protobuf allows (`TI-101.PV` becomes `TI_101_PV`); the channel's
    /// metadata hold the tags (`tags`) and units (`units`), each a JSON map by field name, and
    /// `asset` and `sample_period_s`.
    ///
    /// # Errors
    /// [`LogError::DuplicateTopic`], [`LogError::MessageName`], [`LogError::DuplicateField`],
    /// [`LogError::SampleTime`] or [`LogError::Write`].
    pub fn add_topic(
        &mut self,
        topic: &str,
        message: &str,
        fields: &[Signal],
        sample_period_s: f64,
        asset: &str,
    ) -> Result<TopicId, LogError> {
        let number = self.add_fields(
            (topic, message, FieldKind::Double),
            fields,
            sample_period_s,
            asset,
        )?;
        Ok(TopicId(number))
    }

    /// Adds a topic whose messages say of each of `fields` how good its sample is.
    ///
    /// # Errors
    /// As [`LogWriter::add_topic`].
    pub fn add_quality_topic(
        &mut self,
        topic: &str,
        fields: &[Signal],
        sample_period_s: f64,
        asset: &str,
    ) -> Result<QualityTopicId, LogError> {
        let kind = FieldKind::Enumeration("SampleQuality", Quality::NAMES);
        let number = self.add_fields((topic, "Quality", kind), fields, sample_period_s, asset)?;
        Ok(QualityTopicId(number))
    }

    /// Adds a topic with a field of one kind for each signal.
    fn add_fields(
        &mut self,
        (topic, message, kind): (&str, &str, FieldKind),
        fields: &[Signal],
        sample_period_s: f64,
        asset: &str,
    ) -> Result<usize, LogError> {
        self.check_new(topic, message)?;
        if !(sample_period_s.is_finite() && sample_period_s > 0.0) {
            return Err(LogError::SampleTime {
                found: sample_period_s,
            });
        }
        let mut seen = HashSet::new();
        if let Some(twice) = fields
            .iter()
            .find(|field| !seen.insert(field.name.as_str()))
        {
            let (topic, field) = (topic.to_owned(), twice.name.clone());
            return Err(LogError::DuplicateField { topic, field });
        }
        let tags: Vec<&str> = fields.iter().map(|field| field.name.as_str()).collect();
        let schema = MessageSchema::new(message, &tags, kind);
        let by_name = |value: fn(&Signal) -> &String| -> String {
            let pairs = schema.names.iter().zip(fields);
            let map: serde_json::Map<String, serde_json::Value> = pairs
                .map(|(name, field)| (name.clone(), value(field).as_str().into()))
                .collect();
            serde_json::Value::Object(map).to_string()
        };
        let metadata = BTreeMap::from([
            (TAGS_KEY.to_owned(), by_name(|field| &field.name)),
            (UNITS_KEY.to_owned(), by_name(|field| &field.unit)),
            ("asset".to_owned(), asset.to_owned()),
            ("sample_period_s".to_owned(), sample_period_s.to_string()),
        ]);
        let channel_id = self.add_channel(
            topic,
            ("protobuf", &schema.full_name, &schema.descriptor),
            "protobuf",
            &metadata,
        )?;
        Ok(self.push(topic, channel_id, Layout::new(schema.numbers)))
    }

    /// Adds a topic of JSON messages, for what is rare and rich in text (`/fdi/diagnosis`,
    /// `/alarms`). `json_schema` is the JSON Schema of a message; `message` its name in `gtfdi.v1`.
    ///
    /// # Errors
    /// [`LogError::DuplicateTopic`], [`LogError::MessageName`] or [`LogError::Write`].
    pub fn add_json_topic(
        &mut self,
        topic: &str,
        message: &str,
        json_schema: &serde_json::Value,
        asset: &str,
    ) -> Result<JsonTopicId, LogError> {
        self.check_new(topic, message)?;
        let name = format!("{}.{message}", crate::schema::PACKAGE);
        self.add_json_schema(topic, &name, json_schema, asset)
    }

    /// Adds a topic of JSON messages with the full name of their schema.
    pub(crate) fn add_json_schema(
        &mut self,
        topic: &str,
        name: &str,
        json_schema: &serde_json::Value,
        asset: &str,
    ) -> Result<JsonTopicId, LogError> {
        let metadata = BTreeMap::from([("asset".to_owned(), asset.to_owned())]);
        let text = json_schema.to_string();
        let channel_id = self.add_channel(
            topic,
            ("jsonschema", name, text.as_bytes()),
            "json",
            &metadata,
        )?;
        Ok(JsonTopicId(self.push(topic, channel_id, Layout::default())))
    }

    /// Writes a message with a value for each field; NaN says that the sensor gave nothing valid.
    ///
    /// Log time and publish time are `time_ns`, nanoseconds since 1970 (see
    /// [`sample_time_ns`](crate::sample_time_ns)); the sequence counts the topic's messages.
    ///
    /// # Errors
    /// [`LogError::FieldCount`], [`LogError::ForeignTopic`] or [`LogError::Write`].
    pub fn write(&mut self, topic: TopicId, time_ns: u64, values: &[f64]) -> Result<(), LogError> {
        let known = self.known(topic.0, values.len())?;
        self.topics[known].layout.encode(values, &mut self.buffer);
        self.send(known, time_ns)
    }

    /// Writes a message that leaves out the fields without a value: nothing came from the sensor.
    ///
    /// # Errors
    /// As [`LogWriter::write`].
    pub fn write_partial(
        &mut self,
        topic: TopicId,
        time_ns: u64,
        values: &[Option<f64>],
    ) -> Result<(), LogError> {
        let known = self.known(topic.0, values.len())?;
        let layout = &self.topics[known].layout;
        layout.encode_present(values, &mut self.buffer);
        self.send(known, time_ns)
    }

    /// Writes how good the sample of each field is.
    ///
    /// # Errors
    /// As [`LogWriter::write`].
    pub fn write_quality(
        &mut self,
        topic: QualityTopicId,
        time_ns: u64,
        qualities: &[Quality],
    ) -> Result<(), LogError> {
        let known = self.known(topic.0, qualities.len())?;
        let values = qualities.iter().map(|own| own.number());
        let layout = &self.topics[known].layout;
        layout.encode_enumeration(values, &mut self.buffer);
        self.send(known, time_ns)
    }

    /// Writes a JSON message.
    ///
    /// # Errors
    /// [`LogError::NotJson`], [`LogError::ForeignTopic`] or [`LogError::Write`].
    pub fn write_json<T: Serialize + ?Sized>(
        &mut self,
        topic: JsonTopicId,
        time_ns: u64,
        value: &T,
    ) -> Result<(), LogError> {
        self.buffer.clear();
        serde_json::to_writer(&mut self.buffer, value).map_err(|cause| LogError::NotJson {
            path: self.part.target().to_owned(),
            cause: cause.to_string(),
        })?;
        self.send(topic.0, time_ns)
    }

    /// Closes the chunk, hands it to the operating system and waits for the disk, so that a crash
    /// loses nothing before this call. For live logs: every call makes a chunk, and chunks by the
    /// clock make bytes that depend on it.
    ///
    /// # Errors
    /// [`LogError::Write`] or [`LogError::Io`].
    pub fn flush(&mut self) -> Result<(), LogError> {
        self.inner
            .flush()
            .map_err(|cause| write(self.part.target(), cause))?;
        self.part.sync()
    }

    /// Writes the summary, waits for the disk and gives the file its name.
    ///
    /// # Errors
    /// [`LogError::Write`] or [`LogError::Io`]; there is then no file.
    pub fn finish(mut self) -> Result<(), LogError> {
        self.inner
            .finish()
            .map_err(|cause| write(self.part.target(), cause))?;
        let Self { inner, part, .. } = self;
        let file = inner
            .into_file()
            .map_err(|cause| LogError::io(part.target(), "write", cause))?;
        part.publish(file)
    }

    /// The file's final name.
    pub(crate) fn path(&self) -> &Path {
        self.part.target()
    }

    /// The bytes that are in the file so far.
    pub(crate) fn size(&self) -> Result<u64, LogError> {
        self.part.size()
    }

    /// Ends the work and leaves the file as `NAME.part`.
    pub(crate) fn abandon(mut self) {
        self.part.keep();
    }

    /// As [`LogWriter::finish`], but where that fails the file stays as `NAME.part`.
    pub(crate) fn finish_or_keep(mut self) -> Result<(), LogError> {
        self.part.keep();
        self.finish()
    }

    fn check_new(&self, topic: &str, message: &str) -> Result<(), LogError> {
        if !is_message_name(message) {
            return Err(LogError::MessageName {
                found: message.to_owned(),
            });
        }
        if self.topics.iter().any(|known| known.name == topic) {
            return Err(LogError::DuplicateTopic {
                topic: topic.to_owned(),
            });
        }
        Ok(())
    }

    fn add_channel(
        &mut self,
        topic: &str,
        (schema_encoding, schema_name, schema): (&str, &str, &[u8]),
        message_encoding: &str,
        metadata: &BTreeMap<String, String>,
    ) -> Result<u16, LogError> {
        self.inner
            .add_schema(schema_name, schema_encoding, schema)
            .and_then(|id| {
                self.inner
                    .add_channel(id, topic, message_encoding, metadata)
            })
            .map_err(|cause| write(self.part.target(), cause))
    }

    fn push(&mut self, topic: &str, channel_id: u16, layout: Layout) -> usize {
        self.topics.push(Topic {
            name: topic.to_owned(),
            channel_id,
            layout,
            sequence: 0,
        });
        self.topics.len() - 1
    }

    /// The number of a topic that is there and has as many fields.
    fn known(&self, topic: usize, count: usize) -> Result<usize, LogError> {
        let known = self.topics.get(topic).ok_or(LogError::ForeignTopic {
            expected: self.topics.len(),
            found: topic,
        })?;
        if known.layout.len() == count {
            return Ok(topic);
        }
        Err(LogError::FieldCount {
            topic: known.name.clone(),
            expected: known.layout.len(),
            found: count,
        })
    }

    /// Writes the buffer as a message.
    fn send(&mut self, topic: usize, time_ns: u64) -> Result<(), LogError> {
        let expected = self.topics.len();
        let known = self.topics.get_mut(topic).ok_or(LogError::ForeignTopic {
            expected,
            found: topic,
        })?;
        let header = MessageHeader {
            channel_id: known.channel_id,
            sequence: known.sequence,
            log_time: time_ns,
            publish_time: time_ns,
        };
        known.sequence = known.sequence.wrapping_add(1);
        self.inner
            .write_message(&header, &self.buffer)
            .map_err(|cause| write(self.part.target(), cause))
    }
}

pub(crate) fn write(path: &Path, cause: McapError) -> LogError {
    match cause {
        McapError::Io(cause) if is_full(&cause) => LogError::NoSpace {
            path: path.to_owned(),
            action: "write",
        },
        cause => LogError::Write {
            path: path.to_owned(),
            cause,
        },
    }
}
