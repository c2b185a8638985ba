//! The rows of a Protobuf topic.

use std::collections::HashMap;
use std::collections::hash_map::Entry;
use std::ops::Range;
use std::path::Path;

use gt_core::Signal;

use super::block::{Block, Cell, Kind};
use super::order::Order;
use super::{Rows, select};
use crate::LogError;
use crate::fields::{Decoder, Fields, Survey};
use crate::reader::{self, again};

/// What is read of a topic's messages.
pub(super) struct Numbers {
    signals: Vec<Signal>,
    decoders: HashMap<u16, Decoder>,
}

impl Numbers {
    /// The selected fields of the channels of a topic.
    pub(super) fn new(
        path: &Path,
        topic: &str,
        tags: &[String],
        channels: &[(u16, Fields)],
    ) -> Result<Self, LogError> {
        let Some((_, fields)) = channels.iter().find(|(_, own)| !own.signals.is_empty()) else {
            return Err(reader::no_number(path, topic));
        };
        let places = select(path, &fields.signals, tags, fields.signals.len())?;
        let signals: Vec<Signal> = places
            .iter()
            .map(|&at| fields.signals[at].clone())
            .collect();
        let mut decoders = HashMap::new();
        for (id, fields) in channels {
            decoders.insert(*id, fields.decoder(again(path, &signals, &fields.signals)?));
        }
        Ok(Self { signals, decoders })
    }

    /// The columns.
    pub(super) fn columns(&self) -> Vec<(Signal, Kind)> {
        let signals = self.signals.iter().cloned();
        signals.map(|signal| (signal, Kind::Number)).collect()
    }
}

impl Rows for Numbers {
    fn write(
        &mut self,
        (path, topic): (&Path, &str),
        order: &Order,
        rows: &Range<usize>,
        sink: &mut dyn FnMut(&mut dyn FnMut(&mut Block)) -> Result<(), LogError>,
    ) -> Result<(), LogError> {
        let Self { signals, decoders } = self;
        order.rows(
            (path, topic),
            rows,
            |channel, data| {
                let decoder = match decoders.entry(channel.id) {
                    Entry::Occupied(own) => own.into_mut(),
                    // A channel that came after the first of a merged log.
                    Entry::Vacant(own) => {
                        let fields = Survey::of(path, channel)?.fields();
                        let columns = again(path, signals, &fields.signals)?;
                        own.insert(fields.decoder(columns))
                    }
                };
                Ok(decoder.decode(data))
            },
            |time_ns, row| {
                sink(&mut |block| {
                    block.push(time_ns, row.iter().map(|value| Cell::Number(*value)));
                })
            },
        )
    }
}
