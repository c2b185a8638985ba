//! Reading logs.

use std::collections::{BTreeSet, HashMap};
use std::fs::File;
use std::io::{BufReader, Read};
use std::ops::ControlFlow;
use std::path::Path;

use gt_core::Signal;
use gtfdi::ident::Missing;
use mcap::Channel;
use mcap::read::ChannelAccumulator;
use mcap::records::{MessageHeader, Metadata, Record};

use crate::fields::{Decoder, Fields, Survey};
use crate::import::{Columns, DEFAULT_TOPIC, Imported, Selection};
use crate::records::scan;
use crate::source::{self, Hashing};
use crate::table::Table;
use crate::time::{Clock, Uniform};
use crate::writer::{LOG_VERSION, RUN_RECORD, VERSION_KEY};
use crate::{LogError, Place};

/// Channels and messages of a log, in the order of the file.
pub(crate) enum Event<'a> {
    Channel(&'a Channel<'static>),
    Message(&'a Channel<'static>, MessageHeader, &'a [u8]),
}

/// Calls `visit` with every channel, before its messages, and every message.
pub(crate) fn follow<R: Read>(
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
        Record::Metadata(own) => check_version(path, &own).map(|()| ControlFlow::Continue(())),
        _ => Ok(ControlFlow::Continue(())),
    })
}

/// Refuses a log whose content this version would misread.
fn check_version(path: &Path, record: &Metadata) -> Result<(), LogError> {
    let found = record.metadata.get(VERSION_KEY);
    match found.filter(|_| record.name == RUN_RECORD) {
        Some(found) if !found.parse::<u64>().is_ok_and(|own| own <= LOG_VERSION) => {
            Err(LogError::NewerLog {
                path: path.to_owned(),
                expected: LOG_VERSION,
                found: found.clone(),
            })
        }
        _ => Ok(()),
    }
}

/// A file to read from its beginning, and its size.
pub(crate) fn buffered(path: &Path) -> Result<(BufReader<File>, u64), LogError> {
    let (file, size) = source::open(path)?;
    Ok((BufReader::with_capacity(1 << 16, file), size))
}

fn unknown_topic(path: &Path, topic: &str, topics: BTreeSet<String>) -> LogError {
    let (path, topic) = (path.to_owned(), topic.to_owned());
    LogError::UnknownTopic {
        path,
        topic,
        available: topics.into_iter().collect(),
    }
}

/// The fields of the channels of a topic, by the channels' ids in the order of the file. Messages are
/// read only where they are needed to tell.
pub(crate) fn fields_of_topic(path: &Path, topic: &str) -> Result<Vec<(u16, Fields)>, LogError> {
    let (source, size) = buffered(path)?;
    let mut topics = BTreeSet::new();
    let mut surveys: Vec<(u16, Survey)> = Vec::new();
    follow(path, source, size, |event| {
        match event {
            Event::Channel(channel) => {
                topics.insert(channel.topic.clone());
                let known = surveys.iter().any(|(id, _)| *id == channel.id);
                if channel.topic == topic && !known {
                    let survey = Survey::of(path, channel)?;
                    let is_done = surveys.is_empty() && !survey.needs_messages();
                    surveys.push((channel.id, survey));
                    if is_done {
                        return Ok(ControlFlow::Break(()));
                    }
                }
            }
            Event::Message(channel, _, data) if channel.topic == topic => {
                if let Some((_, survey)) = surveys.iter_mut().find(|(id, _)| *id == channel.id) {
                    survey.add(data);
                }
            }
            Event::Message(..) => {}
        }
        Ok(ControlFlow::Continue(()))
    })?;
    if surveys.is_empty() {
        return Err(unknown_topic(path, topic, topics));
    }
    let fields = surveys.into_iter().map(|(id, own)| (id, own.fields()));
    Ok(fields.collect())
}

/// The fields of a topic.
pub(crate) fn columns(path: &Path, topic: &str) -> Result<Vec<Signal>, LogError> {
    let channels = fields_of_topic(path, topic)?.into_iter();
    channels
        .map(|(_, fields)| fields.signals)
        .find(|signals| !signals.is_empty())
        .ok_or_else(|| no_number(path, topic))
}

pub(crate) fn no_number(path: &Path, topic: &str) -> LogError {
    LogError::NoNumber {
        path: path.to_owned(),
        topic: topic.to_owned(),
    }
}

/// The time of a message. Live logs: published when measured, logged when received. Some writers know
/// only one.
pub(crate) fn message_time_ns(header: &MessageHeader) -> u64 {
    if header.publish_time == 0 {
        header.log_time
    } else {
        header.publish_time
    }
}

/// What is wrong with a message, to be told only if it is selected.
pub(crate) enum Fault {
    /// The selected fields that it leaves out, one at least.
    Missing(Vec<usize>),
    /// It cannot be read.
    Malformed(String),
}

/// The messages of a topic, in the order of the file.
pub(crate) struct Messages {
    pub(crate) times_ns: Vec<u64>,
    /// The selected columns, message by message; NaN where there is a fault.
    pub(crate) values: Vec<f64>,
    pub(crate) faults: HashMap<usize, Fault>,
}

impl Messages {
    /// The messages in the order of time. That of a file is the order of writing, which several
    /// threads may have shared.
    pub(crate) fn order(&self) -> Vec<usize> {
        let mut order: Vec<usize> = (0..self.times_ns.len()).collect();
        order.sort_by_key(|&index| self.times_ns[index]);
        order
    }

    fn push(&mut self, header: &MessageHeader, decoder: &Decoder, width: usize, data: &[u8]) {
        let time_ns = message_time_ns(header);
        let index = self.times_ns.len();
        self.times_ns.push(time_ns);
        match decoder.decode(data) {
            Ok(sample) => {
                let slots = sample.iter().enumerate();
                let absent: Vec<usize> = slots
                    .filter(|(_, value)| value.is_none())
                    .map(|(slot, _)| slot)
                    .collect();
                if !absent.is_empty() {
                    self.faults.insert(index, Fault::Missing(absent));
                }
                self.values
                    .extend(sample.into_iter().map(|value| value.unwrap_or(f64::NAN)));
            }
            Err(cause) => {
                self.faults.insert(index, Fault::Malformed(cause));
                self.values.extend(std::iter::repeat_n(f64::NAN, width));
            }
        }
    }
}

/// The selected fields of a topic's messages.
pub(crate) struct TopicRead {
    pub(crate) table: Table,
    pub(crate) messages: Messages,
    pub(crate) sha256: String,
}

/// Reads the selected fields of a topic.
pub(crate) fn read_dataset(path: &Path, selection: &Selection) -> Result<Imported, LogError> {
    let topic = selection.topic.as_deref().unwrap_or(DEFAULT_TOPIC);
    let read = read_messages(path, selection, |signals| {
        Columns::resolve(path, signals, None, selection)
    })?;
    assemble(path, topic, selection, read)
}

/// Reads the messages of a topic, as to the fields that `choose` takes.
pub(crate) fn read_messages(
    path: &Path,
    selection: &Selection,
    choose: impl FnOnce(&[Signal]) -> Result<Columns, LogError>,
) -> Result<TopicRead, LogError> {
    if let Some(column) = &selection.time {
        let (path, column) = (path.to_owned(), column.clone());
        return Err(LogError::TimeColumnOfLog { path, column });
    }
    let topic = selection.topic.as_deref().unwrap_or(DEFAULT_TOPIC);
    let channels = fields_of_topic(path, topic)?;
    let Some((_, fields)) = channels.iter().find(|(_, own)| !own.signals.is_empty()) else {
        return Err(no_number(path, topic));
    };
    let columns = choose(&fields.signals)?;
    let table = Table::new(&columns, &fields.signals);
    let mut decoders: HashMap<u16, Decoder> = HashMap::new();
    for (id, fields) in &channels {
        // A second channel of the topic (a merged log) must have the same tags.
        decoders.insert(
            *id,
            fields.decoder(again(path, &table.signals, &fields.signals)?),
        );
    }
    let (source, size) = buffered(path)?;
    let mut source = Hashing::new(source);
    let mut messages = Messages {
        times_ns: vec![],
        values: vec![],
        faults: HashMap::new(),
    };
    follow(path, &mut source, size, |event| {
        match event {
            Event::Channel(channel) => {
                if channel.topic == topic && !decoders.contains_key(&channel.id) {
                    let fields = Survey::of(path, channel)?.fields();
                    let columns = again(path, &table.signals, &fields.signals)?;
                    decoders.insert(channel.id, fields.decoder(columns));
                }
            }
            Event::Message(channel, header, data) => {
                if let Some(decoder) = decoders.get(&channel.id) {
                    messages.push(&header, decoder, table.signals.len(), data);
                }
            }
        }
        Ok(ControlFlow::Continue(()))
    })?;
    let sha256 = source
        .finish()
        .map_err(|cause| LogError::io(path, "read", cause))?;
    if messages.times_ns.is_empty() {
        let (path, topic) = (path.to_owned(), topic.to_owned());
        return Err(LogError::NoMessages { path, topic });
    }
    Ok(TopicRead {
        table,
        messages,
        sha256,
    })
}

/// The places among the fields of another channel of the signals that are wanted.
pub(crate) fn again(
    path: &Path,
    wanted: &[Signal],
    fields: &[Signal],
) -> Result<Vec<usize>, LogError> {
    let find = |signal: &Signal| {
        let place = fields.iter().position(|field| field.name == signal.name);
        place.ok_or_else(|| LogError::UnknownColumn {
            path: path.to_owned(),
            column: signal.name.clone(),
            available: fields.iter().map(|field| field.name.clone()).collect(),
        })
    };
    wanted.iter().map(find).collect()
}

/// The selected messages in the order of time.
fn assemble(
    path: &Path,
    topic: &str,
    selection: &Selection,
    read: TopicRead,
) -> Result<Imported, LogError> {
    let TopicRead {
        mut table,
        messages,
        sha256,
    } = read;
    let total_rows = messages.times_ns.len();
    let rows = selection.rows_of(path, total_rows)?;
    let order = messages.order();
    let first_ns = messages.times_ns[order[0]];
    let time_s = |index: usize| (messages.times_ns[index] - first_ns) as f64 / 1e9;

    let width = table.signals.len();
    for &index in &order[rows.clone()] {
        let (path, topic, time_s) = (path.to_owned(), topic.to_owned(), time_s(index));
        match messages.faults.get(&index) {
            Some(Fault::Missing(slots)) if selection.missing == Missing::Refuse => {
                let column = table.signals[slots[0]].name.clone();
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
            _ => {
                let sample = &messages.values[index * width..(index + 1) * width];
                table.push(sample.iter().copied());
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
        qualities: Vec::new(),
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
