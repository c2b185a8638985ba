//! Flag over environment over `--config` file over default.

use std::path::Path;

use serde::Serialize;
use serde::de::DeserializeOwned;

use crate::cli::GlobalArgs;
use crate::failure::Failure;

/// The verbs that a configuration file may have a section for.
const SECTIONS: [&str; 5] = ["simulate", "identify", "design", "detect", "reproduce"];

/// Lays `flags` (which hold the environment already) over the file's `section` over `defaults`.
///
/// Returns `None` after printing the outcome when `--print-config` was given.
///
/// # Errors
/// An unreadable file, an unknown section or key, a value of the wrong type: each names the file.
pub fn layered<T: Serialize + DeserializeOwned>(
    section: &str,
    flags: &T,
    defaults: &T,
    global: &GlobalArgs,
) -> Result<Option<T>, Failure> {
    let mut table = to_table(defaults)?;
    if let Some(path) = &global.config {
        table.extend(file_section::<T>(path, section)?);
    }
    table.extend(to_table(flags)?);
    if global.print_config {
        let whole = toml::Table::from_iter([(section.to_owned(), toml::Value::Table(table))]);
        crate::output::print(&toml::to_string(&whole).map_err(Failure::failed)?)?;
        return Ok(None);
    }
    table.try_into().map(Some).map_err(Failure::input)
}

fn to_table<T: Serialize>(args: &T) -> Result<toml::Table, Failure> {
    toml::Table::try_from(args).map_err(Failure::failed)
}

fn file_section<T: Serialize + DeserializeOwned>(
    path: &Path,
    section: &str,
) -> Result<toml::Table, Failure> {
    let text = std::fs::read_to_string(path).map_err(|error| Failure::in_file(path, error))?;
    let mut whole: toml::Table =
        toml::from_str(&text).map_err(|error| Failure::in_file(path, error))?;
    if let Some(unknown) = whole.keys().find(|key| !SECTIONS.contains(&key.as_str())) {
        return Err(Failure::in_file(
            path,
            format!(
                "section [{unknown}]: expected one of {}",
                SECTIONS.join(", ")
            ),
        ));
    }
    match whole.remove(section) {
        None => Ok(toml::Table::new()),
        Some(toml::Value::Table(table)) => {
            // Checked by itself, so that the message can name the file.
            table
                .clone()
                .try_into::<T>()
                .map_err(|error| Failure::in_file(path, format!("section [{section}]: {error}")))?;
            Ok(table)
        }
        Some(other) => Err(Failure::in_file(
            path,
            format!(
                "{section}: expected a table [{section}], found {}",
                other.type_str()
            ),
        )),
    }
}
