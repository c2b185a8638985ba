//! Logs of other writers: JSON, Protobuf of any descriptor, every kind of chunk.

#![allow(clippy::unwrap_used, clippy::panic, reason = "helpers of tests")]

use std::collections::BTreeMap;
use std::fs;
use std::path::Path;

use gt_log::{LogError, Selection, columns, info, read_dataset, verify};
use gtfdi::ident::Missing;
use mcap::records::MessageHeader;
use proptest::prelude::*;
use prost::Message as _;
use prost::encoding as wire;
use prost_types::field_descriptor_proto::{Label, Type};
use prost_types::{
    DescriptorProto, EnumDescriptorProto, EnumValueDescriptorProto, FieldDescriptorProto,
    FileDescriptorProto, FileDescriptorSet, OneofDescriptorProto,
};
use tempfile::tempdir;

/// A schema's name, encoding and text; the encoding of messages.
struct Channel<'a> {
    schema: Option<(&'a str, &'a str, &'a [u8])>,
    encoding: &'a str,
    metadata: BTreeMap<String, String>,
}

fn json() -> Channel<'static> {
    Channel {
        schema: None,
        encoding: "json",
        metadata: BTreeMap::new(),
    }
}

/// A log of one topic `/t` with messages at these log and publish times.
fn log(
    options: mcap::WriteOptions,
    channel: &Channel<'_>,
    messages: &[(u64, u64, Vec<u8>)],
) -> Vec<u8> {
    let mut bytes = std::io::Cursor::new(Vec::new());
    let mut writer = options.create(&mut bytes).unwrap();
    let schema = channel.schema.map_or(0, |(name, encoding, text)| {
        writer.add_schema(name, encoding, text).unwrap()
    });
    let id = writer
        .add_channel(schema, "/t", channel.encoding, &channel.metadata)
        .unwrap();
    for (log_time, publish_time, data) in messages {
        let header = MessageHeader {
            channel_id: id,
            sequence: 0,
            log_time: *log_time,
            publish_time: *publish_time,
        };
        writer.write_to_known_channel(&header, data).unwrap();
    }
    writer.finish().unwrap();
    drop(writer);
    bytes.into_inner()
}

/// Messages a second apart.
fn each_second(messages: impl IntoIterator<Item = Vec<u8>>) -> Vec<(u64, u64, Vec<u8>)> {
    let seconds = (1..).map(|k: u64| k * 1_000_000_000);
    seconds
        .zip(messages)
        .map(|(time, data)| (time, time, data))
        .collect()
}

fn on_disk<T>(bytes: &[u8], work: impl FnOnce(&Path) -> T) -> T {
    let folder = tempdir().unwrap();
    let path = folder.path().join("a.mcap");
    fs::write(&path, bytes).unwrap();
    work(&path)
}

fn select(outputs: &[&str]) -> Selection {
    Selection {
        outputs: outputs.iter().map(|&name| name.to_owned()).collect(),
        topic: Some("/t".to_owned()),
        ..Selection::default()
    }
}

fn names(bytes: &[u8]) -> Result<Vec<String>, LogError> {
    on_disk(bytes, |path| {
        let found = columns(path, Some("/t"))?;
        Ok(found.into_iter().map(|signal| signal.name).collect())
    })
}

/// The bits of a column.
fn column(bytes: &[u8], name: &str, missing: Missing) -> Result<Vec<u64>, String> {
    on_disk(bytes, |path| {
        let selection = Selection {
            missing,
            ..select(&[name])
        };
        match read_dataset(path, &selection) {
            Ok(found) => Ok(found.dataset.y().iter().map(|own| own.to_bits()).collect()),
            Err(error) => {
                let text = error.to_string();
                let prefix = format!("{}: ", path.display());
                Err(text.strip_prefix(&prefix).unwrap_or(&text).to_owned())
            }
        }
    })
}

fn bits(values: &[f64]) -> Vec<u64> {
    values.iter().map(|value| value.to_bits()).collect()
}

#[test]
fn numbers_of_json_have_dotted_names() {
    let first = br#"{"a": {"b": 0.1, "ok": true, "c": {"d": -3}}, "v": [1, {"x": 2.5}, "text"],
        "name": "pump", "none": null}"#;
    let second =
        br#"{"a": {"b": "NaN", "ok": false, "c": {"d": 1e300}}, "v": [4, {"x": 5}], "late": 7}"#;
    let bytes = log(
        mcap::WriteOptions::new(),
        &json(),
        &each_second([first.to_vec(), second.to_vec()]),
    );
    let expected = ["a.b", "a.c.d", "a.ok", "v[0]", "v[1].x", "late"];
    assert_eq!(names(&bytes).unwrap(), expected);
    let read = |name| column(&bytes, name, Missing::Refuse);
    assert_eq!(read("a.c.d"), Ok(bits(&[-3.0, 1e300])));
    assert_eq!(read("a.ok"), Ok(bits(&[1.0, 0.0])));
    assert_eq!(read("v[1].x"), Ok(bits(&[2.5, 5.0])));
    let b = read("a.b").unwrap();
    assert_eq!(b[0], 0.1_f64.to_bits());
    assert!(f64::from_bits(b[1]).is_nan());
    // Absent: an error, or with breaks no value.
    assert_eq!(
        read("late").unwrap_err(),
        "topic `/t`, 0 s: expected a value of `late`, found none"
    );
    let late = column(&bytes, "late", Missing::Break).unwrap();
    assert!(f64::from_bits(late[0]).is_nan());
    assert_eq!(late[1], 7.0_f64.to_bits());
    // The log says the same of itself.
    on_disk(&bytes, |path| {
        let topics = info(path).unwrap().topics;
        let found: Vec<_> = topics[0]
            .fields
            .iter()
            .map(|own| own.name.clone())
            .collect();
        assert_eq!(found, expected);
        assert!(verify(path).unwrap().sound);
    });
}

#[test]
fn a_json_schema_and_units_change_nothing_but_the_units() {
    let text = br#"{"type": "object", "properties": {"p": {"type": "number"}}}"#;
    let units = BTreeMap::from([("units".to_owned(), r#"{"p": "bar"}"#.to_owned())]);
    let channel = Channel {
        schema: Some(("P", "jsonschema", text)),
        encoding: "json",
        metadata: units,
    };
    let messages = each_second([br#"{"p": 1}"#.to_vec(), br#"{"p": 2}"#.to_vec()]);
    let bytes = log(mcap::WriteOptions::new(), &channel, &messages);
    on_disk(&bytes, |path| {
        let found = columns(path, Some("/t")).unwrap();
        assert_eq!(found, [gt_core::Signal::new("p", "bar")]);
    });
    assert_eq!(column(&bytes, "p", Missing::Refuse), Ok(bits(&[1.0, 2.0])));
}

#[test]
fn a_message_that_is_a_number_or_an_array_has_fields() {
    let numbers = each_second([b"1.5".to_vec(), b"2".to_vec()]);
    let bytes = log(mcap::WriteOptions::new(), &json(), &numbers);
    assert_eq!(names(&bytes).unwrap(), ["value"]);
    assert_eq!(
        column(&bytes, "value", Missing::Refuse),
        Ok(bits(&[1.5, 2.0]))
    );
    let arrays = each_second([b"[1, 2]".to_vec(), b"[3, 4]".to_vec()]);
    let bytes = log(mcap::WriteOptions::new(), &json(), &arrays);
    assert_eq!(names(&bytes).unwrap(), ["[0]", "[1]"]);
    assert_eq!(
        column(&bytes, "[1]", Missing::Refuse),
        Ok(bits(&[2.0, 4.0]))
    );
}

fn field(name: &str, number: i32, kind: Type) -> FieldDescriptorProto {
    FieldDescriptorProto {
        name: Some(name.to_owned()),
        number: Some(number),
        label: Some(Label::Optional.into()),
        r#type: Some(kind.into()),
        ..FieldDescriptorProto::default()
    }
}

/// Every scalar type, an enumeration, a nested message, repeated ones, an optional field, a text.
fn descriptor() -> Vec<u8> {
    let scalars = [
        ("double", Type::Double),
        ("float", Type::Float),
        ("int32", Type::Int32),
        ("int64", Type::Int64),
        ("uint32", Type::Uint32),
        ("uint64", Type::Uint64),
        ("sint32", Type::Sint32),
        ("sint64", Type::Sint64),
        ("fixed32", Type::Fixed32),
        ("fixed64", Type::Fixed64),
        ("sfixed32", Type::Sfixed32),
        ("sfixed64", Type::Sfixed64),
        ("bool", Type::Bool),
    ];
    let mut fields: Vec<FieldDescriptorProto> = (1..)
        .zip(scalars)
        .map(|(number, (name, kind))| field(&format!("a_{name}"), number, kind))
        .collect();
    fields.push(FieldDescriptorProto {
        type_name: Some(".stranger.Mode".to_owned()),
        ..field("mode", 14, Type::Enum)
    });
    fields.push(FieldDescriptorProto {
        type_name: Some(".stranger.Inner".to_owned()),
        ..field("inner", 15, Type::Message)
    });
    fields.push(FieldDescriptorProto {
        label: Some(Label::Repeated.into()),
        ..field("list", 16, Type::Float)
    });
    fields.push(FieldDescriptorProto {
        label: Some(Label::Repeated.into()),
        type_name: Some(".stranger.Inner".to_owned()),
        ..field("many", 17, Type::Message)
    });
    fields.push(FieldDescriptorProto {
        proto3_optional: Some(true),
        oneof_index: Some(0),
        ..field("maybe", 18, Type::Double)
    });
    fields.push(field("text", 19, Type::String));
    let outer = DescriptorProto {
        name: Some("Outer".to_owned()),
        field: fields,
        oneof_decl: vec![OneofDescriptorProto {
            name: Some("_maybe".to_owned()),
            ..OneofDescriptorProto::default()
        }],
        ..DescriptorProto::default()
    };
    let inner = DescriptorProto {
        name: Some("Inner".to_owned()),
        field: vec![
            field("x", 1, Type::Double),
            // A message within one of its own kind.
            FieldDescriptorProto {
                type_name: Some(".stranger.Inner".to_owned()),
                ..field("again", 2, Type::Message)
            },
        ],
        ..DescriptorProto::default()
    };
    let value = |name: &str, number| EnumValueDescriptorProto {
        name: Some(name.to_owned()),
        number: Some(number),
        ..EnumValueDescriptorProto::default()
    };
    let file = FileDescriptorProto {
        name: Some("stranger.proto".to_owned()),
        package: Some("stranger".to_owned()),
        syntax: Some("proto3".to_owned()),
        message_type: vec![outer, inner],
        enum_type: vec![EnumDescriptorProto {
            name: Some("Mode".to_owned()),
            value: vec![value("OFF", 0), value("ON", 4)],
            ..EnumDescriptorProto::default()
        }],
        ..FileDescriptorProto::default()
    };
    FileDescriptorSet { file: vec![file] }.encode_to_vec()
}

fn outer(descriptor: &[u8]) -> Channel<'_> {
    Channel {
        schema: Some(("stranger.Outer", "protobuf", descriptor)),
        encoding: "protobuf",
        metadata: BTreeMap::new(),
    }
}

/// A message with a value in every field.
fn full() -> Vec<u8> {
    let mut data = Vec::new();
    wire::double::encode(1, &0.1, &mut data);
    wire::float::encode(2, &0.1, &mut data);
    wire::int32::encode(3, &-3, &mut data);
    wire::int64::encode(4, &-4_000_000_000, &mut data);
    wire::uint32::encode(5, &4_000_000_000, &mut data);
    wire::uint64::encode(6, &(1 << 53), &mut data);
    wire::sint32::encode(7, &-7, &mut data);
    wire::sint64::encode(8, &-8, &mut data);
    wire::fixed32::encode(9, &9, &mut data);
    wire::fixed64::encode(10, &10, &mut data);
    wire::sfixed32::encode(11, &-11, &mut data);
    wire::sfixed64::encode(12, &-12, &mut data);
    wire::bool::encode(13, &true, &mut data);
    wire::int32::encode(14, &4, &mut data);
    let mut inner = Vec::new();
    wire::double::encode(1, &15.5, &mut inner);
    wire::bytes::encode(15, &inner, &mut data);
    wire::float::encode_packed(16, &[0.5, -0.5], &mut data);
    wire::bytes::encode(17, &inner, &mut data);
    wire::double::encode(18, &-0.0, &mut data);
    wire::string::encode(19, &"text".to_owned(), &mut data);
    data
}

#[test]
fn every_numeric_type_of_protobuf_is_read() {
    let descriptor = descriptor();
    let messages = each_second([full(), full()]);
    let bytes = log(mcap::WriteOptions::new(), &outer(&descriptor), &messages);
    let expected: [(&str, f64); 19] = [
        ("a_double", 0.1),
        ("a_float", f64::from(0.1_f32)),
        ("a_int32", -3.0),
        ("a_int64", -4e9),
        ("a_uint32", 4e9),
        ("a_uint64", 9_007_199_254_740_992.0),
        ("a_sint32", -7.0),
        ("a_sint64", -8.0),
        ("a_fixed32", 9.0),
        ("a_fixed64", 10.0),
        ("a_sfixed32", -11.0),
        ("a_sfixed64", -12.0),
        ("a_bool", 1.0),
        ("mode", 4.0),
        ("inner.x", 15.5),
        ("list[0]", 0.5),
        ("list[1]", -0.5),
        ("many[0].x", 15.5),
        ("maybe", -0.0),
    ];
    let all: Vec<&str> = expected.iter().map(|own| own.0).collect();
    assert_eq!(names(&bytes).unwrap(), all);
    for (name, value) in expected {
        let found = column(&bytes, name, Missing::Refuse);
        assert_eq!(found, Ok(bits(&[value, value])), "{name}");
    }
    on_disk(&bytes, |path| {
        let found = verify(path).unwrap();
        assert!(found.sound, "{:?}", found.problems);
        assert_eq!(found.decoded_messages, 2);
    });
}

#[test]
fn an_absent_field_is_zero_or_no_value_as_its_kind_has_it() {
    let descriptor = descriptor();
    let messages = each_second([full(), Vec::new()]);
    let bytes = log(mcap::WriteOptions::new(), &outer(&descriptor), &messages);
    for plain in ["a_double", "a_int32", "a_bool", "mode"] {
        let found = column(&bytes, plain, Missing::Refuse).unwrap();
        assert_eq!(found[1], 0.0_f64.to_bits(), "{plain}");
    }
    for absent in ["maybe", "inner.x", "list[1]", "many[0].x"] {
        assert_eq!(
            column(&bytes, absent, Missing::Refuse).unwrap_err(),
            format!("topic `/t`, 1 s: expected a value of `{absent}`, found none")
        );
        let found = column(&bytes, absent, Missing::Break).unwrap();
        assert!(f64::from_bits(found[1]).is_nan(), "{absent}");
    }
}

#[test]
fn every_kind_of_chunk_and_any_order_gives_the_same() {
    let line = |k: u64| format!("{{\"y\": {k}}}").into_bytes();
    let order = [3, 1, 2, 0, 5, 4];
    let shuffled: Vec<_> = order
        .iter()
        .map(|&k| (k * 1_000_000_000, 0, line(k)))
        .collect();
    for compression in [
        None,
        Some(mcap::Compression::Lz4),
        Some(mcap::Compression::Zstd),
    ] {
        for use_chunks in [true, false] {
            let options = mcap::WriteOptions::new()
                .compression(compression)
                .chunk_size(Some(60))
                .use_chunks(use_chunks);
            let bytes = log(options, &json(), &shuffled);
            let found = column(&bytes, "y", Missing::Refuse);
            assert_eq!(found, Ok(bits(&[0.0, 1.0, 2.0, 3.0, 4.0, 5.0])));
        }
    }
}

#[test]
fn other_encodings_are_refused_by_name() {
    for (encoding, schema, text) in [
        (
            "ros1",
            Some(("std_msgs/Float64", "ros1msg", &b"float64 data"[..])),
            "ros1 with schema ros1msg",
        ),
        (
            "cdr",
            Some(("std_msgs/msg/Float64", "ros2msg", &b"float64 data"[..])),
            "cdr with schema ros2msg",
        ),
        ("flatbuffer", None, "flatbuffer"),
        ("protobuf", None, "protobuf"),
        ("", None, ""),
    ] {
        let channel = Channel {
            schema,
            encoding,
            metadata: BTreeMap::new(),
        };
        let bytes = log(mcap::WriteOptions::new(), &channel, &each_second([vec![0]]));
        let error = column(&bytes, "y", Missing::Refuse).unwrap_err();
        assert_eq!(
            error,
            format!(
                "topic `/t`: expected messages encoded as protobuf (with the descriptor as schema) \
                 or json, found `{text}`"
            )
        );
        let error = names(&bytes).unwrap_err();
        assert!(matches!(error, LogError::Encoding { .. }));
    }
}

#[test]
fn topics_without_a_number_are_named() {
    let bytes = log(
        mcap::WriteOptions::new(),
        &json(),
        &each_second([b"{\"a\": \"b\"}".to_vec()]),
    );
    assert_eq!(
        column(&bytes, "a", Missing::Refuse).unwrap_err(),
        "topic `/t`: expected messages with numbers, found none; `gtfdi log info` lists the fields \
         of every topic"
    );
}

#[test]
fn a_message_that_cannot_be_decoded_is_named_where_it_is_selected() {
    let messages = each_second([
        b"{\"y\": 1}".to_vec(),
        b"{\"y\": ".to_vec(),
        b"{\"y\": 2}".to_vec(),
    ]);
    let bytes = log(mcap::WriteOptions::new(), &json(), &messages);
    assert_eq!(
        column(&bytes, "y", Missing::Refuse).unwrap_err(),
        "topic `/t`, 1 s: expected a message of its schema, found: EOF while parsing a value at \
         line 1 column 6"
    );
}

/// A descriptor whose messages nest without end, or wide and deep, is listed as far as it goes.
#[test]
fn endless_descriptors_end() {
    let message = |k: usize| DescriptorProto {
        name: Some(format!("M{k}")),
        field: (1..=4)
            .map(|number| FieldDescriptorProto {
                type_name: Some(format!(".s.M{}", k + 1)),
                ..field(&format!("f{number}"), number, Type::Message)
            })
            .collect(),
        ..DescriptorProto::default()
    };
    let last = DescriptorProto {
        name: Some("M400".to_owned()),
        field: vec![field("x", 1, Type::Int32)],
        ..DescriptorProto::default()
    };
    let file = FileDescriptorProto {
        name: Some("s.proto".to_owned()),
        package: Some("s".to_owned()),
        syntax: Some("proto3".to_owned()),
        message_type: (0..400).map(message).chain([last]).collect(),
        ..FileDescriptorProto::default()
    };
    let set = FileDescriptorSet { file: vec![file] }.encode_to_vec();
    let channel = Channel {
        schema: Some(("s.M0", "protobuf", &set)),
        encoding: "protobuf",
        metadata: BTreeMap::new(),
    };
    let bytes = log(
        mcap::WriteOptions::new(),
        &channel,
        &each_second([Vec::new()]),
    );
    assert!(matches!(names(&bytes), Err(LogError::NoNumber { .. })));
}

proptest! {
    #[test]
    fn prop_any_json_is_an_answer(text in "[\\[\\]{}\",:0-9a.e-]{0,40}") {
        let bytes = log(mcap::WriteOptions::new(), &json(), &each_second([text.into_bytes()]));
        let _ = names(&bytes);
    }

    #[test]
    fn prop_json_numbers_return_to_the_bit(values in proptest::collection::vec(
        any::<f64>().prop_filter("JSON has no other", |own| own.is_finite()), 2..20)) {
        let lines = values.iter().map(|own| serde_json::to_vec(&serde_json::json!({"y": own})).unwrap());
        let bytes = log(mcap::WriteOptions::new(), &json(), &each_second(lines));
        prop_assert_eq!(column(&bytes, "y", Missing::Refuse), Ok(bits(&values)));
    }

    /// Changed descriptors and messages: no panic, and a text in any error.
    #[test]
    fn prop_changed_protobuf_is_an_answer(
        in_descriptor in proptest::collection::vec((any::<usize>(), any::<u8>()), 0..6),
        in_message in proptest::collection::vec((any::<usize>(), any::<u8>()), 0..6),
    ) {
        let (mut descriptor, mut message) = (descriptor(), full());
        for (place, byte) in in_descriptor {
            let length = descriptor.len();
            descriptor[place % length] = byte;
        }
        for (place, byte) in in_message {
            let length = message.len();
            message[place % length] = byte;
        }
        let bytes = log(
            mcap::WriteOptions::new(),
            &outer(&descriptor),
            &each_second([message, full()]),
        );
        if let Err(error) = names(&bytes) {
            prop_assert!(!error.to_string().is_empty());
        }
        if let Err(error) = column(&bytes, "inner.x", Missing::Break) {
            prop_assert!(!error.is_empty());
        }
        on_disk(&bytes, |path| drop(verify(path).unwrap()));
    }
}
