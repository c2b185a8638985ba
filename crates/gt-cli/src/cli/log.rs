//! The options of `gtfdi log`.

use std::path::PathBuf;

use clap::{Args, Subcommand, ValueEnum};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::config::VerbOptions;
use crate::row_range::RowRange;

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
    /// Compare a log with the format, record by record
    ///
    /// Checksums, lengths, indexes, statistics, definitions and the messages themselves. Exit codes:
    /// 0 sound, remarks or none; 1 damaged.
    ///
    /// Example: gtfdi log verify run.mcap --json
    Verify {
        /// The log
        #[arg(value_name = "FILE.mcap")]
        file: PathBuf,
    },
    /// Write all that is sound in a log that was cut off or changed to a new one
    Recover(RecoverArgs),
    /// Write a topic of a log to a table, .csv or .parquet
    Export(ExportArgs),
}

/// `gtfdi log recover`.
#[derive(Debug, Clone, Default, Args, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, rename_all = "kebab-case")]
#[command(after_help = "\
Example: gtfdi log recover run.mcap.part --out run.mcap

Every message of every chunk that is whole is written, and of a chunk that the end of the file cuts \
off what can be unpacked before the cut, which no checksum covers. A chunk whose checksum does not \
match is left out. Exit codes: 0 done, whatever was lost (the report says what); 2 a file without \
any record of an MCAP log.")]
pub struct RecoverArgs {
    /// The log, which may be a FILE.mcap.part that a crash left behind
    #[arg(value_name = "FILE.mcap")]
    pub file: Option<PathBuf>,
    /// The log to write
    #[arg(long, env = "GTFDI_OUT", value_name = "WHOLE.mcap")]
    pub out: Option<PathBuf>,
}

impl VerbOptions for RecoverArgs {}

/// `gtfdi log export`.
#[derive(Debug, Clone, Default, Args, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, rename_all = "kebab-case")]
#[command(after_help = "\
Example: gtfdi log export run.mcap --topic /plant/measured --out run.csv
         gtfdi log export verdicts.mcap --topic /alarms --out alarms.parquet

The first column is the time. What a message leaves out is an empty cell (null in Parquet), what is \
not valid is NaN. Of JSON each key is a column; what lies deeper is its text, and with --tags a.b a \
number by its name.")]
pub struct ExportArgs {
    /// The log
    #[arg(value_name = "FILE.mcap")]
    pub file: Option<PathBuf>,
    /// MCAP topic [default: /plant/measured]
    #[arg(long, env = "GTFDI_TOPIC")]
    pub topic: Option<String>,
    /// Columns, or patterns such as 't*' [default: all]
    #[arg(
        long,
        env = "GTFDI_TAGS",
        value_name = "TAG,...",
        value_delimiter = ','
    )]
    pub tags: Option<Vec<String>>,
    /// Rows in the order of time, 0-based and half open [default: all]
    #[arg(long, env = "GTFDI_ROWS", value_name = "A:B")]
    pub rows: Option<RowRange>,
    /// How a CSV file has the time; Parquet has an instant in nanoseconds [default: iso]
    #[arg(long, env = "GTFDI_TIME", value_enum)]
    pub time: Option<TimeFormat>,
    /// The table to write
    #[arg(long, env = "GTFDI_OUT", value_name = "FILE.csv|FILE.parquet")]
    pub out: Option<PathBuf>,
}

impl VerbOptions for ExportArgs {
    fn defaults() -> Self {
        Self {
            topic: Some(gt_log::DEFAULT_TOPIC.to_owned()),
            time: Some(TimeFormat::Iso),
            ..Self::default()
        }
    }
}

/// How a CSV file has the time.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum TimeFormat {
    /// ISO 8601 in UTC, to the nanosecond
    Iso,
    /// Seconds since the first message of the topic
    Seconds,
}
