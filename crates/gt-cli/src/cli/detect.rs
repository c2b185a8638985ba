//! The options of `gtfdi detect`.

use std::path::PathBuf;

use clap::{Args, ValueEnum};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::DataArgs;
use crate::config::VerbOptions;
use crate::row_range::RowRange;

/// What turns a finished detection into exit code 3.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum FailOn {
    /// Any alarm
    Alarm,
}

/// `gtfdi detect`.
#[derive(Debug, Clone, Default, Args, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, rename_all = "kebab-case")]
#[command(after_help = "\
Example: gtfdi detect --bank bank.json today.csv --json --out verdicts.mcap --fail-on alarm")]
pub struct DetectArgs {
    /// The record, .csv, .parquet or .mcap
    #[arg(value_name = "DATA")]
    pub data: Option<PathBuf>,
    /// Bank or isolator written by design; an isolator, of design --faults, names the fault
    #[arg(long, env = "GTFDI_BANK", value_name = "BANK.json")]
    pub bank: Option<PathBuf>,
    /// How the record is read.
    #[command(flatten)]
    #[serde(flatten)]
    pub reading: DataArgs,
    /// Rows of the record [default: all]
    #[arg(long, env = "GTFDI_ROWS", value_name = "A:B")]
    pub rows: Option<RowRange>,
    /// Exit with 3 when there was an alarm
    #[arg(long, env = "GTFDI_FAIL_ON", value_enum)]
    pub fail_on: Option<FailOn>,
    /// A log of residuals, thresholds and alarms to write
    #[arg(long, env = "GTFDI_OUT", value_name = "VERDICTS.mcap")]
    pub out: Option<PathBuf>,
    /// A folder to write a report into: index.html and its figures as SVG and CSV
    #[arg(long, env = "GTFDI_REPORT", value_name = "FOLDER")]
    pub report: Option<PathBuf>,
}

impl VerbOptions for DetectArgs {}
