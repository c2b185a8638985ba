//! Which of the meanings that a damaged file gives to its ids count.

use std::collections::BTreeMap;
use std::path::Path;

use mcap::records::{Channel, SchemaHeader};

use super::claims::Claims;
use super::survey::Survey;
use crate::judge::Judge;

type Schema = (SchemaHeader, Vec<u8>);

/// A channel that can be written.
pub(super) struct Known {
    pub(super) channel: Channel,
    pub(super) judge: Judge,
    /// Whether its schema describes messages of its encoding.
    pub(super) described: bool,
}

/// The schemas and channels that can be written, and why others cannot.
#[derive(Default)]
pub(super) struct Definitions {
    pub(super) schemas: BTreeMap<u16, Schema>,
    pub(super) channels: BTreeMap<u16, Known>,
    /// What is wrong with a channel that cannot.
    pub(super) broken: BTreeMap<u16, String>,
}

impl Definitions {
    pub(super) fn of(path: &Path, survey: &Survey) -> Self {
        let mut own = Self::default();
        for (id, claims) in &survey.schemas {
            if let Some(schema) = schema(path, claims, survey.vouched) {
                own.schemas.insert(*id, schema.clone());
            }
        }
        for (id, claims) in &survey.channels {
            match own.channel(path, claims, survey.vouched) {
                Ok(known) => {
                    own.channels.insert(*id, known);
                }
                Err(cause) => {
                    own.broken.insert(*id, cause);
                }
            }
        }
        own
    }

    /// The channel that counts: one that a checksum vouches for as it stands, else the first whose
    /// messages can be decoded.
    fn channel(
        &self,
        path: &Path,
        claims: &Claims<Channel>,
        all_vouched: bool,
    ) -> Result<Known, String> {
        let first = claims.all().next().filter(|_| all_vouched);
        if let Some(channel) = claims.vouched().or(first) {
            let judge = self.judge(path, channel);
            if channel.schema_id != 0 && !self.schemas.contains_key(&channel.schema_id) {
                return Err(missing(channel));
            }
            return Ok(Known {
                channel: channel.clone(),
                described: judge.is_ok(),
                judge: judge.unwrap_or(Judge::Wire),
            });
        }
        let mut cause = String::new();
        for channel in claims.all() {
            match self.judge(path, channel) {
                Ok(judge) => {
                    return Ok(Known {
                        channel: channel.clone(),
                        judge,
                        described: true,
                    });
                }
                Err(own) if cause.is_empty() => cause = own,
                Err(_) => {}
            }
        }
        Err(cause)
    }

    fn judge(&self, path: &Path, channel: &Channel) -> Result<Judge, String> {
        let schema = self.schemas.get(&channel.schema_id);
        if channel.schema_id != 0 && schema.is_none() {
            return Err(missing(channel));
        }
        Judge::of(path, channel, schema).map_err(|cause| {
            let text = cause.to_string();
            // What is said of a file does not depend on its name.
            let named = format!("{}: ", path.display());
            text.strip_prefix(&named).unwrap_or(&text).to_owned()
        })
    }
}

fn missing(channel: &Channel) -> String {
    format!("its schema {} is lost", channel.schema_id)
}

/// The schema that counts: one that a checksum vouches for, else the first that describes messages,
/// else the first.
fn schema<'c>(path: &Path, claims: &'c Claims<Schema>, all_vouched: bool) -> Option<&'c Schema> {
    let first = claims.all().next();
    if let Some(vouched) = claims.vouched().or(first.filter(|_| all_vouched)) {
        return Some(vouched);
    }
    claims.all().find(|own| describes(path, own)).or(first)
}

/// Whether a schema of Protobuf has the message that it names; others are not looked at.
fn describes(path: &Path, schema: &Schema) -> bool {
    let encoding = &schema.0.encoding;
    let channel = Channel {
        id: 0,
        schema_id: schema.0.id,
        topic: String::new(),
        message_encoding: encoding.clone(),
        metadata: BTreeMap::new(),
    };
    Judge::of(path, &channel, Some(schema)).is_ok()
}
