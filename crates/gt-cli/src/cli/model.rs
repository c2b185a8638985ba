//! The options of `gtfdi model`.

use std::path::PathBuf;

use clap::{Args, Subcommand};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::{DataArgs, count, one_or_many, one_or_many_schema};
use crate::config::VerbOptions;
use crate::row_range::RowRange;

/// Verbs on model files.
#[derive(Debug, Subcommand)]
pub enum ModelCommand {
    /// Print a model: equations, noise, gains, poles, zeros, realisation
    ///
    /// Example: gtfdi model show model.json
    Show {
        /// Model file written by identify
        #[arg(value_name = "MODEL.json")]
        file: PathBuf,
    },
    /// Check a model by itself and on records, and say what to do
    Check(Box<CheckArgs>),
}

/// `gtfdi model check`.
#[derive(Debug, Clone, Default, Args, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, rename_all = "kebab-case")]
#[command(after_help = "\
Example: gtfdi model check model.json fresh.csv --significance 0.01

Exit codes: 0 done, whatever was found; 2 a file that is no sound model or record.")]
pub struct CheckArgs {
    /// Model file written by identify
    #[arg(value_name = "MODEL.json")]
    pub model: Option<PathBuf>,
    /// Records to check the model on, .csv, .parquet or .mcap
    #[arg(value_name = "DATA")]
    #[serde(default, deserialize_with = "one_or_many")]
    #[schemars(schema_with = "one_or_many_schema")]
    pub data: Option<Vec<PathBuf>>,
    /// How the records are read.
    #[command(flatten)]
    #[serde(flatten)]
    pub reading: DataArgs,
    /// Rows of each record, 0-based and half open [default: all]
    #[arg(long, env = "GTFDI_ROWS", value_name = "A:B")]
    pub rows: Option<RowRange>,
    /// Largest lag of the residual tests, in samples [default: 20, fewer on a short record]
    #[arg(long, env = "GTFDI_LAGS", value_name = "N", value_parser = count())]
    pub lags: Option<usize>,
    /// Rate of false rejections of each residual test [default: 0.01]
    #[arg(
        long,
        env = "GTFDI_SIGNIFICANCE",
        value_name = "RATE",
        allow_negative_numbers = true
    )]
    pub significance: Option<f64>,
}

impl VerbOptions for CheckArgs {}
