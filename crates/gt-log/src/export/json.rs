//! The rows of a JSON topic: the keys of its messages, and with tags the numbers within.

use std::ops::{ControlFlow, Range};
use std::path::Path;

use gt_core::Signal;
use serde_json::Value;

use super::block::{Block, Cell, Kind};
use super::order::Order;
use super::{Rows, select};
use crate::LogError;
use crate::fields::Fields;
use crate::reader::{self, Event, follow};

/// What is read of a topic's messages.
pub(super) struct Texts<'a> {
    /// The keys of all messages in the order in which they come.
    keys: Vec<String>,
    /// Whether any selected message is an object; else each is one value.
    is_object: bool,
    /// The numbers within, as they are called in a dataset.
    inner: Option<&'a Fields>,
    columns: Vec<(Signal, Source, Kind)>,
}

/// Where the cells of a column are.
#[derive(Clone, Copy)]
enum Source {
    /// Under the key of this number.
    Key(usize),
    /// The number of this place among the fields.
    Within(usize),
}

/// Which kinds of values a key has.
#[derive(Debug, Clone, Copy, Default)]
#[expect(clippy::struct_excessive_bools, reason = "one for each kind of value")]
struct Found {
    truths: bool,
    integers: bool,
    numbers: bool,
    texts: bool,
    others: bool,
}

impl Found {
    fn add(&mut self, value: &Value) {
        match value {
            Value::Bool(_) => self.truths = true,
            Value::Number(_) if value.is_i64() => self.integers = true,
            Value::Number(_) => self.numbers = true,
            Value::String(_) => self.texts = true,
            _ => self.others = true,
        }
    }

    /// The narrowest kind that loses nothing.
    fn kind(self) -> Kind {
        let Self {
            truths,
            integers,
            numbers,
            texts,
            others,
        } = self;
        match (truths, integers, numbers, texts, others) {
            (true, false, false, false, false) => Kind::Truth,
            (false, true, false, false, false) => Kind::Integer,
            (false, _, true, false, false) => Kind::Number,
            (false, false, false, _, false) => Kind::Text,
            _ => Kind::Json,
        }
    }
}

impl<'a> Texts<'a> {
    /// Reads which keys there are, and of the selected rows of which kind each is.
    pub(super) fn new(
        (path, topic): (&Path, &str),
        tags: &[String],
        channels: &'a [(u16, Fields)],
        order: &Order,
        rows: &Range<usize>,
    ) -> Result<Self, LogError> {
        let mut keys = all_keys(path, topic)?;
        let mut kinds = vec![Found::default(); keys.len()];
        let (mut whole, mut is_object) = (Found::default(), false);
        order.rows(
            (path, topic),
            rows,
            |_, data| Ok(parse(data)),
            |_, row| {
                is_object |= row.is_object();
                if !row.is_null() {
                    whole.add(&row);
                }
                for (key, kind) in keys.iter().zip(&mut kinds) {
                    if let Some(own) = row.get(key).filter(|own| !own.is_null()) {
                        kind.add(own);
                    }
                }
                Ok(())
            },
        )?;
        if !is_object {
            (keys, kinds) = (vec!["value".to_owned()], vec![whole]);
        }
        let inner = channels.iter().find(|(_, own)| !own.signals.is_empty());
        let inner = inner.map(|(_, own)| own);
        let key = |(place, key): (usize, &String)| {
            let signal = Signal::new(key.as_str(), "");
            (signal, Source::Key(place), kinds[place].kind())
        };
        let mut available: Vec<(Signal, Source, Kind)> = keys.iter().enumerate().map(key).collect();
        for (place, signal) in inner.iter().flat_map(|own| own.signals.iter().enumerate()) {
            match available.iter_mut().find(|own| own.0.name == signal.name) {
                Some(known) => known.0.unit.clone_from(&signal.unit),
                None => available.push((signal.clone(), Source::Within(place), Kind::Number)),
            }
        }
        let signals: Vec<Signal> = available.iter().map(|own| own.0.clone()).collect();
        let places = select(path, &signals, tags, keys.len())?;
        let columns = places
            .into_iter()
            .map(|place| available[place].clone())
            .collect();
        Ok(Self {
            keys,
            is_object,
            inner,
            columns,
        })
    }

    /// The columns.
    pub(super) fn columns(&self) -> Vec<(Signal, Kind)> {
        let columns = self.columns.iter();
        columns.map(|own| (own.0.clone(), own.2)).collect()
    }
}

impl Rows for Texts<'_> {
    fn write(
        &mut self,
        of: (&Path, &str),
        order: &Order,
        rows: &Range<usize>,
        sink: &mut dyn FnMut(&mut dyn FnMut(&mut Block)) -> Result<(), LogError>,
    ) -> Result<(), LogError> {
        order.rows(
            of,
            rows,
            |_, data| Ok(parse(data)),
            |time_ns, row| {
                sink(&mut |block| {
                    let cells = self.columns.iter().map(|(_, source, _)| match *source {
                        Source::Within(place) => {
                            Cell::Number(self.inner.and_then(|own| own.json_number(place, &row)))
                        }
                        Source::Key(place) => {
                            let own = if self.is_object {
                                row.get(&self.keys[place])
                            } else {
                                Some(&row)
                            };
                            Cell::Json(own.filter(|own| !own.is_null()))
                        }
                    });
                    block.push(time_ns, cells);
                })
            },
        )
    }
}

fn parse(data: &[u8]) -> Result<Value, String> {
    serde_json::from_slice(data).map_err(|cause| cause.to_string())
}

/// The keys of a topic's messages, selected or not, in the order in which they come.
fn all_keys(path: &Path, topic: &str) -> Result<Vec<String>, LogError> {
    let mut keys: Vec<String> = Vec::new();
    let (source, size) = reader::buffered(path)?;
    follow(path, source, size, |event| {
        if let Event::Message(channel, _, data) = event
            && channel.topic == topic
            && let Ok(Value::Object(own)) = parse(data)
        {
            for key in own.keys() {
                if !keys.contains(key) {
                    keys.push(key.clone());
                }
            }
        }
        Ok(ControlFlow::Continue(()))
    })?;
    Ok(keys)
}
