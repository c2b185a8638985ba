//! `gtfdi log export`: a topic of a log as a table.

use std::path::Path;

use gt_log::{ExportOptions, ExportTime, Exported, export};
use serde::Serialize;

use crate::Outcome;
use crate::cli::{ExportArgs, GlobalArgs, TimeFormat};
use crate::commands::SCHEMA_VERSION;
use crate::config::layered;
use crate::failure::Failure;
use crate::output::{print, print_json};
use crate::record::check_out;

#[derive(Serialize)]
struct Report<'a> {
    schema_version: u32,
    file: &'a Path,
    #[serde(flatten)]
    exported: &'a Exported,
    out: &'a Path,
}

/// Runs the verb.
pub fn run(args: &ExportArgs, global: &GlobalArgs) -> Result<Outcome, Failure> {
    let Some(args) = layered("log-export", args, global)? else {
        return Ok(Outcome::Done);
    };
    let file = args
        .file
        .ok_or_else(|| Failure::missing("FILE.mcap", "gtfdi log export run.mcap"))?;
    let out = args
        .out
        .ok_or_else(|| Failure::missing("--out", "--out run.csv"))?;
    check_out(&out, &[&file])?;
    let options = ExportOptions {
        topic: args.topic,
        tags: args.tags.unwrap_or_default(),
        rows: args.rows.map(|rows| rows.0),
        time: match args.time {
            Some(TimeFormat::Seconds) => ExportTime::Seconds,
            Some(TimeFormat::Iso) | None => ExportTime::Iso,
        },
    };
    let exported = export(&file, &out, &options).map_err(super::failure)?;
    if global.json {
        print_json(&Report {
            schema_version: SCHEMA_VERSION,
            file: &file,
            exported: &exported,
            out: &out,
        })?;
    } else {
        print(&format!(
            "{}: {} rows of {} and {} columns of {}\n",
            out.display(),
            exported.rows,
            exported.time,
            exported.columns.len(),
            exported.topic
        ))?;
    }
    Ok(Outcome::Done)
}
