//! The numbers in the messages of a channel: their names, and how each is read.
//!
//! | encoding | fields | absent |
//! |---|---|---|
//! | Protobuf with its descriptor | every number, truth value (1 or 0) and enumeration (its number), of nested messages as `a.b`, of repeated fields as `a[0]`; no maps | a field with presence, an element beyond the end; a plain proto3 field is zero |
//! | JSON, with a schema or none | every number and truth value, of nested objects as `a.b`, of arrays as `a[0]` | a key that is not there, `null` |
//!
//! Integers beyond 2^53 are rounded. Of an array the first [`ELEMENTS`] elements are fields.

mod descriptor;
mod json;
mod reflected;

use std::collections::{BTreeMap, HashSet};
use std::path::Path;

use gt_core::Signal;
use mcap::Channel;

use crate::LogError;
use crate::schema::{DoubleField, TAGS_KEY, UNITS_KEY, double_fields, is_flat};

/// Longer arrays are pictures and spectra; what is beyond is no field.
pub(crate) const ELEMENTS: usize = 1000;
/// More fields than these are not looked at.
pub(crate) const FIELDS: usize = 100_000;

/// What is known of the fields of a channel, message by message: those of arrays and of JSON are in
/// the messages only.
pub(crate) enum Survey {
    Doubles(Vec<DoubleField>),
    Reflected(reflected::Survey, Names),
    Json(json::Survey, Names),
}

/// Names and units that the metadata of a channel give to fields.
#[derive(Debug, Clone, Default)]
pub(crate) struct Names {
    tags: BTreeMap<String, String>,
    units: BTreeMap<String, String>,
}

impl Names {
    fn of(channel: &Channel<'_>) -> Self {
        let map = |key: &str| {
            let text = channel.metadata.get(key);
            text.and_then(|text| serde_json::from_str(text).ok())
                .unwrap_or_default()
        };
        Self {
            tags: map(TAGS_KEY),
            units: map(UNITS_KEY),
        }
    }

    /// The signals of fields; where tags are not distinct, the names of the fields are.
    fn signals(&self, names: &[String]) -> Vec<Signal> {
        let tag = |name: &String| self.tags.get(name).unwrap_or(name).clone();
        let tags: HashSet<String> = names.iter().map(tag).collect();
        let distinct = tags.len() == names.len();
        let signal = |name: &String| {
            let unit = self.units.get(name).map_or("", String::as_str);
            Signal::new(if distinct { tag(name) } else { name.clone() }, unit)
        };
        names.iter().map(signal).collect()
    }
}

impl Survey {
    /// Begins with what the schema tells.
    ///
    /// # Errors
    /// [`LogError::Encoding`] for an encoding that is not read, [`LogError::Descriptor`] for a
    /// schema that is broken.
    pub(crate) fn of(path: &Path, channel: &Channel<'_>) -> Result<Self, LogError> {
        let schema = channel.schema.as_deref();
        let schema_encoding = schema.map_or("", |schema| schema.encoding.as_str());
        let names = Names::of(channel);
        match (channel.message_encoding.as_str(), schema) {
            ("json", _) => Ok(Self::Json(json::Survey::default(), names)),
            ("protobuf", Some(schema)) if schema_encoding == "protobuf" => {
                let broken = |cause| LogError::Descriptor {
                    path: path.to_owned(),
                    topic: channel.topic.clone(),
                    message: schema.name.clone(),
                    cause,
                };
                if is_flat(&schema.name, &schema.data).map_err(broken)? {
                    return double_fields(&schema.name, &schema.data, &channel.metadata)
                        .map(Self::Doubles)
                        .map_err(broken);
                }
                reflected::Survey::of(&schema.name, &schema.data)
                    .map(|survey| Self::Reflected(survey, names))
                    .map_err(broken)
            }
            (encoding, _) => Err(LogError::Encoding {
                path: path.to_owned(),
                topic: channel.topic.clone(),
                expected: "messages encoded as protobuf (with the descriptor as schema) or json",
                found: if schema_encoding.is_empty() {
                    encoding.to_owned()
                } else {
                    format!("{encoding} with schema {schema_encoding}")
                },
            }),
        }
    }

    /// Whether the messages have to be looked at.
    pub(crate) fn needs_messages(&self) -> bool {
        match self {
            Self::Doubles(_) => false,
            Self::Reflected(survey, _) => survey.needs_messages(),
            Self::Json(..) => true,
        }
    }

    /// Looks at a message. One that cannot be decoded tells nothing.
    pub(crate) fn add(&mut self, data: &[u8]) {
        match self {
            Self::Reflected(survey, _) if survey.needs_messages() => survey.add(data),
            Self::Json(survey, _) => survey.add(data),
            Self::Doubles(_) | Self::Reflected(..) => {}
        }
    }

    /// The fields.
    pub(crate) fn fields(self) -> Fields {
        match self {
            Self::Doubles(fields) => Fields {
                signals: fields.iter().map(|field| field.signal.clone()).collect(),
                how: How::Doubles(fields),
            },
            Self::Reflected(survey, names) => {
                let (found, message) = survey.fields();
                let (own, paths): (Vec<_>, _) = found.into_iter().unzip();
                Fields {
                    signals: names.signals(&own),
                    how: How::Reflected(message, paths),
                }
            }
            Self::Json(survey, names) => {
                let (own, paths): (Vec<_>, _) = survey.fields().into_iter().unzip();
                Fields {
                    signals: names.signals(&own),
                    how: How::Json(paths),
                }
            }
        }
    }
}

/// The fields of a channel.
pub(crate) struct Fields {
    /// Names and units, in the order of the schema or of the first messages.
    pub(crate) signals: Vec<Signal>,
    how: How,
}

enum How {
    Doubles(Vec<DoubleField>),
    Reflected(reflected::Message, Vec<reflected::Path>),
    Json(Vec<json::Path>),
}

impl Fields {
    /// Whether the messages are JSON.
    pub(crate) fn is_json(&self) -> bool {
        matches!(self.how, How::Json(_))
    }

    /// A field of a message that is JSON.
    pub(crate) fn json_number(&self, column: usize, message: &serde_json::Value) -> Option<f64> {
        match &self.how {
            How::Json(paths) => json::at(message, paths.get(column)?),
            _ => None,
        }
    }

    /// Reads some of the fields, in this order.
    pub(crate) fn decoder(&self, columns: impl IntoIterator<Item = usize>) -> Decoder {
        let columns = columns.into_iter();
        match &self.how {
            How::Doubles(fields) => {
                let own = columns.map(|index| (fields[index].number, fields[index].absent));
                Decoder::Doubles(gt_mcap::Decoder::new(&own.collect::<Vec<_>>()))
            }
            How::Reflected(message, paths) => Decoder::Reflected(
                message.clone(),
                columns.map(|index| paths[index].clone()).collect(),
            ),
            How::Json(paths) => Decoder::Json(columns.map(|index| paths[index].clone()).collect()),
        }
    }
}

/// Reads fields of messages.
pub(crate) enum Decoder {
    Doubles(gt_mcap::Decoder),
    Reflected(reflected::Message, Vec<reflected::Path>),
    Json(Vec<json::Path>),
}

impl Decoder {
    /// The values of the fields; the error says in words why the message cannot be decoded.
    pub(crate) fn decode(&self, data: &[u8]) -> Result<Vec<Option<f64>>, String> {
        match self {
            Self::Doubles(decoder) => decoder.decode(data).map_err(|cause| cause.to_string()),
            Self::Reflected(message, paths) => message.decode(data, paths),
            Self::Json(paths) => json::decode(data, paths),
        }
    }
}
