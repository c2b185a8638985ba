//! The options of `gtfdi serve`.

use std::net::SocketAddr;
use std::path::PathBuf;

use clap::{Args, ValueEnum};

/// `gtfdi serve`.
#[derive(Debug, Clone, Default, Args)]
#[command(after_help = "\
Example: gtfdi serve
         gtfdi serve --config serve.toml --log-format json
         tail -F readings.jsonl | gtfdi serve --config serve.toml --stdin

Without --config the embedded turbine runs, and its page is on a loopback address that is printed. \
Here --config FILE.toml is the service's own file (docs/service.md), not one of sections for verbs. \
The service stops on Ctrl-C and SIGTERM, and loads its detectors again on SIGHUP.")]
pub struct ServeArgs {
    /// Address of the page [default: 127.0.0.1:8471, or a free port]
    #[arg(long, env = "GTFDI_LISTEN", value_name = "ADDRESS:PORT")]
    pub listen: Option<SocketAddr>,
    /// Folder of alarms and snapshots, made where it is missing [default: in memory alone]
    #[arg(long, env = "GTFDI_STATE_DIR", value_name = "DIR")]
    pub state_dir: Option<PathBuf>,
    /// Take readings as lines of JSON from standard input, and stop at its end
    #[arg(long)]
    pub stdin: bool,
    /// How log lines on standard error look [default: text]
    #[arg(long, env = "GTFDI_LOG_FORMAT", value_enum)]
    pub log_format: Option<LogFormat>,
    /// From which level on there are log lines [default: info]
    #[arg(long, env = "GTFDI_LOG_LEVEL", value_enum)]
    pub log_level: Option<LogLevel>,
}

/// How log lines look.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum LogFormat {
    /// For people
    Text,
    /// A JSON object a line
    Json,
}

/// Levels of log lines.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum LogLevel {
    /// What failed
    Error,
    /// What is odd
    Warn,
    /// What happens
    Info,
    /// How it happens
    Debug,
}
