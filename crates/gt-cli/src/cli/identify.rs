//! The options of `gtfdi identify`.

use std::path::PathBuf;

use clap::{Args, ValueEnum};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::{DataArgs, count, one_or_many, one_or_many_schema};
use crate::config::VerbOptions;
use crate::row_range::RowRange;

/// Identification methods.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Method {
    /// Equation-error least squares: the inputs are exact
    Arx,
    /// Errors in variables, by the Frisch scheme: consistent, quick
    Frisch,
    /// Errors in variables, by maximum likelihood: as accurate as the record allows
    Eiv,
}

impl Method {
    /// Its name on the command line.
    pub fn name(self) -> &'static str {
        match self {
            Self::Arx => "arx",
            Self::Frisch => "frisch",
            Self::Eiv => "eiv",
        }
    }
}

/// How the Frisch scheme chooses among the admissible noise variances.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum, Serialize, Deserialize, JsonSchema)]
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
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Structure {
    /// Guidorzi's canonical form (eq. 7-9 of the paper)
    Canonical,
    /// Lags of every output in every row
    Full,
    /// Lags of the own output only
    Diag,
}

/// What is assumed of the equation errors of several outputs.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum ErrorModel {
    /// Each output is fitted by itself
    Uncorrelated,
    /// All are fitted together, by three-stage least squares
    Correlated,
}

/// How least-squares problems are solved.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum LeastSquaresSolver {
    /// By QR factorisation in blocks of rows
    Qr,
    /// By refinement on long records of moderate condition, where it is faster
    Automatic,
}

/// What is done to a fitted model.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Refinement {
    /// The error of the free run is lowered, where rows that the fit did not see agree
    OutputError,
}

/// `gtfdi identify`.
#[derive(Debug, Clone, Default, Args, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, rename_all = "kebab-case")]
#[command(after_help = "\
Example: gtfdi identify run.mcap --inputs a_v,M_f --outputs q_c --order 8 --nk 0 --out model.json
         gtfdi identify noisy.csv --inputs u --outputs y --method eiv --order 2
         gtfdi identify a.csv b.csv --inputs u --outputs y --order auto --plot orders.svg
         gtfdi identify run.csv --inputs u --outputs y --order 2 --stable --dc-gain y:u=+
         gtfdi identify run.csv --inputs u --outputs y --order 2 --stable --train 0:500 \
--validate 500:1000 --refine output-error")]
pub struct IdentifyArgs {
    /// The record, .csv, .parquet or .mcap; several are fitted together, and no equation reaches from one into
    /// another
    #[arg(value_name = "DATA")]
    #[serde(default, deserialize_with = "one_or_many")]
    #[schemars(schema_with = "one_or_many_schema")]
    pub data: Option<Vec<PathBuf>>,
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
    /// Rows of each record to identify on, 0-based and half open [default: all]
    #[arg(long, visible_alias = "rows", env = "GTFDI_TRAIN", value_name = "A:B")]
    #[serde(alias = "rows")]
    pub train: Option<RowRange>,
    /// Rows of each record to validate on [default: the training rows]
    #[arg(long, env = "GTFDI_VALIDATE", value_name = "A:B")]
    pub validate: Option<RowRange>,
    /// Another record to validate on, in place of --validate
    #[arg(long, env = "GTFDI_HOLDOUT", value_name = "DATA")]
    pub holdout: Option<PathBuf>,
    /// Take the line in time that fits its training rows best out of every channel of every record
    /// (that of all rows out of a hold-out)
    #[arg(long, env = "GTFDI_DETREND", num_args = 0..=1, default_missing_value = "true")]
    pub detrend: Option<bool>,
    /// Method [default: arx]
    #[arg(long, env = "GTFDI_METHOD", value_enum)]
    pub method: Option<Method>,
    /// Criterion of the Frisch scheme [default: yule-walker]
    #[arg(long, env = "GTFDI_CRITERION", value_enum)]
    pub criterion: Option<Criterion>,
    /// Weight of a prior that keeps needless poles of --method eiv off the unit circle: 1 costs next
    /// to nothing, 10 holds those of far too high an order [default: 0]
    #[arg(
        long,
        env = "GTFDI_POLE_PRIOR",
        value_name = "WEIGHT",
        allow_negative_numbers = true
    )]
    pub pole_prior: Option<f64>,
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
    /// The operating point: means, zero, or a value for each channel [default: means]
    #[arg(long, env = "GTFDI_CENTRE", value_name = "means|zero|TAG=VALUE,..")]
    pub centre: Option<String>,
    /// Weight of a penalty on the scaled coefficients: 1 holds each back as much as the record asks
    /// for it [default: 0]
    #[arg(
        long,
        env = "GTFDI_RIDGE",
        value_name = "WEIGHT",
        allow_negative_numbers = true
    )]
    pub ridge: Option<f64>,
    /// Whether the equation errors of several outputs may be correlated [default: uncorrelated]
    #[arg(long, env = "GTFDI_EQUATION_ERRORS", value_enum)]
    pub equation_errors: Option<ErrorModel>,
    /// Solver [default: qr]
    #[arg(long, env = "GTFDI_SOLVER", value_enum)]
    pub solver: Option<LeastSquaresSolver>,
    /// Poles of at most this modulus (0.999 where none is given); structure diag
    #[arg(
        long,
        env = "GTFDI_STABLE",
        value_name = "RADIUS",
        num_args = 0..=1,
        require_equals = true,
        default_missing_value = "0.999",
        allow_negative_numbers = true
    )]
    pub stable: Option<f64>,
    /// What is known of a steady-state gain: its value, a range, or its sign; structure diag
    #[arg(
        long,
        env = "GTFDI_DC_GAIN",
        value_name = "OUTPUT:INPUT=VALUE|LOW..HIGH|+|-",
        value_delimiter = ','
    )]
    pub dc_gain: Option<Vec<String>>,
    /// What to do to the fitted model; it is kept where --validate or --holdout agrees
    #[arg(long, env = "GTFDI_REFINE", value_enum)]
    pub refine: Option<Refinement>,
    /// A chart of the criteria of the orders to write
    #[arg(long, env = "GTFDI_PLOT", value_name = "FILE.svg")]
    pub plot: Option<PathBuf>,
    /// The model file to write
    #[arg(long, env = "GTFDI_OUT", value_name = "MODEL.json")]
    pub out: Option<PathBuf>,
    /// A folder to write a report into: index.html and its figures as SVG and CSV
    #[arg(long, env = "GTFDI_REPORT", value_name = "FOLDER")]
    pub report: Option<PathBuf>,
}

impl VerbOptions for IdentifyArgs {
    const ALTERNATIVES: &'static [&'static [&'static str]] =
        &[&["order"], &["na", "nb"], &["indices"]];

    fn defaults() -> Self {
        Self {
            method: Some(Method::Arx),
            ..Self::default()
        }
    }
}
