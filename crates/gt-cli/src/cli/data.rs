//! The options of every verb that reads data.

use std::path::PathBuf;

use clap::{Args, Subcommand, ValueEnum};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::integer;
use crate::config::VerbOptions;

/// How a data file is read.
#[derive(Debug, Clone, Default, Args, Serialize, Deserialize, JsonSchema)]
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
    /// What a missing sample (NaN, an empty cell, a word such as Bad or No Data) does, and a gap in
    /// time [default: error]
    #[arg(long, env = "GTFDI_MISSING", value_enum)]
    pub missing: Option<MissingSamples>,
    /// Further words for a missing sample in number columns, comma separated
    #[arg(
        long,
        env = "GTFDI_BAD_VALUES",
        value_name = "WORDS",
        value_delimiter = ','
    )]
    pub bad_values: Option<Vec<String>>,
    /// Encoding of a CSV file, such as windows-1252 [default: UTF-8, or by a byte-order mark]
    #[arg(long, env = "GTFDI_ENCODING", value_name = "LABEL")]
    pub encoding: Option<String>,
    /// Decimal sign of a CSV file [default: recognised]
    #[arg(long, env = "GTFDI_DECIMAL", value_enum)]
    pub decimal: Option<DecimalSign>,
    /// Line of a CSV file's header, from 1 [default: the first that is not blank]
    #[arg(long, env = "GTFDI_HEADER_LINE", value_name = "N", value_parser = integer())]
    pub header_line: Option<u64>,
    /// A column for each tag, or a row for each reading (tag, time, value and, where there is one,
    /// quality) [default: recognised by the header]
    #[arg(long, env = "GTFDI_LAYOUT", value_enum)]
    pub layout: Option<TableLayout>,
    /// Time zone of times without an offset, such as Europe/Rome [default: UTC]
    #[arg(long, env = "GTFDI_TIME_ZONE", value_name = "ZONE")]
    pub time_zone: Option<String>,
    /// How times are written, such as "%d/%m/%Y %H:%M:%S", or excel for the days of a spreadsheet
    /// [default: recognised]
    #[arg(long, env = "GTFDI_TIME_FORMAT", value_name = "FORMAT")]
    pub time_format: Option<String>,
    /// Make samples of this period in seconds from readings at any times; rows are then samples
    #[arg(
        long,
        env = "GTFDI_RESAMPLE",
        value_name = "S",
        allow_negative_numbers = true
    )]
    pub resample: Option<f64>,
    /// What stands for a sample [default: mean]
    #[arg(long, env = "GTFDI_RESAMPLE_METHOD", value_enum)]
    pub resample_method: Option<ResampleBy>,
    /// Oldest reading that hold takes, and longest step that linear bridges, in seconds
    #[arg(
        long,
        env = "GTFDI_HOLD_AT_MOST",
        value_name = "S",
        allow_negative_numbers = true
    )]
    pub hold_at_most: Option<f64>,
    /// Names, units and ranges of the tags; what is selected goes by the names it gives
    #[arg(long, env = "GTFDI_TAGS", value_name = "TAGS.toml")]
    pub tags: Option<PathBuf>,
}

/// What missing samples and gaps in time do.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum MissingSamples {
    /// The record is refused
    Error,
    /// The record ends before them and another begins after them
    Break,
}

/// Decimal signs.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum DecimalSign {
    /// 1.5
    Point,
    /// 1,5
    Comma,
}

/// What the rows of a table are.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum TableLayout {
    /// A row for each time
    Wide,
    /// A row for each reading
    Long,
}

/// What stands for a sample.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum ResampleBy {
    /// The mean of the readings from its time to before the next one's
    Mean,
    /// The last valid reading
    Hold,
    /// The line between the readings around it
    Linear,
}

/// Verbs on tables of data.
#[derive(Debug, Subcommand)]
pub enum DataCommand {
    /// Say what is in a table or log, all that is wrong with it, and what roles its tags look like
    Check(DataCheckArgs),
}

/// `gtfdi data check`.
#[derive(Debug, Clone, Default, Args, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, rename_all = "kebab-case")]
#[command(after_help = "\
Example: gtfdi data check export.csv --inputs valve --outputs flow,level
         gtfdi data check log.mcap --topic /sensors
         gtfdi data check export.csv --resample 10

Exit codes: 0 done, whatever was found; 2 a file that is neither a table nor a log.")]
pub struct DataCheckArgs {
    /// The table, .csv or .parquet, or log, .mcap
    #[arg(value_name = "DATA")]
    pub data: Option<PathBuf>,
    /// Tags to look at as inputs, comma separated; globs allowed [default: all, as both]
    #[arg(long, env = "GTFDI_INPUTS", value_delimiter = ',')]
    pub inputs: Option<Vec<String>>,
    /// Tags to look at as outputs, comma separated; globs allowed
    #[arg(long, env = "GTFDI_OUTPUTS", value_delimiter = ',')]
    pub outputs: Option<Vec<String>>,
    /// How the table is read.
    #[command(flatten)]
    #[serde(flatten)]
    pub reading: DataArgs,
}

impl VerbOptions for DataCheckArgs {}
