//! Protobuf descriptors: made at run time from tags, and read back from a log.

use std::collections::{BTreeMap, HashSet};

use gt_core::Signal;
use prost::Message as _;
use prost_types::field_descriptor_proto::{Label, Type};
use prost_types::{
    DescriptorProto, EnumDescriptorProto, EnumValueDescriptorProto, FieldDescriptorProto,
    FileDescriptorProto, FileDescriptorSet, OneofDescriptorProto,
};

/// The Protobuf package of every message.
pub(crate) const PACKAGE: &str = "gtfdi.v1";
/// Channel metadata: a JSON map from field name to tag.
pub(crate) const TAGS_KEY: &str = "tags";
/// Channel metadata: a JSON map from field name to unit.
pub(crate) const UNITS_KEY: &str = "units";

/// Protobuf keeps these field numbers for itself.
const RESERVED_FIRST: u32 = 19_000;
const RESERVED_COUNT: u32 = 1_000;

/// A Protobuf identifier for every tag, in order.
///
/// A tag that is an identifier already keeps its name. In any other, every character that is no
/// ASCII letter, digit or `_` becomes `_`, and `x` goes before a first character that is no letter
/// (so no field is called like the hidden `oneof` of another, which begins with `_`). Names that
/// are then alike, or have the same JSON name (`a_b` and `aB`), are told apart by `_2`, `_3`, ...
pub(crate) fn identifiers(tags: &[&str]) -> Vec<String> {
    let mut names = vec![String::new(); tags.len()];
    let mut taken = HashSet::new();
    // Tags that can stay as they are choose first.
    for keeps in [true, false] {
        for (name, tag) in names.iter_mut().zip(tags) {
            let safe = safe_identifier(tag);
            if (safe == *tag) == keeps {
                *name = free_name(&safe, &taken);
                taken.insert(json_name(name));
            }
        }
    }
    names
}

fn safe_identifier(tag: &str) -> String {
    let safe: String = tag
        .chars()
        .map(|c| if c.is_ascii_alphanumeric() { c } else { '_' })
        .collect();
    if safe.starts_with(|c: char| c.is_ascii_alphabetic()) {
        safe
    } else {
        format!("x{safe}")
    }
}

fn free_name(wanted: &str, taken: &HashSet<String>) -> String {
    let mut name = wanted.to_owned();
    let mut number = 2_usize;
    while taken.contains(&json_name(&name)) {
        name = format!("{wanted}_{number}");
        number += 1;
    }
    name
}

/// The form in which Protobuf wants the field names of a message to differ: new releases compare
/// the JSON names (`a_b` and `aB` clash), those before 22 without regard to case.
fn json_name(name: &str) -> String {
    name.chars()
        .filter(|&c| c != '_')
        .map(|c| c.to_ascii_lowercase())
        .collect()
}

/// The Protobuf number of field `index`.
fn field_number(index: usize) -> u32 {
    let number = u32::try_from(index).unwrap_or(u32::MAX).saturating_add(1);
    if number < RESERVED_FIRST {
        number
    } else {
        number.saturating_add(RESERVED_COUNT)
    }
}

/// What every field of a message is.
#[derive(Debug, Clone, Copy)]
pub(crate) enum FieldKind {
    /// `optional double`.
    Double,
    /// An optional value of an enumeration: its name and those of its values, the first is 0.
    Enumeration(&'static str, &'static [&'static str]),
}

/// A message of optional fields of one kind.
#[derive(Debug, Clone)]
pub(crate) struct MessageSchema {
    /// `gtfdi.v1.Measured`.
    pub(crate) full_name: String,
    /// The encoded `FileDescriptorSet`.
    pub(crate) descriptor: Vec<u8>,
    /// The field names, in order.
    pub(crate) names: Vec<String>,
    /// The field numbers, in order.
    pub(crate) numbers: Vec<u32>,
}

impl MessageSchema {
    /// The schema of a message with a field for each tag.
    pub(crate) fn new(message: &str, tags: &[&str], kind: FieldKind) -> Self {
        let names = identifiers(tags);
        let numbers: Vec<u32> = (0..tags.len()).map(field_number).collect();
        let field = |(index, name): (usize, &String)| FieldDescriptorProto {
            name: Some(name.clone()),
            number: i32::try_from(numbers[index]).ok(),
            label: Some(Label::Optional.into()),
            r#type: Some(match kind {
                FieldKind::Double => Type::Double.into(),
                FieldKind::Enumeration(..) => Type::Enum.into(),
            }),
            type_name: match kind {
                FieldKind::Double => None,
                FieldKind::Enumeration(name, _) => Some(format!(".{PACKAGE}.{name}")),
            },
            // proto3 `optional` is a oneof with one member.
            oneof_index: i32::try_from(index).ok(),
            proto3_optional: Some(true),
            ..FieldDescriptorProto::default()
        };
        let oneof = |name: &String| OneofDescriptorProto {
            name: Some(format!("_{name}")),
            ..OneofDescriptorProto::default()
        };
        let descriptor = DescriptorProto {
            name: Some(message.to_owned()),
            field: names.iter().enumerate().map(field).collect(),
            oneof_decl: names.iter().map(oneof).collect(),
            ..DescriptorProto::default()
        };
        let file = FileDescriptorProto {
            name: Some(format!("gtfdi/v1/{message}.proto")),
            package: Some(PACKAGE.to_owned()),
            syntax: Some("proto3".to_owned()),
            message_type: vec![descriptor],
            enum_type: match kind {
                FieldKind::Double => Vec::new(),
                FieldKind::Enumeration(name, values) => vec![enumeration(name, values)],
            },
            ..FileDescriptorProto::default()
        };
        Self {
            full_name: format!("{PACKAGE}.{message}"),
            descriptor: FileDescriptorSet { file: vec![file] }.encode_to_vec(),
            names,
            numbers,
        }
    }
}

/// An enumeration whose values are numbered from 0.
fn enumeration(name: &str, values: &[&str]) -> EnumDescriptorProto {
    let value = |(number, name): (i32, &&str)| EnumValueDescriptorProto {
        name: Some((*name).to_owned()),
        number: Some(number),
        ..EnumValueDescriptorProto::default()
    };
    EnumDescriptorProto {
        name: Some(name.to_owned()),
        value: (0..).zip(values).map(value).collect(),
        ..EnumDescriptorProto::default()
    }
}

/// Whether a name may stand for a Protobuf message.
pub(crate) fn is_message_name(name: &str) -> bool {
    name.starts_with(|c: char| c.is_ascii_alphabetic())
        && name.chars().all(|c| c.is_ascii_alphanumeric() || c == '_')
}

/// A `double` field of a message found in a log.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct DoubleField {
    /// The tag and the unit, as far as the log tells them.
    pub(crate) signal: Signal,
    /// The Protobuf number.
    pub(crate) number: u32,
    /// What an absent field means: nothing where the field has presence, else zero.
    pub(crate) absent: Option<f64>,
}

/// Whether the message called `full_name` has nothing but single `double` fields. The error says in
/// words why that cannot be told.
pub(crate) fn is_flat(full_name: &str, descriptor: &[u8]) -> Result<bool, String> {
    let set = FileDescriptorSet::decode(descriptor).map_err(|cause| cause.to_string())?;
    let message = set
        .file
        .iter()
        .find_map(|file| find_message(file.package(), &file.message_type, full_name))
        .ok_or_else(|| "a descriptor without it".to_owned())?;
    Ok(!message.field.is_empty()
        && message
            .field
            .iter()
            .all(|field| field.r#type() == Type::Double && field.label() != Label::Repeated))
}

/// The `double` fields of the message called `full_name`, with tags and units from the channel's
/// metadata. The error says in words why there are none.
pub(crate) fn double_fields(
    full_name: &str,
    descriptor: &[u8],
    metadata: &BTreeMap<String, String>,
) -> Result<Vec<DoubleField>, String> {
    let set = FileDescriptorSet::decode(descriptor).map_err(|cause| cause.to_string())?;
    let (syntax, message) = set
        .file
        .iter()
        .find_map(|file| {
            find_message(file.package(), &file.message_type, full_name)
                .map(|message| (file.syntax(), message))
        })
        .ok_or_else(|| "a descriptor without it".to_owned())?;
    let map = |key: &str| -> BTreeMap<String, String> {
        metadata
            .get(key)
            .and_then(|text| serde_json::from_str(text).ok())
            .unwrap_or_default()
    };
    let (tags, units) = (map(TAGS_KEY), map(UNITS_KEY));
    let mut fields: Vec<DoubleField> = message
        .field
        .iter()
        .filter(|field| field.r#type() == Type::Double && field.label() != Label::Repeated)
        .filter_map(|field| {
            let name = field.name();
            // A plain proto3 field has no presence: an absent one is a zero that was left out.
            let plain =
                syntax == "proto3" && !field.proto3_optional() && field.oneof_index.is_none();
            Some(DoubleField {
                signal: Signal::new(
                    tags.get(name).map_or(name, String::as_str),
                    units.get(name).map_or("", String::as_str),
                ),
                number: u32::try_from(field.number()).ok()?,
                absent: plain.then_some(0.0),
            })
        })
        .collect();
    if fields.is_empty() {
        return Err("no field of type double".to_owned());
    }
    let distinct: HashSet<&str> = fields
        .iter()
        .map(|field| field.signal.name.as_str())
        .collect();
    if distinct.len() < fields.len() {
        // The tags of some other writer: fall back on the names, which Protobuf keeps apart.
        for (field, found) in fields.iter_mut().zip(
            message
                .field
                .iter()
                .filter(|f| f.r#type() == Type::Double && f.label() != Label::Repeated),
        ) {
            found.name().clone_into(&mut field.signal.name);
        }
    }
    Ok(fields)
}

fn find_message<'a>(
    scope: &str,
    messages: &'a [DescriptorProto],
    full_name: &str,
) -> Option<&'a DescriptorProto> {
    messages.iter().find_map(|message| {
        let name = if scope.is_empty() {
            message.name().to_owned()
        } else {
            format!("{scope}.{}", message.name())
        };
        if name == full_name {
            return Some(message);
        }
        // Only a scope that the name lies in can hold it, so a wrong turn is never taken.
        full_name.starts_with(&format!("{name}.")).then_some(())?;
        find_message(&name, &message.nested_type, full_name)
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    #[test]
    fn identifiers_keep_what_they_can_and_tell_the_rest_apart() {
        let tags = [
            "TI-101.PV",
            "TI_101_PV",
            "1st",
            "_x",
            "",
            "Δp",
            "fuel_flow_kg_s",
            "TI 101 PV",
        ];
        assert_eq!(
            identifiers(&tags),
            [
                "TI_101_PV_2",
                "TI_101_PV",
                "x1st",
                "x_x",
                "x",
                "x_p",
                "fuel_flow_kg_s",
                "TI_101_PV_3"
            ]
            .map(str::to_owned)
        );
    }

    #[test]
    fn names_with_one_json_name_are_told_apart() {
        assert_eq!(identifiers(&["a_b", "aB", "ab"]), ["a_b", "aB_2", "ab_3"]);
    }

    #[test]
    fn numbers_skip_the_reserved_block() {
        assert_eq!(field_number(0), 1);
        assert_eq!(field_number(18_998), 18_999);
        assert_eq!(field_number(18_999), 20_000);
    }

    #[test]
    fn descriptor_is_proto3_with_one_hidden_oneof_a_field() {
        let schema = MessageSchema::new("Measured", &["p", "TI-1"], FieldKind::Double);
        let set = FileDescriptorSet::decode(schema.descriptor.as_slice()).unwrap();
        let [file] = set.file.as_slice() else {
            panic!("one file, found {}", set.file.len())
        };
        assert_eq!((file.package(), file.syntax()), ("gtfdi.v1", "proto3"));
        let [message] = file.message_type.as_slice() else {
            panic!("one message")
        };
        assert_eq!(message.name(), "Measured");
        assert_eq!(schema.full_name, "gtfdi.v1.Measured");
        for (index, (field, name)) in message.field.iter().zip(["p", "TI_1"]).enumerate() {
            assert_eq!(field.name(), name);
            assert_eq!(field.number(), i32::try_from(index).unwrap() + 1);
            assert_eq!(field.r#type(), Type::Double);
            assert_eq!(field.label(), Label::Optional);
            assert!(field.proto3_optional());
            let oneof = &message.oneof_decl[usize::try_from(field.oneof_index()).unwrap()];
            assert_eq!(oneof.name(), format!("_{name}"));
        }
        assert_eq!(message.oneof_decl.len(), 2);
    }

    #[test]
    fn plain_proto3_fields_mean_zero_when_absent() {
        let field = |name: &str, number, optional| FieldDescriptorProto {
            name: Some(name.to_owned()),
            number: Some(number),
            label: Some(Label::Optional.into()),
            r#type: Some(Type::Double.into()),
            proto3_optional: Some(optional),
            oneof_index: optional.then_some(0),
            ..FieldDescriptorProto::default()
        };
        let inner = DescriptorProto {
            name: Some("Inner".to_owned()),
            field: vec![field("a", 1, false), field("b", 2, true)],
            ..DescriptorProto::default()
        };
        let outer = DescriptorProto {
            name: Some("Outer".to_owned()),
            nested_type: vec![inner],
            ..DescriptorProto::default()
        };
        let file = FileDescriptorProto {
            package: Some("some.pkg".to_owned()),
            syntax: Some("proto3".to_owned()),
            message_type: vec![outer],
            ..FileDescriptorProto::default()
        };
        let bytes = FileDescriptorSet { file: vec![file] }.encode_to_vec();
        let fields = double_fields("some.pkg.Outer.Inner", &bytes, &BTreeMap::new()).unwrap();
        assert_eq!(
            fields.iter().map(|f| f.absent).collect::<Vec<_>>(),
            [Some(0.0), None]
        );
        let missing = double_fields("some.pkg.Inner", &bytes, &BTreeMap::new());
        assert_eq!(missing, Err("a descriptor without it".to_owned()));
    }

    proptest! {
        #[test]
        fn prop_identifiers_are_valid_and_distinct(
            tags in proptest::collection::vec("\\PC{0,6}", 0..40),
        ) {
            let tags: Vec<&str> = tags.iter().map(String::as_str).collect();
            let names = identifiers(&tags);
            let distinct: HashSet<String> = names.iter().map(|name| json_name(name)).collect();
            prop_assert_eq!(distinct.len(), tags.len());
            prop_assert!(names.iter().all(|name| is_message_name(name)));
        }

        #[test]
        fn prop_any_descriptor_bytes_are_an_answer(
            bytes in proptest::collection::vec(any::<u8>(), 0..200),
        ) {
            let _ = double_fields("gtfdi.v1.Measured", &bytes, &BTreeMap::new());
        }
    }
}
