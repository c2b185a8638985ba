//! `gtfdi config init`: a configuration file with every option.

use std::fmt::Write as _;
use std::path::Path;

use clap::{Arg, Command, CommandFactory as _};
use serde::Serialize;
use serde_json::Value;

use crate::Outcome;
use crate::cli::{Cli, GlobalArgs};
use crate::commands::SCHEMA_VERSION;
use crate::config::{SECTIONS, Section};
use crate::failure::Failure;
use crate::output::{print, print_json};
use crate::record::check_out;
use crate::toml_kind::branches;

/// Columns of a comment.
const WIDTH: usize = 98;

#[derive(Serialize)]
struct Report<'a> {
    schema_version: u32,
    sections: Vec<&'static str>,
    /// Where the file is, or none of a text that is printed.
    out: Option<&'a Path>,
    toml: &'a str,
}

/// Runs the verb.
pub fn init(verbs: &[String], out: Option<&Path>, global: &GlobalArgs) -> Result<Outcome, Failure> {
    let is_wanted =
        |section: &&Section| verbs.is_empty() || verbs.iter().any(|verb| verb == section.name);
    let sections: Vec<&Section> = SECTIONS.iter().filter(is_wanted).collect();
    let mut command = Cli::command();
    command.build();
    let mut text = "# Options by verb. Flags go over GTFDI_* variables, these over this file, which goes over the\n\
         # defaults. What stands behind a `#` and has a `=` is an option without a default.\n"
        .to_owned();
    for section in &sections {
        text.push('\n');
        text.push_str(&section_text(section, &command)?);
    }
    if let Some(out) = out {
        check_out(out, &[])?;
        if out.exists() {
            return Err(Failure::input(format!(
                "--out: expected a file that is not there yet, found {}",
                out.display()
            )));
        }
        gt_log::write_atomically(out, text.as_bytes()).map_err(Failure::failed)?;
    }
    let names: Vec<&'static str> = sections.iter().map(|section| section.name).collect();
    if global.json {
        print_json(&Report {
            schema_version: SCHEMA_VERSION,
            sections: names,
            out,
            toml: &text,
        })?;
    } else if let Some(out) = out {
        print(&format!("{}: {}\n", out.display(), names.join(", ")))?;
    } else {
        print(&text)?;
    }
    Ok(Outcome::Done)
}

/// A section with all its options.
fn section_text(section: &Section, command: &Command) -> Result<String, Failure> {
    let verb = verb(command, section.name)
        .ok_or_else(|| Failure::failed(format!("{}: expected a verb, found none", section.name)))?;
    let mut text = format!("# gtfdi {}\n", section.name.replace('-', " "));
    if let Some(base) = section.base_file {
        let line = format!(
            "With {base}, what stands here goes over that file: remove what it is to decide."
        );
        comment(&mut text, &line);
    }
    let _ = writeln!(text, "[{}]", section.name);
    let defaults = (section.defaults)()?;
    let schema = (section.schema)();
    let root = schema.as_value();
    for own in verb.get_arguments().filter(|own| is_option(own)) {
        let key = own.get_id().as_str().replace('_', "-");
        text.push('\n');
        let help = own.get_long_help().or_else(|| own.get_help());
        comment(
            &mut text,
            &help.map(ToString::to_string).unwrap_or_default(),
        );
        comment(&mut text, &names(own));
        if let Some(value) = defaults.get(&key) {
            let _ = writeln!(text, "{key} = {value}");
        } else {
            let property = root.pointer(&format!("/properties/{key}"));
            let _ = writeln!(text, "# {key} = {}", example(own, root, property));
        }
    }
    Ok(text)
}

/// The verb of a section.
fn verb<'a>(command: &'a Command, name: &str) -> Option<&'a Command> {
    command.get_subcommands().find_map(|own| {
        let rest = name.strip_prefix(own.get_name())?;
        match rest.strip_prefix('-') {
            Some(rest) => verb(own, rest),
            None => rest.is_empty().then_some(own),
        }
    })
}

/// Whether an argument can stand in a file.
fn is_option(own: &Arg) -> bool {
    !own.is_global_set() && !matches!(own.get_id().as_str(), "help" | "version")
}

/// How else an option is given.
fn names(own: &Arg) -> String {
    let flag = own.get_long().map(|long| format!("--{long}"));
    let variable = own
        .get_env()
        .map(|name| name.to_string_lossy().into_owned());
    let names: Vec<String> = flag.into_iter().chain(variable).collect();
    if names.is_empty() {
        return "Without a name on the command line.".to_owned();
    }
    format!("Also {}.", names.join(" or "))
}

/// What could stand for an option without a default.
fn example(own: &Arg, root: &Value, property: Option<&Value>) -> String {
    let branches = property
        .map(|property| branches(root, property))
        .unwrap_or_default();
    let is = |kind: &str| {
        branches.iter().any(|branch| match branch.get("type") {
            Some(Value::String(found)) => found == kind,
            Some(Value::Array(found)) => found.iter().any(|found| found == kind),
            _ => false,
        })
    };
    let item_is = |kind: &str| {
        let items = branches.iter().filter_map(|branch| branch.get("items"));
        items
            .into_iter()
            .any(|items| items.get("type").is_some_and(|found| found == kind))
    };
    let value = own
        .get_possible_values()
        .first()
        .map(|value| value.get_name().to_owned());
    let names = own.get_value_names().unwrap_or_default();
    let value = value.unwrap_or_else(|| names.first().map(ToString::to_string).unwrap_or_default());
    let text = toml::Value::String(value).to_string();
    if is("array") {
        let item = [("integer", "1"), ("number", "1.0")];
        let item = item.into_iter().find(|(kind, _)| item_is(kind));
        return format!("[{}]", item.map_or(text.as_str(), |(_, item)| item));
    }
    let plain = [("boolean", "true"), ("integer", "1"), ("number", "1.0")];
    let plain = plain.into_iter().find(|(kind, _)| is(kind));
    plain.map_or(text, |(_, plain)| plain.to_owned())
}

/// A comment, broken into lines.
fn comment(text: &mut String, words: &str) {
    let mut line = String::new();
    for word in words.split_whitespace() {
        if !line.is_empty() && line.len() + 1 + word.len() > WIDTH {
            let _ = writeln!(text, "# {line}");
            line.clear();
        }
        if !line.is_empty() {
            line.push(' ');
        }
        line.push_str(word);
    }
    if !line.is_empty() {
        let _ = writeln!(text, "# {line}");
    }
}
