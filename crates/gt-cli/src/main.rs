//! The `gtfdi` command line: parse, run the verb, say how it ended.
//!
//! Standard output carries the result only; diagnostics and progress go to standard error.

mod cli;
mod commands;
mod config;
mod failure;
mod output;
mod progress;
mod row_range;

use std::process::ExitCode;

use clap::Parser as _;

use crate::cli::{Cli, Command, LogCommand};
use crate::failure::Failure;

/// How a verb that did its work ended.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Outcome {
    /// Done: exit code 0.
    Done,
    /// Done, and what `--fail-on` names was there: exit code 3.
    Found,
}

fn main() -> ExitCode {
    let cli = Cli::parse();
    match run(cli) {
        Ok(Outcome::Done) => ExitCode::SUCCESS,
        Ok(Outcome::Found) => ExitCode::from(3),
        Err(failure) => {
            eprintln!("gtfdi: {}", failure.error());
            ExitCode::from(failure.code())
        }
    }
}

fn run(cli: Cli) -> Result<Outcome, Failure> {
    let global = &cli.global;
    match cli.command {
        Command::Simulate(args) => commands::simulate::run(&args, global),
        Command::Identify(args) => commands::identify::run(&args, global),
        Command::Design(args) => commands::design::run(&args, global),
        Command::Detect(args) => commands::detect::run(&args, global),
        Command::Reproduce(args) => commands::reproduce::run(&args, global),
        Command::Log(LogCommand::Info { file }) => commands::log_info::run(&file, global),
    }
}
