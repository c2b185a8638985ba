//! `gtfdi log recover`: all that is sound in a damaged log.

use std::fmt::Write as _;

use gt_log::{Loss, Recovery, recover};
use serde::Serialize;

use crate::Outcome;
use crate::cli::{GlobalArgs, RecoverArgs};
use crate::commands::SCHEMA_VERSION;
use crate::config::layered;
use crate::failure::Failure;
use crate::output::{number, print, print_json, table};
use crate::record::check_out;

#[derive(Serialize)]
struct Report<'a> {
    schema_version: u32,
    #[serde(flatten)]
    recovery: &'a Recovery,
}

/// Runs the verb.
pub fn run(args: &RecoverArgs, global: &GlobalArgs) -> Result<Outcome, Failure> {
    let Some(args) = layered("log-recover", args, global)? else {
        return Ok(Outcome::Done);
    };
    let file = args
        .file
        .ok_or_else(|| Failure::missing("FILE.mcap", "gtfdi log recover run.mcap.part"))?;
    let out = args
        .out
        .ok_or_else(|| Failure::missing("--out", "--out run.mcap"))?;
    check_out(&out, &[&file])?;
    let recovery = recover(&file, &out).map_err(super::failure)?;
    if global.json {
        print_json(&Report {
            schema_version: SCHEMA_VERSION,
            recovery: &recovery,
        })?;
    } else {
        print(&text(&recovery))?;
    }
    Ok(Outcome::Done)
}

fn text(recovery: &Recovery) -> String {
    let mut text = format!(
        "{}: {} messages, {} metadata records and {} attachments of {}\n",
        recovery.out,
        recovery.messages,
        recovery.metadata.len(),
        recovery.attachments.len(),
        recovery.file
    );
    let first_ns = recovery.topics.iter().filter_map(|own| own.first_ns).min();
    let since = |time_ns: Option<u64>| match (time_ns, first_ns) {
        (Some(time), Some(first)) => {
            number(Some((i128::from(time) - i128::from(first)) as f64 / 1e9))
        }
        _ => number(None),
    };
    let topics: Vec<Vec<String>> = recovery
        .topics
        .iter()
        .map(|own| {
            vec![
                own.topic.clone(),
                own.messages.to_string(),
                since(own.first_ns),
                since(own.last_ns),
            ]
        })
        .collect();
    text.push_str(&table(&["topic", "messages", "first s", "last s"], &topics));
    // Writing to a string cannot fail.
    let undecoded = recovery.undecoded_messages;
    if undecoded > 0 {
        let _ = writeln!(
            text,
            "{undecoded} messages do not decode by their schema; their chunks have the right \
             checksums: they are written as they stand"
        );
    }
    if recovery.sound {
        text.push_str("nothing was lost\n");
        return text;
    }
    if !recovery.closed {
        text.push_str("the end of the file was missing\n");
    }
    let _ = writeln!(
        text,
        "lost: {} of {} bytes",
        recovery.lost_bytes, recovery.size_bytes
    );
    let losses: Vec<Vec<String>> = recovery
        .losses
        .iter()
        .map(|loss: &Loss| {
            vec![
                loss.offset.to_string(),
                loss.bytes.to_string(),
                loss.kind.words().to_owned(),
                since(loss.first_ns),
                since(loss.last_ns),
                loss.cause.clone(),
            ]
        })
        .collect();
    if !losses.is_empty() {
        text.push_str(&table(
            &["at byte", "bytes", "what", "first s", "last s", "cause"],
            &losses,
        ));
    }
    text
}
