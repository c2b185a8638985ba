//! The options of `gtfdi identify`.

use std::path::PathBuf;

use clap::{Args, ValueEnum};
use serde::{Deserialize, Serialize};

use super::{DataArgs, count};
use crate::config::Alternatives;
use crate::row_range::RowRange;

/// Identification methods.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Method {
    /// Equation-error least squares: the inputs are exact
    Arx,
    /// Errors in variables, by the Frisch scheme: consistent, quick
    Frisch,
    /// Errors in variables, by maximum likelihood: as accurate as the record allows
    Eiv,
}

/// How the Frisch scheme chooses among the admissible noise variances.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Criterion {
    /// The relation holds one sample later too
    Shift,
    /// The residual has the covariances of filtered white noise
    Covariance,
    /// The residual does not depend on older samples
    YuleWalker,
}

/// Model structures.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Structure {
    /// Guidorzi's canonical form (eq. 7-9 of the paper)
    Canonical,
    /// Lags of every output in every row
    Full,
    /// Lags of the own output only
    Diag,
}

/// `gtfdi identify`.
#[derive(Debug, Clone, Default, Args, Serialize, Deserialize)]
#[serde(deny_unknown_fields, rename_all = "kebab-case")]
#[command(after_help = "\
Example: gtfdi identify run.mcap --inputs a_v,M_f --outputs q_c --order 8 --nk 0 --out model.json
         gtfdi identify noisy.csv --inputs u --outputs y --method eiv --order 2")]
pub struct IdentifyArgs {
    /// The record, .csv or .mcap
    #[arg(value_name = "DATA")]
    pub data: Option<PathBuf>,
    /// Input tags, comma separated; globs allowed (xmv*)
    #[arg(long, env = "GTFDI_INPUTS", value_delimiter = ',')]
    pub inputs: Option<Vec<String>>,
    /// Output tags, comma separated; globs allowed
    #[arg(long, env = "GTFDI_OUTPUTS", value_delimiter = ',')]
    pub outputs: Option<Vec<String>>,
    /// How the file is read.
    #[command(flatten)]
    #[serde(flatten)]
    pub reading: DataArgs,
    /// Rows to identify on, 0-based and half open [default: all]
    #[arg(long, visible_alias = "rows", env = "GTFDI_TRAIN", value_name = "A:B")]
    #[serde(alias = "rows")]
    pub train: Option<RowRange>,
    /// Rows to validate on [default: the training rows]
    #[arg(long, env = "GTFDI_VALIDATE", value_name = "A:B")]
    pub validate: Option<RowRange>,
    /// Method [default: arx]
    #[arg(long, env = "GTFDI_METHOD", value_enum)]
    pub method: Option<Method>,
    /// Criterion of the Frisch scheme [default: yule-walker]
    #[arg(long, env = "GTFDI_CRITERION", value_enum)]
    pub criterion: Option<Criterion>,
    /// Structure [default: full; canonical where --indices, or --order with several outputs]
    #[arg(long, env = "GTFDI_STRUCTURE", value_enum)]
    pub structure: Option<Structure>,
    /// Order n, a range 1..12, or auto (1..12 by MDL)
    #[arg(long, env = "GTFDI_ORDER", value_name = "N|A..B|auto")]
    pub order: Option<String>,
    /// Output lags
    #[arg(long, env = "GTFDI_NA", value_parser = count())]
    pub na: Option<usize>,
    /// Input lags, one number or one an input
    #[arg(long, env = "GTFDI_NB", value_delimiter = ',', value_parser = count())]
    pub nb: Option<Vec<usize>>,
    /// Smallest input lag, one number or one an input [default: 1]
    #[arg(long, env = "GTFDI_NK", value_delimiter = ',', value_parser = count())]
    pub nk: Option<Vec<usize>>,
    /// Indices of the canonical structure, one an output
    #[arg(long, env = "GTFDI_INDICES", value_delimiter = ',', value_parser = count())]
    pub indices: Option<Vec<usize>>,
    /// The model file to write
    #[arg(long, env = "GTFDI_OUT", value_name = "MODEL.json")]
    pub out: Option<PathBuf>,
}

impl Alternatives for IdentifyArgs {
    const ALTERNATIVES: &'static [&'static [&'static str]] =
        &[&["order"], &["na", "nb"], &["indices"]];
}
