//! Reading logs.

use std::collections::{BTreeSet, HashMap};
use std::fs::File;
use std::io::{BufReader, Read};
use std::ops::ControlFlow;
use std::path::Path;

use gt_core::Signal;
use mcap::Channel;
use mcap::read::ChannelAccumulator;
use mcap::records::{MessageHeader, Record};

use crate::import::{Columns, DEFAULT_TOPIC, Imported, Selection};
use crate::message::Decoder;
use crate::records::scan;
use crate::schema::{DoubleField, double_fields};
use crate::source::{self, Hashing};
use crate::table::Table;
use crate::time::{Clock, Uniform};
use crate::{LogError, Place};

/// Channels and messages of a log, in the order of the file.
enum Event<'a> {
    Channel(&'a Channel<'static>),
    Message(&'a Channel<'static>, MessageHeader, &'a [u8]),
}

/// Calls `visit` with every channel, before its messages, and every message.
fn follow<R: Read>(
    path: &Path,
    source: R,
    size: u64,
    mut visit: impl FnMut(Event<'_>) -> Result<ControlFlow<()>, LogError>,
) -> Result<(), LogError> {
    let corrupt = |cause| LogError::Corrupt {
        path: path.to_owned(),
        cause,
    };
    let mut known = ChannelAccumulator::default();
    scan(path, source, size, |record| match record {
        Record::Schema { header, data } => {
            known
                .add_schema_from_slice(header, &data)
                .map_err(corrupt)?;
            Ok(ControlFlow::Continue(()))
        }
        Record::Channel(channel) => {
            let id = channel.id;
            known.add_channel(channel).map_err(corrupt)?;
            match known.get(id) {
                Some(channel) => visit(Event::Channel(&channel)),
                None => Ok(ControlFlow::Continue(())),
            }
        }
        Record::Message { header, data } => {
            let (sequence, id) = (header.sequence, header.channel_id);
            let channel = known
                .get(id)
                .ok_or_else(|| corrupt(mcap::McapError::UnknownChannel(sequence, id)))?;
            visit(Event::Message(&channel, header, &data))
        }
        _ => Ok(ControlFlow::Continue(())),
    })
}

fn buffered(path: &Path) -> Result<(BufReader<File>, u64), LogError> {
    let (file, size) = source::open(path)?;
    Ok((BufReader::with_capacity(1 << 16, file), size))
}

/// The `double` fields of a channel.
pub(crate) fn fields_of(path: &Path, channel: &Channel<'_>) -> Result<Vec<DoubleField>, LogError> {
    let schema = channel.schema.as_deref();
    let schema_encoding = schema.map_or("", |schema| schema.encoding.as_str());
    let (Some(schema), "protobuf", "protobuf") =
        (schema, channel.message_encoding.as_str(), schema_encoding)
    else {
        return Err(LogError::Encoding {
            path: path.to_owned(),
            topic: channel.topic.clone(),
            expected: "Protobuf messages of doubles",
            found: format!("{} with schema {schema_encoding}", channel.message_encoding),
        });
    };
    double_fields(&schema.name, &schema.data, &channel.metadata).map_err(|cause| {
        LogError::Descriptor {
            path: path.to_owned(),
            topic: channel.topic.clone(),
            message: schema.name.clone(),
            cause,
        }
    })
}

fn unknown_topic(path: &Path, topic: &str, topics: BTreeSet<String>) -> LogError {
    let (path, topic) = (path.to_owned(), topic.to_owned());
    LogError::UnknownTopic {
        path,
        topic,
        available: topics.into_iter().collect(),
    }
}

/// The fields of a topic.
pub(crate) fn columns(path: &Path, topic: &str) -> Result<Vec<Signal>, LogError> {
    let (source, size) = buffered(path)?;
    let mut topics = BTreeSet::new();
    let mut found = None;
    follow(path, source, size, |event| {
        if let Event::Channel(channel) = event {
            topics.insert(channel.topic.clone());
            if channel.topic == topic {
                found = Some(fields_of(path, channel)?);
                return Ok(ControlFlow::Break(()));
            }
        }
        Ok(ControlFlow::Continue(()))
    })?;
    let fields = found.ok_or_else(|| unknown_topic(path, topic, topics))?;
    Ok(fields.into_iter().map(|field| field.signal).collect())
}

/// What is wrong with a message, to be told only if it is selected.
enum Fault {
    Missing(usize),
    Malformed(String),
}

/// The messages of a topic, in the order of the file.
struct Messages {
    times_ns: Vec<u64>,
    /// The selected columns, message by message; NaN where there is a fault.
    values: Vec<f64>,
    faults: HashMap<usize, Fault>,
}

impl Messages {
    fn push(&mut self, header: &MessageHeader, decoder: &Decoder, width: usize, data: &[u8]) {
        // Live logs: published when measured, logged when received. Some writers know only one.
        let time_ns = if header.publish_time == 0 {
            header.log_time
        } else {
            header.publish_time
        };
        let index = self.times_ns.len();
        self.times_ns.push(time_ns);
        match decoder.decode(data) {
            Ok(sample) => {
                if let Some(slot) = sample.iter().position(Option::is_none) {
                    self.faults.insert(index, Fault::Missing(slot));
                }
                self.values
                    .extend(sample.into_iter().map(|value| value.unwrap_or(f64::NAN)));
            }
            Err(cause) => {
                self.faults
                    .insert(index, Fault::Malformed(cause.to_string()));
                self.values.extend(std::iter::repeat_n(f64::NAN, width));
            }
        }
    }
}

/// Reads the selected fields of a topic.
pub(crate) fn read_dataset(path: &Path, selection: &Selection) -> Result<Imported, LogError> {
    if let Some(column) = &selection.time {
        let (path, column) = (path.to_owned(), column.clone());
        return Err(LogError::TimeColumnOfLog { path, column });
    }
    let topic = selection.topic.as_deref().unwrap_or(DEFAULT_TOPIC);
    let (source, size) = buffered(path)?;
    let mut source = Hashing::new(source);
    let mut topics = BTreeSet::new();
    let mut table: Option<Table> = None;
    let mut decoders: HashMap<u16, Decoder> = HashMap::new();
    let mut messages = Messages {
        times_ns: vec![],
        values: vec![],
        faults: HashMap::new(),
    };
    follow(path, &mut source, size, |event| {
        match event {
            Event::Channel(channel) => {
                topics.insert(channel.topic.clone());
                if channel.topic == topic && !decoders.contains_key(&channel.id) {
                    let fields = fields_of(path, channel)?;
                    let decoder = match &table {
                        None => {
                            let signals: Vec<Signal> =
                                fields.iter().map(|field| field.signal.clone()).collect();
                            let columns = Columns::resolve(path, &signals, None, selection)?;
                            table = Some(Table::new(&columns, &signals));
                            Decoder::new(columns.all().map(|index| &fields[index]))
                        }
                        // A second channel of the topic (a merged log) must have the same tags.
                        Some(table) => Decoder::new(again(path, table, &fields)?),
                    };
                    decoders.insert(channel.id, decoder);
                }
            }
            Event::Message(channel, header, data) => {
                if let (Some(decoder), Some(table)) = (decoders.get(&channel.id), &table) {
                    messages.push(&header, decoder, table.signals.len(), data);
                }
            }
        }
        Ok(ControlFlow::Continue(()))
    })?;
    let sha256 = source
        .finish()
        .map_err(|cause| LogError::io(path, "read", cause))?;
    let table = table.ok_or_else(|| unknown_topic(path, topic, topics))?;
    assemble(path, topic, selection, table, &messages, sha256)
}

/// The fields of another channel that belong to the columns of the table.
fn again<'f>(
    path: &Path,
    table: &Table,
    fields: &'f [DoubleField],
) -> Result<Vec<&'f DoubleField>, LogError> {
    let find = |signal: &Signal| {
        fields
            .iter()
            .find(|field| field.signal.name == signal.name)
            .ok_or_else(|| LogError::UnknownColumn {
                path: path.to_owned(),
                column: signal.name.clone(),
                available: fields
                    .iter()
                    .map(|field| field.signal.name.clone())
                    .collect(),
            })
    };
    table.signals.iter().map(find).collect()
}

/// The selected messages in the order of time.
fn assemble(
    path: &Path,
    topic: &str,
    selection: &Selection,
    mut table: Table,
    messages: &Messages,
    sha256: String,
) -> Result<Imported, LogError> {
    let total_rows = messages.times_ns.len();
    if total_rows == 0 {
        return Err(LogError::NoMessages {
            path: path.to_owned(),
            topic: topic.to_owned(),
        });
    }
    let rows = selection.rows_of(path, total_rows)?;
    // The order in a file is that of writing, which several threads may have shared.
    let mut order: Vec<usize> = (0..total_rows).collect();
    order.sort_by_key(|&index| messages.times_ns[index]);
    let first_ns = messages.times_ns[order[0]];
    let time_s = |index: usize| (messages.times_ns[index] - first_ns) as f64 / 1e9;

    let width = table.signals.len();
    for &index in &order[rows.clone()] {
        let (path, topic, time_s) = (path.to_owned(), topic.to_owned(), time_s(index));
        match messages.faults.get(&index) {
            None => {
                let sample = &messages.values[index * width..(index + 1) * width];
                table.push(sample.iter().copied());
            }
            Some(&Fault::Missing(slot)) => {
                let column = table.signals[slot].name.clone();
                return Err(LogError::MissingField {
                    path,
                    topic,
                    column,
                    time_s,
                });
            }
            Some(Fault::Malformed(cause)) => {
                let cause = cause.clone();
                return Err(LogError::Message {
                    path,
                    topic,
                    time_s,
                    cause,
                });
            }
        }
    }

    let times: Vec<i128> = order[rows.clone()]
        .iter()
        .map(|&index| messages.times_ns[index].into())
        .collect();
    let start_unix_ns = times.first().copied();
    let uniform = match selection.sample_time_s {
        Some(given) => Uniform::given(given),
        None => Clock::Nanoseconds(times).uniform(path, selection.missing, |row| {
            Place::Message(rows.start + row)
        })?,
    };
    let start_time_s = match selection.sample_time_s {
        Some(given) => rows.start as f64 * given,
        None => time_s(order[rows.start]),
    };
    let warnings = table.invalid_samples();
    let dataset = table.into_dataset(path, uniform.sample_time_s, start_time_s)?;
    Ok(Imported {
        dataset,
        sha256,
        warnings,
        total_rows,
        start_unix_ns,
        gaps: uniform.gaps,
        resampled: None,
    })
}

/// A message of a JSON topic.
#[derive(Debug, Clone, PartialEq)]
pub struct JsonMessage {
    /// Publish time in nanoseconds since 1970.
    pub time_ns: u64,
    /// The message.
    pub value: serde_json::Value,
}

/// The messages of a JSON topic, in the order of the file.
///
/// # Errors
/// [`LogError::UnknownTopic`], [`LogError::Encoding`], [`LogError::Message`], or a broken file.
pub fn read_json_messages(path: &Path, topic: &str) -> Result<Vec<JsonMessage>, LogError> {
    let (source, size) = buffered(path)?;
    let mut topics = BTreeSet::new();
    let mut messages: Vec<JsonMessage> = Vec::new();
    let mut first_ns = None;
    follow(path, source, size, |event| {
        match event {
            Event::Channel(channel) => {
                topics.insert(channel.topic.clone());
                if channel.topic == topic && channel.message_encoding != "json" {
                    return Err(LogError::Encoding {
                        path: path.to_owned(),
                        topic: topic.to_owned(),
                        expected: "JSON messages",
                        found: channel.message_encoding.clone(),
                    });
                }
            }
            Event::Message(channel, header, data) if channel.topic == topic => {
                let time_ns = header.publish_time;
                let first_ns = *first_ns.get_or_insert(time_ns);
                let value = serde_json::from_slice(data).map_err(|cause| LogError::Message {
                    path: path.to_owned(),
                    topic: topic.to_owned(),
                    time_s: (i128::from(time_ns) - i128::from(first_ns)) as f64 / 1e9,
                    cause: cause.to_string(),
                })?;
                messages.push(JsonMessage { time_ns, value });
            }
            Event::Message(..) => {}
        }
        Ok(ControlFlow::Continue(()))
    })?;
    if topics.contains(topic) {
        Ok(messages)
    } else {
        Err(unknown_topic(path, topic, topics))
    }
}

/// The bytes of an attachment, such as `config.toml`; of several with one name the first.
///
/// # Errors
/// [`LogError::UnknownAttachment`], or a broken file.
pub fn read_attachment(path: &Path, name: &str) -> Result<Vec<u8>, LogError> {
    let (source, size) = buffered(path)?;
    let mut available = Vec::new();
    let mut found = None;
    scan(path, source, size, |record| {
        if let Record::Attachment { header, data, .. } = record {
            if header.name == name {
                found = Some(data.into_owned());
                return Ok(ControlFlow::Break(()));
            }
            available.push(header.name);
        }
        Ok(ControlFlow::Continue(()))
    })?;
    found.ok_or_else(|| LogError::UnknownAttachment {
        path: path.to_owned(),
        name: name.to_owned(),
        available,
    })
}
