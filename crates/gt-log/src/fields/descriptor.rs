//! The messages of a descriptor, with what is needed to find the numbers in them.
//!
//! `prost-reflect` reads any sound descriptor, but panics on some broken ones (0.16.5, a span of no
//! numbers in the source information); a log may hold any bytes.

use std::collections::{BTreeMap, HashMap};

use prost::Message as _;
use prost_types::field_descriptor_proto::{Label, Type};
use prost_types::{DescriptorProto, FieldDescriptorProto, FileDescriptorSet};

/// The messages of a descriptor.
#[derive(Debug, Default)]
pub(super) struct Descriptor {
    messages: Vec<Message>,
    places: HashMap<String, usize>,
}

/// A message.
#[derive(Debug, Default)]
pub(super) struct Message {
    /// In the order of the descriptor.
    pub(super) fields: Vec<Field>,
    numbers: BTreeMap<u32, usize>,
}

/// A field of a message.
#[derive(Debug, Clone)]
pub(super) struct Field {
    pub(super) name: String,
    pub(super) number: u32,
    pub(super) kind: Kind,
    pub(super) repeated: bool,
    /// What an absent field means: nothing where the field has presence, else zero.
    pub(super) absent: Option<f64>,
    /// The fields of which one at most has a value.
    pub(super) oneof: Option<i32>,
}

/// What a field holds.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Kind {
    /// A number, a truth value or an enumeration.
    Number(Type),
    /// A message, by its place in the descriptor.
    Message(usize),
}

impl Descriptor {
    /// Reads an encoded set of descriptors.
    pub(super) fn of(bytes: &[u8]) -> Result<Self, String> {
        let set = FileDescriptorSet::decode(bytes).map_err(|cause| cause.to_string())?;
        let mut found = Vec::new();
        for file in &set.file {
            let scope = match file.package() {
                "" => String::new(),
                package => format!(".{package}"),
            };
            collect(&scope, &file.message_type, file.syntax(), &mut found);
        }
        let mut descriptor = Self::default();
        let mut entries = Vec::new();
        for (place, (name, message, _)) in found.iter().enumerate() {
            // Of two messages of one name the first counts.
            descriptor.places.entry(name.clone()).or_insert(place);
            let is_map = message
                .options
                .as_ref()
                .is_some_and(prost_types::MessageOptions::map_entry);
            entries.push(is_map);
        }
        for (_, message, syntax) in &found {
            let mut own = Message::default();
            for field in &message.field {
                if let Some(field) = descriptor.field(field, syntax, &entries) {
                    own.numbers.insert(field.number, own.fields.len());
                    own.fields.push(field);
                }
            }
            descriptor.messages.push(own);
        }
        Ok(descriptor)
    }

    /// The place of a message by its full name.
    pub(super) fn place(&self, full_name: &str) -> Option<usize> {
        self.places.get(&format!(".{full_name}")).copied()
    }

    pub(super) fn message(&self, place: usize) -> Option<&Message> {
        self.messages.get(place)
    }

    /// A field that holds numbers or messages that may.
    fn field(&self, field: &FieldDescriptorProto, syntax: &str, maps: &[bool]) -> Option<Field> {
        let kind = match field.r#type() {
            Type::String | Type::Bytes | Type::Group => return None,
            Type::Message => {
                let place = *self.places.get(field.type_name())?;
                if maps.get(place).copied().unwrap_or(false) {
                    return None;
                }
                Kind::Message(place)
            }
            other => Kind::Number(other),
        };
        let repeated = field.label() == Label::Repeated;
        // A plain proto3 field has no presence: an absent one is a zero that was left out.
        let plain = syntax == "proto3"
            && !field.proto3_optional()
            && field.oneof_index.is_none()
            && !repeated
            && matches!(kind, Kind::Number(_));
        Some(Field {
            name: field.name().to_owned(),
            number: u32::try_from(field.number()).ok()?,
            kind,
            repeated,
            absent: plain.then_some(0.0),
            oneof: field.oneof_index,
        })
    }
}

impl Message {
    /// The field of a number.
    pub(super) fn numbered(&self, number: u32) -> Option<&Field> {
        self.fields.get(*self.numbers.get(&number)?)
    }
}

/// Every message with its full name, those within others too. How deep they lie is limited where
/// they are decoded.
fn collect<'a>(
    scope: &str,
    messages: &'a [DescriptorProto],
    syntax: &'a str,
    found: &mut Vec<(String, &'a DescriptorProto, &'a str)>,
) {
    for message in messages {
        let name = format!("{scope}.{}", message.name());
        found.push((name.clone(), message, syntax));
        collect(&name, &message.nested_type, syntax, found);
    }
}
