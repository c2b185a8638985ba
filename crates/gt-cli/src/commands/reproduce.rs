//! `gtfdi reproduce`: the source paper's tables again.

use gt_campaign::{Depth, Reproduction, reproduce};

use super::report_folder::check_folder;
use crate::Outcome;
use crate::cli::{GlobalArgs, ReproduceArgs};
use crate::config::layered;
use crate::failure::Failure;
use crate::output::{print, print_json};
use crate::progress::Shown;

/// Runs the verb.
pub fn run(args: &ReproduceArgs, global: &GlobalArgs) -> Result<Outcome, Failure> {
    let Some(args) = layered("reproduce", args, global)? else {
        return Ok(Outcome::Done);
    };
    let out = args
        .out
        .ok_or_else(|| Failure::missing("--out", "--out out"))?;
    check_folder(&out)?;
    let progress = Shown::new(global.progress);
    let depth = if args.full == Some(true) {
        Depth::Full
    } else {
        Depth::Short
    };
    let result: Reproduction =
        reproduce(args.seed.unwrap_or(1), depth, &progress).map_err(Failure::failed)?;
    result.write(&out, &progress).map_err(Failure::failed)?;
    if global.json {
        print_json(&result.tables)?;
    } else {
        print(&result.text())?;
        print(&format!("report: {}\n", out.join("index.html").display()))?;
    }
    Ok(Outcome::Done)
}
