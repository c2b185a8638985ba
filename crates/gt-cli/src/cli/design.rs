//! The options of `gtfdi design`.

use std::path::PathBuf;

use clap::{Args, ValueEnum};
use serde::{Deserialize, Serialize};

use super::{DataArgs, count};
use crate::config::Alternatives;
use crate::row_range::RowRange;

/// Residual generators.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum GeneratorKind {
    /// Output observers, one an output (eq. 22 of the paper)
    Observer,
}

/// Evaluation statistics.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Statistic {
    /// The residual's modulus against a fixed threshold (eq. 26 of the paper)
    Threshold,
}

/// `gtfdi design`.
#[derive(Debug, Clone, Default, Args, Serialize, Deserialize)]
#[serde(deny_unknown_fields, rename_all = "kebab-case")]
#[command(after_help = "\
Example: gtfdi design --model model.json --healthy healthy.mcap --poles 0.7 --margin 1.2 \
--consecutive 6 --out bank.json")]
pub struct DesignArgs {
    /// Model file written by identify
    #[arg(long, env = "GTFDI_MODEL", value_name = "MODEL.json")]
    pub model: Option<PathBuf>,
    /// Healthy record; several with commas, or repeat the option
    #[arg(long, env = "GTFDI_HEALTHY", value_name = "LOG", value_delimiter = ',')]
    pub healthy: Option<Vec<PathBuf>>,
    /// How the healthy records are read.
    #[command(flatten)]
    #[serde(flatten)]
    pub reading: DataArgs,
    /// Rows of each healthy record [default: all]
    #[arg(long, env = "GTFDI_ROWS", value_name = "A:B")]
    pub rows: Option<RowRange>,
    /// Residual generator [default: observer]
    #[arg(long, env = "GTFDI_GENERATOR", value_enum)]
    pub generator: Option<GeneratorKind>,
    /// Observer poles: one for all, one a state, or TAG=POLE for one output [default: the paper's for
    /// the four outputs it watches (0.7, 0.3, 0.4, 0.4), 0.5 for any other, equal for all states]
    #[arg(
        long,
        env = "GTFDI_POLES",
        value_delimiter = ',',
        allow_negative_numbers = true
    )]
    pub poles: Option<Vec<String>>,
    /// Evaluation statistic [default: threshold]
    #[arg(long, env = "GTFDI_STATISTIC", value_enum)]
    pub statistic: Option<Statistic>,
    /// Limit by the share of healthy samples above it
    #[arg(
        long,
        env = "GTFDI_EXCEEDANCE",
        value_name = "SHARE",
        allow_negative_numbers = true
    )]
    pub exceedance: Option<f64>,
    /// Limit as a multiple of the largest healthy residual [default: 1.2]
    #[arg(
        long,
        env = "GTFDI_MARGIN",
        value_name = "FACTOR",
        allow_negative_numbers = true
    )]
    pub margin: Option<f64>,
    /// Limit by the mean time between false alarms, such as 24h or 30min
    #[arg(
        long,
        env = "GTFDI_ARL0",
        value_name = "TIME",
        allow_hyphen_values = true
    )]
    pub arl0: Option<String>,
    /// Samples in a row above the limit that make an alarm [default: 6 with --exceedance, else 1]
    #[arg(long, env = "GTFDI_CONSECUTIVE", value_name = "N", value_parser = count())]
    pub consecutive: Option<usize>,
    /// The bank file to write
    #[arg(long, env = "GTFDI_OUT", value_name = "BANK.json")]
    pub out: Option<PathBuf>,
}

impl Alternatives for DesignArgs {
    const ALTERNATIVES: &'static [&'static [&'static str]] =
        &[&["exceedance"], &["margin"], &["arl0"]];
}
