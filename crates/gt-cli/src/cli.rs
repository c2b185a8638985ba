//! The command line's types: one structure a verb, read by clap and by `--config` alike.
//!
//! Every option is an `Option`, so that flags, environment, file and defaults can be laid over one
//! another (see [`crate::config`]).

use std::path::PathBuf;

use clap::{Args, Parser, Subcommand, ValueEnum};
use serde::{Deserialize, Serialize};

use crate::row_range::RowRange;

/// Model-based fault diagnosis: simulate, identify, design, detect.
#[derive(Debug, Parser)]
#[command(
    name = "gtfdi",
    version,
    propagate_version = true,
    max_term_width = 100
)]
#[command(after_help = "\
Options can also come from GTFDI_* variables and from --config FILE.toml, in this order: flag, \
environment, file, default. Exit codes: 0 done; 1 failed; 2 usage, configuration or input data; \
3 done, and --fail-on alarm saw an alarm.")]
pub struct Cli {
    /// What every verb understands.
    #[command(flatten)]
    pub global: GlobalArgs,
    /// The verb.
    #[command(subcommand)]
    pub command: Command,
}

/// Options that every verb understands.
#[derive(Debug, Clone, Args)]
pub struct GlobalArgs {
    /// Print one JSON object on standard output instead of a table
    #[arg(long, global = true, env = "GTFDI_JSON", value_parser = clap::builder::FalseyValueParser::new(), action = clap::ArgAction::SetTrue)]
    pub json: bool,
    /// How to show progress on standard error (default: a bar on a terminal, else nothing)
    #[arg(long, global = true, env = "GTFDI_PROGRESS", value_enum)]
    pub progress: Option<ProgressMode>,
    /// Read options from FILE, a section for each verb
    #[arg(long, global = true, env = "GTFDI_CONFIG", value_name = "FILE.toml")]
    pub config: Option<PathBuf>,
    /// Print the options as they would be used, in the format of --config, and stop
    #[arg(long, global = true)]
    pub print_config: bool,
}

/// How progress is shown.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum ProgressMode {
    /// A bar, where standard error is a terminal
    Bar,
    /// A JSON object a line
    Json,
    /// Nothing
    None,
}

/// The verbs.
#[derive(Debug, Subcommand)]
pub enum Command {
    /// Simulate the gas turbine and write an MCAP log
    Simulate(SimulateArgs),
    /// Identify a linear model from a record
    Identify(IdentifyArgs),
    /// Design residual generators and thresholds from a model and healthy records
    Design(DesignArgs),
    /// Run a bank of detectors over a record
    Detect(DetectArgs),
    /// Compute the source paper's tables again, with a report
    Reproduce(ReproduceArgs),
    /// Look into MCAP logs
    #[command(subcommand)]
    Log(LogCommand),
}

/// Verbs on logs.
#[derive(Debug, Subcommand)]
pub enum LogCommand {
    /// Print what a log holds
    ///
    /// Example: gtfdi log info run.mcap --json
    Info {
        /// The log
        #[arg(value_name = "FILE.mcap")]
        file: PathBuf,
    },
}

/// The machine's variants.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Variant {
    /// The monitored prototype: valve angle and fuel, speed held, no power turbine
    Prototype,
}

/// `gtfdi simulate`.
#[derive(Debug, Clone, Default, Args, Serialize, Deserialize)]
#[serde(deny_unknown_fields, rename_all = "kebab-case")]
#[command(after_help = "Example: gtfdi simulate --seconds 60 --seed 3 --out run.mcap")]
pub struct SimulateArgs {
    /// The machine [default: prototype]
    #[arg(long, env = "GTFDI_VARIANT", value_enum)]
    pub variant: Option<Variant>,
    /// Component maps: paper (flat, shows the paper's signature) or axial (usual slopes)
    /// [default: paper]
    #[arg(long, env = "GTFDI_MAP_SET")]
    pub map_set: Option<String>,
    /// Excitation: steady, gentle, standard, lively or wide [default: standard]
    #[arg(long, env = "GTFDI_PROFILE")]
    pub profile: Option<String>,
    /// Sensor noise: none, low (1 % of each signal's deviation) or table8 (the paper's Table 8)
    /// [default: low]
    #[arg(long, env = "GTFDI_NOISE")]
    pub noise: Option<String>,
    /// Faults, one [[fault]] table each
    #[arg(long, env = "GTFDI_FAULTS", value_name = "FILE.toml")]
    pub faults: Option<PathBuf>,
    /// Length of the run in seconds [default: 60]
    #[arg(
        long,
        env = "GTFDI_SECONDS",
        value_name = "S",
        allow_negative_numbers = true
    )]
    pub seconds: Option<f64>,
    /// Seed of excitation and noise [default: 1]
    #[arg(long, env = "GTFDI_SEED", value_name = "N")]
    pub seed: Option<u64>,
    /// Index of the run under this seed [default: 0]
    #[arg(long, env = "GTFDI_RUN_INDEX", value_name = "N")]
    pub run_index: Option<u64>,
    /// RK4 steps a sample of 0.08 s [default: 40]
    #[arg(long, env = "GTFDI_SUBSTEPS", value_name = "N")]
    pub substeps: Option<usize>,
    /// The log to write
    #[arg(long, env = "GTFDI_OUT", value_name = "FILE.mcap")]
    pub out: Option<PathBuf>,
}

/// How a data file is read.
#[derive(Debug, Clone, Default, Args, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub struct DataArgs {
    /// Time column [default: a column named time, t or timestamp]
    #[arg(long, env = "GTFDI_TIME", value_name = "COLUMN")]
    pub time: Option<String>,
    /// Sample time in seconds, in place of a time column
    #[arg(
        long,
        env = "GTFDI_SAMPLE_TIME",
        value_name = "S",
        allow_negative_numbers = true
    )]
    pub sample_time: Option<f64>,
    /// MCAP topic [default: /plant/measured]
    #[arg(long, env = "GTFDI_TOPIC")]
    pub topic: Option<String>,
}

/// Identification methods.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Method {
    /// Equation-error least squares
    Arx,
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
Example: gtfdi identify run.mcap --inputs a_v,M_f --outputs q_c --order 8 --nk 0 --out model.json")]
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
    #[arg(long, env = "GTFDI_TRAIN", value_name = "A:B")]
    pub train: Option<RowRange>,
    /// Rows to validate on [default: the training rows]
    #[arg(long, env = "GTFDI_VALIDATE", value_name = "A:B")]
    pub validate: Option<RowRange>,
    /// Method [default: arx]
    #[arg(long, env = "GTFDI_METHOD", value_enum)]
    pub method: Option<Method>,
    /// Structure [default: full; canonical where --indices, or --order with several outputs]
    #[arg(long, env = "GTFDI_STRUCTURE", value_enum)]
    pub structure: Option<Structure>,
    /// Order n, a range 1..12, or auto (1..12 by MDL)
    #[arg(long, env = "GTFDI_ORDER", value_name = "N|A..B|auto")]
    pub order: Option<String>,
    /// Output lags
    #[arg(long, env = "GTFDI_NA")]
    pub na: Option<usize>,
    /// Input lags, one number or one an input
    #[arg(long, env = "GTFDI_NB", value_delimiter = ',')]
    pub nb: Option<Vec<usize>>,
    /// Smallest input lag, one number or one an input [default: 1]
    #[arg(long, env = "GTFDI_NK", value_delimiter = ',')]
    pub nk: Option<Vec<usize>>,
    /// Canonical indices v_i, one an output
    #[arg(long, env = "GTFDI_INDICES", value_delimiter = ',')]
    pub indices: Option<Vec<usize>>,
    /// The model file to write
    #[arg(long, env = "GTFDI_OUT", value_name = "MODEL.json")]
    pub out: Option<PathBuf>,
}

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
Example: gtfdi design --model model.json --healthy healthy.mcap --poles 0.7 --exceedance 0.01 \
--consecutive 6 --out bank.json")]
pub struct DesignArgs {
    /// Model file written by identify
    #[arg(long, env = "GTFDI_MODEL", value_name = "MODEL.json")]
    pub model: Option<PathBuf>,
    /// Healthy record; repeat for several
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
    /// Observer poles: one for all, one a state, or TAG=POLE for one output [default: the paper's
    /// 0.7, 0.3, 0.4, 0.4 for q_c, t3, p7, m9 and 0.5 for any other tag, equal for all states]
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
    /// Limit by the share of healthy samples above it [default: 0.01]
    #[arg(long, env = "GTFDI_EXCEEDANCE", value_name = "SHARE", conflicts_with_all = ["margin", "arl0"])]
    pub exceedance: Option<f64>,
    /// Limit as a multiple of the largest healthy residual
    #[arg(
        long,
        env = "GTFDI_MARGIN",
        value_name = "FACTOR",
        conflicts_with = "arl0"
    )]
    pub margin: Option<f64>,
    /// Limit by the mean time between false alarms, such as 24h or 30min
    #[arg(long, env = "GTFDI_ARL0", value_name = "TIME")]
    pub arl0: Option<String>,
    /// Samples in a row above the limit that make an alarm [default: 6 with --exceedance, else 1]
    #[arg(long, env = "GTFDI_CONSECUTIVE", value_name = "N")]
    pub consecutive: Option<usize>,
    /// The bank file to write
    #[arg(long, env = "GTFDI_OUT", value_name = "BANK.json")]
    pub out: Option<PathBuf>,
}

/// What turns a finished detection into exit code 3.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum FailOn {
    /// Any alarm
    Alarm,
}

/// `gtfdi detect`.
#[derive(Debug, Clone, Default, Args, Serialize, Deserialize)]
#[serde(deny_unknown_fields, rename_all = "kebab-case")]
#[command(after_help = "\
Example: gtfdi detect --bank bank.json today.csv --json --out verdicts.mcap --fail-on alarm")]
pub struct DetectArgs {
    /// The record, .csv or .mcap
    #[arg(value_name = "DATA")]
    pub data: Option<PathBuf>,
    /// Bank file written by design
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
}

/// `gtfdi reproduce`.
#[derive(Debug, Clone, Default, Args, Serialize, Deserialize)]
#[serde(deny_unknown_fields, rename_all = "kebab-case")]
#[command(after_help = "Example: gtfdi reproduce --out out, then open out/index.html")]
pub struct ReproduceArgs {
    /// Folder of the report, made where it is missing [default: out]
    #[arg(long, env = "GTFDI_OUT", value_name = "DIR")]
    pub out: Option<PathBuf>,
    /// Seed of all runs [default: 1]
    #[arg(long, env = "GTFDI_SEED", value_name = "N")]
    pub seed: Option<u64>,
}
