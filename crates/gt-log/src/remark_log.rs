//! What was remarked on a run, as the topic `/log`.

use serde::Serialize;
use serde_json::json;

use crate::{LogError, LogWriter};

/// How grave a remark is, as `foxglove.Log` counts.
const WARNING: u8 = 3;

/// A message of `foxglove.Log`.
#[derive(Serialize)]
struct Remark<'a> {
    timestamp: Timestamp,
    level: u8,
    message: &'a str,
    name: &'a str,
    file: &'a str,
    line: u32,
}

/// A time since 1970.
#[derive(Serialize)]
struct Timestamp {
    sec: u64,
    nsec: u64,
}

/// The JSON Schema of `foxglove.Log`.
fn schema() -> serde_json::Value {
    json!({
        "title": "foxglove.Log",
        "description": "A log message",
        "type": "object",
        "properties": {
            "timestamp": {
                "type": "object",
                "title": "time",
                "properties": {
                    "sec": {"type": "integer", "minimum": 0},
                    "nsec": {"type": "integer", "minimum": 0, "maximum": 999_999_999}
                }
            },
            "level": {
                "title": "foxglove.LogLevel",
                "oneOf": [
                    {"title": "UNKNOWN", "const": 0},
                    {"title": "DEBUG", "const": 1},
                    {"title": "INFO", "const": 2},
                    {"title": "WARNING", "const": 3},
                    {"title": "ERROR", "const": 4},
                    {"title": "FATAL", "const": 5}
                ]
            },
            "message": {"type": "string"},
            "name": {"type": "string"},
            "file": {"type": "string"},
            "line": {"type": "integer", "minimum": 0}
        }
    })
}

/// Writes remarks as warnings of the time of the first sample; without any there is no topic.
pub(crate) fn write_remarks<'a>(
    log: &mut LogWriter,
    remarks: impl IntoIterator<Item = &'a str>,
    time_ns: u64,
    asset: &str,
) -> Result<(), LogError> {
    let mut remarks = remarks.into_iter().peekable();
    if remarks.peek().is_none() {
        return Ok(());
    }
    let topic = log.add_json_schema("/log", "foxglove.Log", &schema(), asset)?;
    for message in remarks {
        let remark = Remark {
            timestamp: Timestamp {
                sec: time_ns / 1_000_000_000,
                nsec: time_ns % 1_000_000_000,
            },
            level: WARNING,
            message,
            name: asset,
            file: "",
            line: 0,
        };
        log.write_json(topic, time_ns, &remark)?;
    }
    Ok(())
}
