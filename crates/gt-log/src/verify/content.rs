//! Schemas, channels and messages.

use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};

use mcap::records::{Channel, MessageHeader, Record, SchemaHeader};

use super::problem::{ProblemKind, Problems};
use crate::judge::Judge;

struct Known {
    channel: Channel,
    judge: Judge,
    messages: u64,
    last: Option<(u32, u64)>,
    /// Messages whose sequence does not rise, and the offset of the first.
    sequence_falls: (u64, u64),
    /// Messages before the one before them, and the offset of the first.
    time_falls: (u64, u64),
}

/// What has been seen of schemas, channels and messages.
pub(super) struct Content {
    path: PathBuf,
    pub(super) schemas: BTreeMap<u16, (SchemaHeader, Vec<u8>)>,
    channels: BTreeMap<u16, Known>,
    pub(super) messages: u64,
    pub(super) decoded: u64,
    pub(super) bounds: Option<(u64, u64)>,
    pub(super) foreign: BTreeSet<String>,
}

impl Content {
    pub(super) fn new(path: &Path) -> Self {
        Self {
            path: path.to_owned(),
            schemas: BTreeMap::new(),
            channels: BTreeMap::new(),
            messages: 0,
            decoded: 0,
            bounds: None,
            foreign: BTreeSet::new(),
        }
    }

    /// How many messages each channel has, without those that have none.
    pub(super) fn counts(&self) -> BTreeMap<u16, u64> {
        let counts = self.channels.iter().map(|(id, own)| (*id, own.messages));
        counts.filter(|(_, count)| *count > 0).collect()
    }

    pub(super) fn channel_count(&self) -> usize {
        self.channels.len()
    }

    /// A schema or a channel.
    pub(super) fn define(
        &mut self,
        offset: u64,
        record: Record<'_>,
        summary: bool,
        problems: &mut Problems,
    ) {
        let kind = ProblemKind::Definition;
        match record {
            Record::Schema { header, .. } if header.id == 0 => {
                problems.damage(offset, kind, "schema 0: expected an id from 1 on");
            }
            Record::Schema { header, data } => match self.schemas.get(&header.id) {
                Some((known, bytes)) if (known, &bytes[..]) != (&header, &data[..]) => {
                    let text = format!("schema {} is defined twice, differently", header.id);
                    problems.damage(offset, kind, text);
                }
                Some(_) => {}
                None if summary => {
                    let text = format!("schema {} stands in the summary alone", header.id);
                    problems.damage(offset, kind, text);
                }
                None => {
                    self.schemas.insert(header.id, (header, data.into_owned()));
                }
            },
            Record::Channel(channel) => self.define_channel(offset, channel, summary, problems),
            _ => {}
        }
    }

    fn define_channel(
        &mut self,
        offset: u64,
        channel: Channel,
        summary: bool,
        problems: &mut Problems,
    ) {
        let kind = ProblemKind::Definition;
        let id = channel.id;
        if let Some(known) = self.channels.get(&id) {
            if known.channel != channel {
                problems.damage(
                    offset,
                    kind,
                    format!("channel {id} is defined twice, differently"),
                );
            }
            return;
        }
        if summary {
            problems.damage(
                offset,
                kind,
                format!("channel {id} stands in the summary alone"),
            );
            return;
        }
        let schema = channel.schema_id;
        if schema != 0 && !self.schemas.contains_key(&schema) {
            problems.damage(
                offset,
                kind,
                format!("channel {id}: expected its schema {schema} before it, found none"),
            );
        }
        let judge = self.judge(offset, &channel, problems);
        self.channels.insert(
            id,
            Known {
                channel,
                judge,
                messages: 0,
                last: None,
                sequence_falls: (0, 0),
                time_falls: (0, 0),
            },
        );
    }

    fn judge(&mut self, offset: u64, channel: &Channel, problems: &mut Problems) -> Judge {
        match Judge::of(&self.path, channel, self.schemas.get(&channel.schema_id)) {
            Ok(judge) => {
                if matches!(judge, Judge::Foreign) {
                    self.foreign.insert(channel.message_encoding.clone());
                }
                judge
            }
            Err(cause) => {
                problems.damage(offset, ProblemKind::Definition, cause.to_string());
                Judge::Wire
            }
        }
    }

    /// A message.
    pub(super) fn message(
        &mut self,
        offset: u64,
        header: &MessageHeader,
        data: &[u8],
        problems: &mut Problems,
    ) {
        self.messages += 1;
        let time = header.log_time;
        self.bounds = Some(
            self.bounds
                .map_or((time, time), |(a, b)| (a.min(time), b.max(time))),
        );
        let kind = ProblemKind::Message;
        let Some(known) = self.channels.get_mut(&header.channel_id) else {
            let text = format!(
                "message {}: expected its channel {} before it, found none",
                header.sequence, header.channel_id
            );
            problems.damage(offset, kind, text);
            return;
        };
        known.messages += 1;
        if let Some((sequence, before)) = known.last {
            if header.sequence <= sequence && (header.sequence, sequence) != (0, 0) {
                count(&mut known.sequence_falls, offset);
            }
            if time < before {
                count(&mut known.time_falls, offset);
            }
        }
        known.last = Some((header.sequence, time));
        match known.judge.decode(data) {
            Ok(decoded) => self.decoded += u64::from(decoded),
            Err(cause) => {
                let topic = &known.channel.topic;
                let text = format!(
                    "topic `{topic}`, message {} at {time} ns: expected a message of its schema, \
                     found: {cause}",
                    header.sequence
                );
                problems.damage(offset, kind, text);
            }
        }
    }

    /// What the channels say of the order of their messages.
    pub(super) fn order(&self, problems: &mut Problems) {
        for (id, known) in &self.channels {
            let topic = &known.channel.topic;
            let (count, offset) = known.sequence_falls;
            if count > 0 {
                let text = format!(
                    "topic `{topic}` (channel {id}): {count} messages have a sequence that does \
                     not rise; the first is here"
                );
                problems.remark(offset, ProblemKind::Order, text);
            }
            let (count, offset) = known.time_falls;
            if count > 0 {
                let text = format!(
                    "topic `{topic}` (channel {id}): {count} messages have a log time before that \
                     of the message before them; the first is here"
                );
                problems.remark(offset, ProblemKind::Order, text);
            }
        }
    }
}

fn count(falls: &mut (u64, u64), offset: u64) {
    if falls.0 == 0 {
        falls.1 = offset;
    }
    falls.0 += 1;
}
