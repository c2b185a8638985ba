//! `gtfdi completions` and `gtfdi man`: what shells and manuals want of the command line.

use std::path::Path;

use clap::CommandFactory as _;
use clap_complete::Shell;
use clap_mangen::Man;
use serde::Serialize;

use super::SCHEMA_VERSION;
use crate::Outcome;
use crate::cli::{Cli, GlobalArgs};
use crate::failure::Failure;
use crate::output::{print, print_json};

/// Prints a script that completes options.
pub fn completions(shell: Shell) -> Result<Outcome, Failure> {
    let mut script = Vec::new();
    clap_complete::generate(shell, &mut Cli::command(), "gtfdi", &mut script);
    print(&String::from_utf8(script).map_err(Failure::failed)?)?;
    Ok(Outcome::Done)
}

#[derive(Serialize)]
struct Report<'a> {
    schema_version: u32,
    out: &'a Path,
    pages: Vec<String>,
}

/// Prints the main page, or writes the pages of all verbs to a folder.
pub fn man(out: Option<&Path>, global: &GlobalArgs) -> Result<Outcome, Failure> {
    let mut command = Cli::command();
    // Sets the names that subcommands go by, such as `gtfdi-log-info`.
    command.build();
    let Some(out) = out else {
        print(&page(&command, "gtfdi")?)?;
        return Ok(Outcome::Done);
    };
    let mut pages = Vec::new();
    collect(&command, "gtfdi", &mut pages)?;
    let bad = |error: std::io::Error| Failure::failed(format!("{}: {error}", out.display()));
    std::fs::create_dir_all(out).map_err(bad)?;
    for (name, text) in &pages {
        gt_log::write_atomically(&out.join(name), text.as_bytes()).map_err(Failure::failed)?;
    }
    let pages: Vec<String> = pages.into_iter().map(|(name, _)| name).collect();
    if global.json {
        print_json(&Report {
            schema_version: SCHEMA_VERSION,
            out,
            pages,
        })?;
    } else {
        print(&format!("{}: {} pages\n", out.display(), pages.len()))?;
    }
    Ok(Outcome::Done)
}

/// The pages of a command and of all below it, with the names of their files.
fn collect(
    command: &clap::Command,
    name: &str,
    pages: &mut Vec<(String, String)>,
) -> Result<(), Failure> {
    pages.push((format!("{name}.1"), page(command, name)?));
    let inner = command.get_subcommands();
    for own in inner.filter(|own| own.get_name() != "help") {
        collect(own, &format!("{name}-{}", own.get_name()), pages)?;
    }
    Ok(())
}

fn page(command: &clap::Command, name: &str) -> Result<String, Failure> {
    let mut text = Vec::new();
    Man::new(command.clone())
        .title(name.to_ascii_uppercase())
        .render(&mut text)
        .map_err(Failure::failed)?;
    String::from_utf8(text).map_err(Failure::failed)
}
