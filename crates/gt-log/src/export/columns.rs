//! A topic as a sheet of columns.

use std::collections::HashMap;
use std::ops::ControlFlow;
use std::path::Path;

use gt_core::Signal;
use serde_json::Value;

use super::ExportOptions;
use crate::fields::{Decoder, Fields};
use crate::import::{Columns as Selected, DEFAULT_TOPIC, Selection};
use crate::reader::{self, Event, again, fields_of_topic, follow, message_time_ns};
use crate::{LogError, Place};

/// The rows of a topic, in the order of time.
pub(super) struct Sheet {
    pub(super) topic: String,
    /// The name of the column of the time.
    pub(super) time: String,
    pub(super) times_ns: Vec<u64>,
    /// The time of the topic's first message.
    pub(super) first_ns: u64,
    pub(super) columns: Vec<Column>,
}

/// A column.
pub(super) struct Column {
    pub(super) signal: Signal,
    pub(super) cells: Cells,
}

/// The cells of a column, all of one kind.
pub(super) enum Cells {
    Numbers(Vec<Option<f64>>),
    Integers(Vec<Option<i64>>),
    Truths(Vec<Option<bool>>),
    Texts(Vec<Option<String>>),
}

impl Cells {
    /// Cells of what JSON had, of the narrowest kind that loses nothing.
    fn of(values: &[Option<&Value>]) -> Self {
        let there = || values.iter().copied().flatten();
        if there().all(Value::is_boolean) && there().next().is_some() {
            return Self::Truths(
                values
                    .iter()
                    .map(|own| own.and_then(Value::as_bool))
                    .collect(),
            );
        }
        if there().all(Value::is_i64) && there().next().is_some() {
            return Self::Integers(
                values
                    .iter()
                    .map(|own| own.and_then(Value::as_i64))
                    .collect(),
            );
        }
        if there().all(Value::is_number) && there().next().is_some() {
            return Self::Numbers(
                values
                    .iter()
                    .map(|own| own.and_then(Value::as_f64))
                    .collect(),
            );
        }
        let texts_only = there().all(Value::is_string);
        let text = |own: &Value| match own {
            Value::String(text) if texts_only => text.clone(),
            other => other.to_string(),
        };
        Self::Texts(values.iter().map(|own| own.map(text)).collect())
    }

    pub(super) fn kind(&self) -> &'static str {
        match self {
            Self::Numbers(_) => "number",
            Self::Integers(_) => "integer",
            Self::Truths(_) => "truth",
            Self::Texts(_) => "text",
        }
    }

    pub(super) fn absent(&self) -> usize {
        fn count<T>(cells: &[Option<T>]) -> usize {
            cells.iter().filter(|cell| cell.is_none()).count()
        }
        match self {
            Self::Numbers(cells) => count(cells),
            Self::Integers(cells) => count(cells),
            Self::Truths(cells) => count(cells),
            Self::Texts(cells) => count(cells),
        }
    }
}

/// The messages of a topic in the order of the file, not yet columns.
struct Messages<T> {
    times_ns: Vec<u64>,
    rows: Vec<Result<T, String>>,
}

impl<T> Messages<T> {
    fn new() -> Self {
        Self {
            times_ns: Vec::new(),
            rows: Vec::new(),
        }
    }

    /// The rows that are asked for in the order of time, with their times and that of the first of
    /// all. A message that cannot be decoded is told where it is one of them.
    fn ordered(
        self,
        path: &Path,
        topic: &str,
        options: &ExportOptions,
    ) -> Result<(u64, Vec<u64>, Vec<T>), LogError> {
        let total = self.times_ns.len();
        let selection = Selection {
            rows: options.rows.clone(),
            ..Selection::default()
        };
        let first_ns = self.times_ns.iter().copied().min();
        let first_ns = first_ns.ok_or_else(|| LogError::NoMessages {
            path: path.to_owned(),
            topic: topic.to_owned(),
        })?;
        let rows = selection.rows_of(path, total)?;
        let mut order: Vec<(u64, Result<T, String>)> =
            self.times_ns.into_iter().zip(self.rows).collect();
        // Stable: messages of one time stay in the order of the file.
        order.sort_by_key(|own| own.0);
        let mut times_ns = Vec::with_capacity(rows.len());
        let mut found = Vec::with_capacity(rows.len());
        for (time_ns, row) in order.into_iter().skip(rows.start).take(rows.len()) {
            times_ns.push(time_ns);
            found.push(row.map_err(|cause| LogError::Message {
                path: path.to_owned(),
                topic: topic.to_owned(),
                time_s: (time_ns - first_ns) as f64 / 1e9,
                cause,
            })?);
        }
        Ok((first_ns, times_ns, found))
    }
}

impl Sheet {
    pub(super) fn read(path: &Path, options: &ExportOptions) -> Result<Self, LogError> {
        let topic = options.topic.as_deref().unwrap_or(DEFAULT_TOPIC);
        let channels = fields_of_topic(path, topic)?;
        let is_text = channels.iter().any(|(_, fields)| fields.is_json());
        let (first_ns, times_ns, columns) = if is_text {
            texts(path, topic, options, &channels)?
        } else {
            numbers(path, topic, options, &channels)?
        };
        let taken = |name: &&str| !columns.iter().any(|own| own.signal.name == **name);
        let time = ["time", "timestamp", "log_time", "message_log_time"];
        let time = time
            .into_iter()
            .find(taken)
            .unwrap_or("time_of_the_message");
        Ok(Self {
            topic: topic.to_owned(),
            time: time.to_owned(),
            times_ns,
            first_ns,
            columns,
        })
    }
}

/// The places of the selected ones of `available`.
fn select(path: &Path, available: &[Signal], tags: &[String]) -> Result<Vec<usize>, LogError> {
    let selection = Selection {
        outputs: tags.to_vec(),
        ..Selection::default()
    };
    Ok(Selected::resolve(path, available, None, &selection)?.outputs)
}

type Found = (u64, Vec<u64>, Vec<Column>);

/// The columns of a Protobuf topic.
fn numbers(
    path: &Path,
    topic: &str,
    options: &ExportOptions,
    channels: &[(u16, Fields)],
) -> Result<Found, LogError> {
    let Some((_, fields)) = channels.iter().find(|(_, own)| !own.signals.is_empty()) else {
        return Err(reader::no_number(path, topic));
    };
    let places = if options.tags.is_empty() {
        (0..fields.signals.len()).collect()
    } else {
        select(path, &fields.signals, &options.tags)?
    };
    let signals: Vec<Signal> = places
        .iter()
        .map(|&at| fields.signals[at].clone())
        .collect();
    let mut decoders: HashMap<u16, Decoder> = HashMap::new();
    for (id, fields) in channels {
        decoders.insert(*id, fields.decoder(again(path, &signals, &fields.signals)?));
    }
    let mut messages = Messages::new();
    let (source, size) = reader::buffered(path)?;
    follow(path, source, size, |event| {
        match event {
            Event::Channel(channel) => {
                if channel.topic == topic && !decoders.contains_key(&channel.id) {
                    let fields = crate::fields::Survey::of(path, channel)?.fields();
                    let columns = again(path, &signals, &fields.signals)?;
                    decoders.insert(channel.id, fields.decoder(columns));
                }
            }
            Event::Message(channel, header, data) => {
                if let Some(decoder) = decoders.get(&channel.id) {
                    messages.times_ns.push(message_time_ns(&header));
                    messages.rows.push(decoder.decode(data));
                }
            }
        }
        Ok(ControlFlow::Continue(()))
    })?;
    let (first_ns, times_ns, rows) = messages.ordered(path, topic, options)?;
    let column = |(place, signal): (usize, Signal)| Column {
        signal,
        cells: Cells::Numbers(rows.iter().map(|row| row[place]).collect()),
    };
    Ok((
        first_ns,
        times_ns,
        signals.into_iter().enumerate().map(column).collect(),
    ))
}

/// The columns of a JSON topic: the keys of its messages, and with tags the numbers within.
fn texts(
    path: &Path,
    topic: &str,
    options: &ExportOptions,
    channels: &[(u16, Fields)],
) -> Result<Found, LogError> {
    let mut messages = Messages::new();
    let mut keys: Vec<String> = Vec::new();
    let (source, size) = reader::buffered(path)?;
    follow(path, source, size, |event| {
        if let Event::Message(channel, header, data) = event
            && channel.topic == topic
        {
            messages.times_ns.push(message_time_ns(&header));
            let value = serde_json::from_slice::<Value>(data);
            if let Ok(Value::Object(own)) = &value {
                let new = own.keys().filter(|key| !keys.contains(key));
                let new: Vec<String> = new.cloned().collect();
                keys.extend(new);
            }
            messages.rows.push(value.map_err(|cause| cause.to_string()));
        }
        Ok(ControlFlow::Continue(()))
    })?;
    let (first_ns, times_ns, rows) = messages.ordered(path, topic, options)?;
    let is_object = rows.iter().any(Value::is_object);
    if !is_object {
        keys = vec!["value".to_owned()];
    }
    let top = keys.len();
    // The numbers within, as they are called in a dataset.
    let inner = channels.iter().find(|(_, own)| !own.signals.is_empty());
    let inner = inner.map(|(_, own)| own);
    let mut available: Vec<Signal> = keys
        .iter()
        .map(|key| Signal::new(key.as_str(), ""))
        .collect();
    let mut within = Vec::new();
    for (place, signal) in inner.iter().flat_map(|own| own.signals.iter().enumerate()) {
        let known = available.iter_mut().find(|own| own.name == signal.name);
        if let Some(known) = known {
            known.unit.clone_from(&signal.unit);
        } else {
            available.push(signal.clone());
            within.push(place);
        }
    }
    let places = if options.tags.is_empty() {
        (0..top).collect()
    } else {
        select(path, &available, &options.tags)?
    };
    let columns = places.into_iter().map(|place| {
        let cells = match place.checked_sub(top) {
            None => {
                let cell = |row: &'_ Value| -> Option<Value> {
                    let own = if is_object {
                        row.get(&keys[place])
                    } else {
                        Some(row)
                    };
                    own.filter(|own| !own.is_null()).cloned()
                };
                let values: Vec<Option<Value>> = rows.iter().map(cell).collect();
                Cells::of(&values.iter().map(Option::as_ref).collect::<Vec<_>>())
            }
            Some(place) => {
                let numbers = rows
                    .iter()
                    .map(|row| inner.and_then(|own| own.json_number(within[place], row)));
                Cells::Numbers(numbers.collect())
            }
        };
        Column {
            signal: available[place].clone(),
            cells,
        }
    });
    Ok((first_ns, times_ns, columns.collect()))
}

/// The row of a message, for messages.
pub(super) fn place(row: usize) -> Place {
    Place::Message(row)
}
