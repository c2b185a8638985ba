//! The command line's types: one structure a verb, read by clap and by `--config` alike.
//!
//! Every option is an `Option`, so that flags, environment, file and defaults can be laid over one
//! another (see [`crate::config`]).

mod campaign;
mod config;
mod data;
mod design;
mod detect;
mod identify;
mod log;
mod model;
mod serve;
mod simulate;

use std::collections::BTreeSet;
use std::path::PathBuf;

use clap::builder::RangedU64ValueParser;
use clap::{Args, Parser, Subcommand, ValueEnum};
use schemars::{JsonSchema, Schema, SchemaGenerator, json_schema};
use serde::{Deserialize, Deserializer, Serialize};

use crate::config::VerbOptions;
pub use campaign::CampaignArgs;
pub use config::ConfigCommand;
pub use data::{
    DataArgs, DataCheckArgs, DataCommand, DecimalSign, MissingSamples, ResampleBy, TableLayout,
};
pub use design::{
    DesignArgs, GeneratorKind, PoleCriterion, PoleSearchKind, Statistic, WatchKind, WaveformKind,
};
pub use detect::{DetectArgs, FailOn};
pub use identify::{Criterion, ErrorModel, IdentifyArgs, LeastSquaresSolver, Method, Structure};
pub use log::{ExportArgs, LogCommand, RecoverArgs, TimeFormat};
pub use model::{CheckArgs, ModelCommand};
pub use serve::{LogFormat, LogLevel, ServeArgs};
pub use simulate::SimulateArgs;

/// The largest integer of a TOML file, and so of an option.
const LARGEST: u64 = i64::MAX as u64;

/// Reads a number of things.
fn count() -> RangedU64ValueParser<usize> {
    RangedU64ValueParser::new().range(..=LARGEST)
}

/// Reads an integer such as a seed.
fn integer() -> RangedU64ValueParser<u64> {
    RangedU64ValueParser::new().range(..=LARGEST)
}

/// Reads a list from a configuration file, where a single entry may stand without brackets.
fn one_or_many<'de, D: Deserializer<'de>>(from: D) -> Result<Option<Vec<PathBuf>>, D::Error> {
    #[derive(Deserialize)]
    #[serde(untagged)]
    enum OneOrMany {
        One(PathBuf),
        Many(Vec<PathBuf>),
    }
    Ok(Some(match OneOrMany::deserialize(from)? {
        OneOrMany::One(path) => vec![path],
        OneOrMany::Many(paths) => paths,
    }))
}

/// The schema of such a list.
fn one_or_many_schema(_: &mut SchemaGenerator) -> Schema {
    json_schema!({
        "anyOf": [
            {"type": "string"},
            {"type": "array", "items": {"type": "string"}},
            {"type": "null"}
        ]
    })
}

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
3 done, and --fail-on alarm saw an alarm; 130 stopped by Ctrl-C, to go on from there.")]
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
    /// The verb's options that the environment gave, by their keys in a file.
    #[arg(skip)]
    pub from_environment: BTreeSet<String>,
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
    /// Run many records with drawn faults and say how they are detected
    Campaign(CampaignArgs),
    /// Watch machines: readings in, alarms out, and a page to see them on
    Serve(ServeArgs),
    /// Look into tables of data
    #[command(subcommand)]
    Data(DataCommand),
    /// Look into model files
    #[command(subcommand)]
    Model(ModelCommand),
    /// Look into, check, mend and export MCAP logs
    #[command(subcommand)]
    Log(LogCommand),
    /// Write, check and describe the TOML files that verbs read
    #[command(subcommand)]
    Config(ConfigCommand),
    /// Print a script that completes options in a shell
    ///
    /// Example: gtfdi completions bash > ~/.local/share/bash-completion/completions/gtfdi
    Completions {
        /// The shell
        shell: clap_complete::Shell,
    },
    /// Print the manual page, or write one for every verb
    ///
    /// Example: gtfdi man --out man1
    Man {
        /// Folder of the pages, made where it is missing; without it the main page is printed
        #[arg(long, value_name = "DIR")]
        out: Option<PathBuf>,
    },
}

/// `gtfdi reproduce`.
#[derive(Debug, Clone, Default, Args, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, rename_all = "kebab-case")]
#[command(after_help = "Example: gtfdi reproduce --out out, then open out/index.html")]
pub struct ReproduceArgs {
    /// Folder of the report, made where it is missing [default: out]
    #[arg(long, env = "GTFDI_OUT", value_name = "DIR")]
    pub out: Option<PathBuf>,
    /// Seed of all runs [default: 1]
    #[arg(long, env = "GTFDI_SEED", value_name = "N", value_parser = integer())]
    pub seed: Option<u64>,
    /// Table 10 and the naming of faults with many runs, all levels of noise, both sets of maps and
    /// a varying ambient: a quarter of an hour instead of a minute
    #[arg(long, env = "GTFDI_FULL", num_args = 0..=1, default_missing_value = "true")]
    pub full: Option<bool>,
}

impl VerbOptions for ReproduceArgs {
    fn defaults() -> Self {
        Self {
            out: Some(PathBuf::from("out")),
            seed: Some(1),
            full: Some(false),
        }
    }
}
