//! A message with readings, in JSON.

use std::borrow::Cow;
use std::collections::BTreeMap;

use serde::{Deserialize, Deserializer};
use serde_json::Value;

use crate::hub::{Batch, Hub};
use crate::pipeline::{Quality, Reading};

/// The largest time that is understood, in seconds since 1970: the year 2200.
const LATEST_S: f64 = 7.26e9;

/// Why a message is not one.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub enum MessageError {
    /// Not JSON, or not of its form.
    #[error("expected an object with `machine`, `time` and `values`, or `tag` and `value`: {0}")]
    Form(String),
    /// A time that is none.
    #[error("time: expected seconds since 1970 or a text like 2026-11-27T04:00:00Z, found {0}")]
    Time(String),
    /// Neither the message nor its topic says which machine, and there are several.
    #[error("machine: expected the name of one of several machines, found none")]
    NoMachine,
    /// There is no such machine.
    #[error("machine: expected one that is configured, found `{0}`")]
    UnknownMachine(String),
}

/// A message: `{"machine": .., "time": .., "values": {tag: value, ..}, "quality": {tag: ..}}` or
/// `{"machine": .., "time": .., "tag": .., "value": .., "quality": ..}`. The machine and the tag may
/// come from the topic; without a time that of the arrival counts.
#[derive(Debug, Default, Deserialize)]
#[serde(default)]
struct Message<'a> {
    #[serde(borrow)]
    machine: Option<Cow<'a, str>>,
    #[serde(borrow)]
    tag: Option<Cow<'a, str>>,
    time: Option<Value>,
    #[serde(deserialize_with = "present")]
    value: Option<Value>,
    values: Option<BTreeMap<String, Value>>,
    quality: Option<Value>,
}

/// A value that is there, null though it may be.
fn present<'de, D: Deserializer<'de>>(from: D) -> Result<Option<Value>, D::Error> {
    Value::deserialize(from).map(Some)
}

/// What a topic says of its messages.
#[derive(Debug, Clone, Copy, Default)]
pub struct Origin<'a> {
    /// The machine.
    pub machine: Option<&'a str>,
    /// The tag.
    pub tag: Option<&'a str>,
}

/// What a message holds.
#[derive(Debug, Clone, PartialEq)]
pub struct Understood {
    /// Its readings.
    pub batch: Batch,
    /// Values of tags that the machine does not have.
    pub unknown: usize,
}

/// Reads a message that arrived at `arrived_ns`.
///
/// A message that is a number or a text alone is the value of its topic's tag.
///
/// # Errors
/// [`MessageError`] says what it was expected to be.
pub fn read(
    hub: &Hub,
    bytes: &[u8],
    origin: Origin,
    arrived_ns: i64,
) -> Result<Understood, MessageError> {
    let message = if origin.tag.is_some() && !starts_object(bytes) {
        let value = serde_json::from_slice(bytes);
        Message {
            value: Some(value.map_err(|cause| MessageError::Form(cause.to_string()))?),
            ..Message::default()
        }
    } else {
        serde_json::from_slice::<Message>(bytes)
            .map_err(|cause| MessageError::Form(cause.to_string()))?
    };
    let name = origin.machine.or(message.machine.as_deref());
    let machine = match name {
        Some(name) => hub
            .machine(name)
            .ok_or_else(|| MessageError::UnknownMachine(shortened(name)))?,
        None if hub.cells.len() == 1 => 0,
        None => return Err(MessageError::NoMachine),
    };
    let time_ns = match &message.time {
        None | Some(Value::Null) => arrived_ns,
        Some(time) => instant_ns(time)?,
    };
    let cell = &hub.cells[machine];
    let mut readings = Vec::new();
    let mut unknown = 0;
    let mut add = |tag: &str, value: &Value, quality: Option<&Value>| match cell.place(tag) {
        Some(tag) => {
            let (value, quality) = reading(value, quality);
            readings.push(Reading {
                tag,
                time_ns,
                value,
                quality,
            });
        }
        None => unknown += 1,
    };
    let tag = origin.tag.or(message.tag.as_deref());
    match (&message.values, tag, &message.value) {
        (Some(values), _, _) => {
            for (tag, value) in values {
                let quality = message.quality.as_ref();
                let own = quality.and_then(|all| {
                    if all.is_object() {
                        all.get(tag)
                    } else {
                        Some(all)
                    }
                });
                add(tag, value, own);
            }
        }
        (None, Some(tag), Some(value)) => add(tag, value, message.quality.as_ref()),
        _ => {
            let lacks = "neither `values` nor `tag` and `value`";
            return Err(MessageError::Form(lacks.to_owned()));
        }
    }
    Ok(Understood {
        batch: Batch {
            machine,
            arrived_ns,
            readings,
        },
        unknown,
    })
}

fn starts_object(bytes: &[u8]) -> bool {
    let first = bytes.iter().find(|byte| !byte.is_ascii_whitespace());
    first == Some(&b'{')
}

/// What is shown of a name from outside.
fn shortened(name: &str) -> String {
    name.chars().take(64).collect()
}

fn instant_ns(time: &Value) -> Result<i64, MessageError> {
    let refuse = || MessageError::Time(shortened(&time.to_string()));
    match time {
        Value::Number(number) => {
            let seconds = number.as_f64().ok_or_else(refuse)?;
            if !(0.0..LATEST_S).contains(&seconds) {
                return Err(refuse());
            }
            // Microseconds: what a double of so many seconds can tell.
            #[allow(clippy::cast_possible_truncation)] // in range
            let us = (seconds * 1e6).round() as i64;
            Ok(us * 1000)
        }
        Value::String(text) => {
            let instant: jiff::Timestamp = text.trim().parse().map_err(|_| refuse())?;
            i64::try_from(instant.as_nanosecond()).map_err(|_| refuse())
        }
        _ => Err(refuse()),
    }
}

fn reading(value: &Value, quality: Option<&Value>) -> (f64, Quality) {
    let number = match value {
        Value::Number(number) => number.as_f64(),
        Value::Bool(on) => Some(f64::from(u8::from(*on))),
        Value::String(text) => text.trim().parse().ok(),
        _ => None,
    };
    let number = number.filter(|number: &f64| number.is_finite());
    let quality = match quality {
        None | Some(Value::Null) => Quality::Good,
        Some(Value::Number(code)) => match code.as_u64() {
            // Classic OPC, whose upper bits say it. (A status of OPC UA is not a number here: its 0 is
            // good, and the classic 0 bad.)
            Some(192..=255) => Quality::Good,
            Some(64..=127) => Quality::Uncertain,
            _ => Quality::Bad,
        },
        Some(Value::String(word)) => match word.trim().to_ascii_lowercase().as_str() {
            "good" | "ok" | "g" => Quality::Good,
            "uncertain" | "questionable" | "u" => Quality::Uncertain,
            _ => Quality::Bad,
        },
        Some(_) => Quality::Bad,
    };
    match number {
        Some(number) => (number, quality),
        None => (f64::NAN, Quality::Bad),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::service::turbine_hub;
    use proptest::prelude::*;

    const NOW_NS: i64 = 1_700_000_000_123_456_789;

    fn read_from(origin: Origin, text: &str) -> Result<Understood, String> {
        read(&turbine_hub(), text.as_bytes(), origin, NOW_NS).map_err(|error| error.to_string())
    }

    fn readings(text: &str) -> Vec<(usize, i64, Option<f64>, Quality)> {
        let understood = read_from(Origin::default(), text).unwrap();
        let readings = understood.batch.readings.into_iter();
        readings
            .map(|own| {
                let value = own.value.is_finite().then_some(own.value);
                (own.tag, own.time_ns, value, own.quality)
            })
            .collect()
    }

    #[test]
    fn both_forms_say_the_same() {
        // Tags of the turbine: a_v, M_f, then q_c, t3, p7, m9.
        let expected = vec![(3, 1_732_680_000_080_000_000, Some(577.5), Quality::Good)];
        let time = "\"time\": 1732680000.08";
        let machine = "\"machine\": \"turbine\"";
        let one = format!("{{{machine}, {time}, \"tag\": \"t3\", \"value\": 577.5}}");
        assert_eq!(readings(&one), expected);
        let all = format!("{{{time}, \"values\": {{\"t3\": 577.5}}}}");
        assert_eq!(readings(&all), expected);
        let text = "{\"time\": \"2024-11-27T04:00:00.08Z\", \"values\": {\"t3\": \"577.5\"}}";
        assert_eq!(readings(text), expected);
        let zone = "{\"time\": \"2024-11-27T05:00:00.08+01:00\", \"values\": {\"t3\": 577.5}}";
        assert_eq!(readings(zone), expected);
        let origin = Origin {
            machine: Some("turbine"),
            tag: Some("t3"),
        };
        let alone = read_from(origin, " 577.5 ").unwrap().batch.readings[0];
        assert_eq!((alone.tag, alone.time_ns), (3, NOW_NS));
        assert_eq!(alone.value.to_bits(), 577.5_f64.to_bits());
    }

    #[test]
    fn what_is_no_value_is_bad_and_kept() {
        let bad = |value: &str, quality: &str| {
            let text = format!("{{\"tag\": \"t3\", \"value\": {value}, \"quality\": {quality}}}");
            let (_, _, value, quality) = readings(&text)[0];
            (value, quality)
        };
        for value in ["null", "\"Bad\"", "\"NaN\"", "[1]", "{}", "\"1,5\""] {
            assert_eq!(bad(value, "null"), (None, Quality::Bad), "{value}");
        }
        for (quality, expected) in [
            ("null", Quality::Good),
            ("\"GOOD\"", Quality::Good),
            ("\"uncertain\"", Quality::Uncertain),
            ("\"comm failure\"", Quality::Bad),
            ("192", Quality::Good),
            ("216", Quality::Good),
            ("64", Quality::Uncertain),
            ("0", Quality::Bad),
            ("-1", Quality::Bad),
            ("[]", Quality::Bad),
        ] {
            assert_eq!(bad("1.0", quality), (Some(1.0), expected), "{quality}");
        }
        assert_eq!(bad("true", "null"), (Some(1.0), Quality::Good));
    }

    #[test]
    fn what_is_no_message_is_refused_with_what_was_expected() {
        let refused = |text: &str| read_from(Origin::default(), text).unwrap_err();
        let form = "expected an object with `machine`, `time` and `values`, or `tag` and `value`: ";
        for text in [
            "",
            "[]",
            "7",
            "{}",
            "{\"values\": 3}",
            "{\"tag\": \"t3\"}",
            "{\"a\": 1",
        ] {
            assert!(refused(text).starts_with(form), "{text}: {}", refused(text));
        }
        assert_eq!(
            refused("{\"machine\": \"gt9\", \"values\": {}}"),
            "machine: expected one that is configured, found `gt9`"
        );
        for time in ["-1", "1e+300", "\"yesterday\"", "[]", "true"] {
            let text = format!("{{\"time\": {time}, \"values\": {{}}}}");
            assert_eq!(
                refused(&text),
                format!(
                    "time: expected seconds since 1970 or a text like 2026-11-27T04:00:00Z, found {time}"
                )
            );
        }
        let understood =
            read_from(Origin::default(), "{\"values\": {\"x\": 1, \"t3\": 2}}").unwrap();
        assert_eq!(
            (understood.unknown, understood.batch.readings.len()),
            (1, 1)
        );
    }

    proptest! {
        /// Whatever comes, there is an answer.
        #[test]
        fn prop_no_bytes_are_too_much(bytes in proptest::collection::vec(any::<u8>(), 0..200)) {
            let _ = read(&turbine_hub(), &bytes, Origin::default(), NOW_NS);
        }

        #[test]
        fn prop_no_text_like_a_message_is_too_much(
            text in "\\{(\"(machine|time|tag|value|values|quality)\":(\"[a-z0-9:.TZ-]{0,24}\"|-?[0-9]{1,20}(e[0-9]{1,4})?|\\{\"t3\":(1|null|\"x\")\\}|null),?){0,5}\\}",
        ) {
            let _ = read(&turbine_hub(), text.as_bytes(), Origin { machine: Some("turbine"), tag: None }, NOW_NS);
        }
    }
}
