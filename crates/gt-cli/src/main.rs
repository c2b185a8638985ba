//! The `gtfdi` command line: parse, run the verb, say how it ended.
//!
//! Standard output carries the result only; diagnostics and progress go to standard error.

mod cli;
mod commands;
mod config;
mod failure;
mod output;
mod progress;
mod record;
mod row_range;
mod scenario;
mod toml_kind;
mod toml_text;

use std::collections::BTreeSet;
use std::process::ExitCode;

use clap::parser::ValueSource;
use clap::{ArgMatches, CommandFactory as _, FromArgMatches as _};

use crate::cli::{Cli, Command, ConfigCommand, DataCommand, LogCommand, ModelCommand};
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
    match run(parse()) {
        Ok(Outcome::Done) => ExitCode::SUCCESS,
        Ok(Outcome::Found) => ExitCode::from(3),
        Err(failure) => {
            output::complain(&failure.error().to_string());
            ExitCode::from(failure.code())
        }
    }
}

/// The command line, with a note of what came from the environment. A mistake ends the process
/// with exit code 2.
fn parse() -> Cli {
    let mut command = Cli::command();
    let matches = command.get_matches_mut();
    let mut cli =
        Cli::from_arg_matches(&matches).unwrap_or_else(|error| error.format(&mut command).exit());
    cli.global.from_environment = from_environment(&matches);
    cli
}

/// The options of the verb that the environment gave, by their keys in a file.
fn from_environment(matches: &ArgMatches) -> BTreeSet<String> {
    let Some((_, mut verb)) = matches.subcommand() else {
        return BTreeSet::new();
    };
    while let Some((_, inner)) = verb.subcommand() {
        verb = inner;
    }
    verb.ids()
        .map(clap::Id::as_str)
        .filter(|id| verb.value_source(id) == Some(ValueSource::EnvVariable))
        .map(|id| id.replace('_', "-"))
        .collect()
}

fn run(cli: Cli) -> Result<Outcome, Failure> {
    let global = &cli.global;
    match cli.command {
        Command::Simulate(args) => commands::simulate::run(&args, global),
        Command::Identify(args) => commands::identify::run(&args, global),
        Command::Design(args) => commands::design::run(&args, global),
        Command::Detect(args) => commands::detect::run(&args, global),
        Command::Reproduce(args) => commands::reproduce::run(&args, global),
        Command::Campaign(args) => commands::campaign::run(&args, global),
        Command::Serve(args) => commands::serve::run(&args, global),
        Command::Data(DataCommand::Check(args)) => commands::data_check::run(&args, global),
        Command::Model(ModelCommand::Show { file }) => commands::model::show(&file, global),
        Command::Model(ModelCommand::Check(args)) => commands::model::check(&args, global),
        Command::Log(LogCommand::Info { file }) => commands::log::info::run(&file, global),
        Command::Log(LogCommand::Verify { file }) => commands::log::verify::run(&file, global),
        Command::Log(LogCommand::Recover(args)) => commands::log::recover::run(&args, global),
        Command::Log(LogCommand::Export(args)) => commands::log::export::run(&args, global),
        Command::Config(ConfigCommand::Init { verbs, out }) => {
            commands::config::init(&verbs, out.as_deref(), global)
        }
        Command::Config(ConfigCommand::Check { file, kind }) => {
            commands::config::check(&file, kind, global)
        }
        Command::Config(ConfigCommand::Schema { kind }) => commands::config::schema(kind),
        Command::Completions { shell } => commands::shell::completions(shell),
        Command::Man { out } => commands::shell::man(out.as_deref(), global),
    }
}
