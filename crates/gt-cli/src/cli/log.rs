//! The options of `gtfdi log`.

use std::path::PathBuf;

use clap::{Args, Subcommand};
use serde::{Deserialize, Serialize};

use crate::config::Alternatives;

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
}

/// `gtfdi log recover`.
#[derive(Debug, Clone, Default, Args, Serialize, Deserialize)]
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

impl Alternatives for RecoverArgs {}
