//! `gtfdi log info`: what an MCAP log holds.

use std::fmt::Write as _;
use std::path::Path;

use gt_log::{LogInfo, info};
use gtfdi::core::Signal;
use serde::Serialize;

use crate::Outcome;
use crate::cli::GlobalArgs;
use crate::commands::SCHEMA_VERSION;
use crate::failure::Failure;
use crate::output::{number, print, print_json, table};

#[derive(Serialize)]
struct Report<'a> {
    schema_version: u32,
    #[serde(flatten)]
    info: &'a LogInfo,
}

/// A field with its unit.
fn field(signal: &Signal) -> String {
    if signal.unit.is_empty() {
        signal.name.clone()
    } else {
        format!("{} [{}]", signal.name, signal.unit)
    }
}

/// Runs the verb.
pub fn run(file: &Path, global: &GlobalArgs) -> Result<Outcome, Failure> {
    let info = info(file).map_err(Failure::input)?;
    if global.json {
        print_json(&Report {
            schema_version: SCHEMA_VERSION,
            info: &info,
        })?;
        return Ok(Outcome::Done);
    }
    let mut text = format!(
        "{}: {} bytes, {} messages, written by {}\n",
        file.display(),
        info.size_bytes,
        info.messages,
        if info.library.is_empty() {
            "an unnamed library"
        } else {
            &info.library
        }
    );
    let rows: Vec<Vec<String>> = info
        .topics
        .iter()
        .map(|topic| {
            vec![
                topic.topic.clone(),
                topic.encoding.clone(),
                topic.messages.to_string(),
                topic.fields.len().to_string(),
                number(topic.first_s),
                number(topic.last_s),
            ]
        })
        .collect();
    text.push_str(&table(
        &[
            "topic", "encoding", "messages", "fields", "first s", "last s",
        ],
        &rows,
    ));
    // Writing to a string cannot fail.
    for topic in &info.topics {
        let fields: Vec<String> = topic.fields.iter().map(field).collect();
        if !fields.is_empty() {
            let _ = writeln!(text, "{}: {}", topic.topic, fields.join(", "));
        }
    }
    for record in &info.metadata {
        let _ = writeln!(text, "metadata {}", record.name);
        if record.name == "gtfdi.remarks" {
            for (key, remark) in &record.values {
                let _ = writeln!(text, "  {key}: {remark}");
            }
        }
    }
    for attachment in &info.attachments {
        let (name, size) = (&attachment.name, attachment.size_bytes);
        let _ = writeln!(text, "attachment {name} ({size} bytes)");
    }
    print(&text)?;
    Ok(Outcome::Done)
}
