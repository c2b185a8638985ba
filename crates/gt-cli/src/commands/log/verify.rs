//! `gtfdi log verify`: whether a log is what the format says it is.

use std::fmt::Write as _;
use std::path::Path;

use gt_log::{Problem, Severity, Verification, verify};
use serde::Serialize;

use crate::Outcome;
use crate::cli::GlobalArgs;
use crate::commands::SCHEMA_VERSION;
use crate::failure::Failure;
use crate::output::{print, print_json, table};

#[derive(Serialize)]
struct Report<'a> {
    schema_version: u32,
    #[serde(flatten)]
    verification: &'a Verification,
}

/// Runs the verb.
pub fn run(file: &Path, global: &GlobalArgs) -> Result<Outcome, Failure> {
    let verification = verify(file).map_err(Failure::input)?;
    if global.json {
        print_json(&Report {
            schema_version: SCHEMA_VERSION,
            verification: &verification,
        })?;
    } else {
        print(&text(&verification))?;
    }
    if verification.sound {
        return Ok(Outcome::Done);
    }
    let damages = |own: &&Problem| own.severity == Severity::Damage;
    let count = verification.problems.iter().filter(damages).count();
    Err(Failure::failed(format!(
        "{}: the log is damaged: {count} problems listed{}; `gtfdi log recover` writes what is sound",
        file.display(),
        more(&verification)
    )))
}

fn more(verification: &Verification) -> String {
    match verification.more_problems {
        0 => String::new(),
        more => format!(" and {more} more"),
    }
}

fn text(verification: &Verification) -> String {
    let mut text = format!(
        "{}: {} bytes, {} messages ({} decoded), {} chunks, {} attachments, {} metadata records, {}\n",
        verification.file,
        verification.size_bytes,
        verification.messages,
        verification.decoded_messages,
        verification.chunks,
        verification.attachments,
        verification.metadata,
        if verification.summary {
            "a summary"
        } else {
            "no summary"
        }
    );
    // Writing to a string cannot fail.
    if !verification.foreign_encodings.is_empty() {
        let _ = writeln!(
            text,
            "not judged: messages encoded as {}",
            verification.foreign_encodings.join(", ")
        );
    }
    if verification.problems.is_empty() {
        text.push_str("no problem\n");
        return text;
    }
    let rows: Vec<Vec<String>> = verification
        .problems
        .iter()
        .map(|problem| {
            vec![
                problem.offset.to_string(),
                match problem.severity {
                    Severity::Damage => "damage",
                    Severity::Remark => "remark",
                }
                .to_owned(),
                problem.kind.word().to_owned(),
                problem.text.clone(),
            ]
        })
        .collect();
    text.push_str(&table(&["at byte", "", "what", "problem"], &rows));
    if verification.more_problems > 0 {
        let _ = writeln!(text, "and {} more", verification.more_problems);
    }
    text
}
