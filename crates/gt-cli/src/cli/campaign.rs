//! The options of `gtfdi campaign`.

use std::path::PathBuf;

use clap::Args;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::integer;
use crate::config::VerbOptions;

/// `gtfdi campaign`.
#[derive(Debug, Clone, Default, Args, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, rename_all = "kebab-case")]
#[command(after_help = "\
Example: gtfdi campaign drift.toml --out drift
         gtfdi campaign drift.toml --out drift --only 17
         gtfdi campaign --compare quiet,noisy --out compared

The same command goes on where Ctrl-C, a kill or a full disk ended it. The folder then has \
rows.parquet (a row a run), summary.json and report.html. RAYON_NUM_THREADS limits the cores; the \
rows are the same bits whatever their number. Exit code 130: stopped by Ctrl-C.")]
pub struct CampaignArgs {
    /// What is run: runs, plant, records, faults and the bank that judges
    #[arg(value_name = "SPEC.toml")]
    pub spec: Option<PathBuf>,
    /// Folder of the campaign or of the comparison, made where it is missing
    #[arg(long, env = "GTFDI_OUT", value_name = "DIR")]
    pub out: Option<PathBuf>,
    /// Run this index alone and print its row as JSON; nothing is written, and --out lends its bank
    #[arg(long, value_name = "INDEX", value_parser = integer())]
    pub only: Option<u64>,
    /// Folders of finished campaigns to put side by side in --out, in place of a run
    #[arg(long, value_name = "DIR", value_delimiter = ',', conflicts_with_all = ["spec", "only"])]
    pub compare: Option<Vec<PathBuf>>,
}

impl VerbOptions for CampaignArgs {}
