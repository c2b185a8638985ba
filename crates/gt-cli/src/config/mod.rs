//! Flag over environment over `--config` file over default.

mod sections;

use std::path::Path;

use serde::Serialize;
use serde::de::DeserializeOwned;
use toml::{Table, Value};

use crate::cli::GlobalArgs;
use crate::failure::Failure;
use crate::toml_text::explained;
pub use sections::{ConfigFile, SECTIONS, Section, check_choices};

/// The options of a verb.
pub trait VerbOptions: Default {
    /// Each entry holds the keys of one kind. A layer that has a key of one kind takes those of the
    /// other kinds out of the layers below; a layer with keys of two kinds is refused.
    const ALTERNATIVES: &'static [&'static [&'static str]] = &[];
    /// The key of a file with values of its own for what is not given: where any layer has it, the
    /// defaults are out of force.
    const BASE_FILE: Option<&'static str> = None;

    /// The options that are in force where nobody gives them.
    fn defaults() -> Self {
        Self::default()
    }
}

/// Lays `given` (flags and environment) over the file's `section` over the defaults.
///
/// Returns `None` after printing the outcome when `--print-config` was given.
///
/// # Errors
/// An unreadable file, an unknown section or key, a value of the wrong type: each names the file.
pub fn layered<T: VerbOptions + Serialize + DeserializeOwned>(
    section: &str,
    given: &T,
    global: &GlobalArgs,
) -> Result<Option<T>, Failure> {
    let (environment, flags): (Table, Table) = to_table(given)?
        .into_iter()
        .partition(|(key, _)| global.from_environment.contains(key));
    let file = match &global.config {
        Some(path) => file_section(path, section)?,
        None => Table::new(),
    };
    let has_base = T::BASE_FILE.is_some_and(|key| {
        [&file, &environment, &flags]
            .iter()
            .any(|layer| layer.contains_key(key))
    });
    let mut table = if has_base {
        Table::new()
    } else {
        to_table(&T::defaults())?
    };
    if let Some(path) = &global.config {
        lay_over::<T>(&mut table, file).map_err(|error| Failure::in_file(path, error))?;
    }
    lay_over::<T>(&mut table, environment)
        .map_err(|error| Failure::input(format!("environment: {error}")))?;
    lay_over::<T>(&mut table, flags).map_err(Failure::input)?;
    if global.print_config {
        let whole = Table::from_iter([(section.to_owned(), Value::Table(table))]);
        crate::output::print(&toml::to_string(&whole).map_err(Failure::failed)?)?;
        return Ok(None);
    }
    table.try_into().map(Some).map_err(Failure::input)
}

/// Lays `upper` over `lower`, alternatives in mind.
fn lay_over<T: VerbOptions>(lower: &mut Table, upper: Table) -> Result<(), String> {
    let mut chosen: Option<(usize, &str)> = None;
    for (kind, keys) in T::ALTERNATIVES.iter().enumerate() {
        for key in keys.iter().copied().filter(|key| upper.contains_key(*key)) {
            match chosen {
                Some((other, first)) if other != kind => {
                    let kinds: Vec<String> = T::ALTERNATIVES.iter().map(|k| options(k)).collect();
                    return Err(format!(
                        "expected one of {}, found --{first} and --{key}",
                        kinds.join(" or ")
                    ));
                }
                _ => chosen = Some((kind, key)),
            }
        }
    }
    if let Some((chosen, _)) = chosen {
        let others = T::ALTERNATIVES
            .iter()
            .enumerate()
            .filter(|(kind, _)| *kind != chosen);
        for key in others.flat_map(|(_, keys)| keys.iter()) {
            lower.remove(*key);
        }
    }
    lower.extend(upper);
    Ok(())
}

fn options(keys: &[&str]) -> String {
    let flags: Vec<String> = keys.iter().map(|key| format!("--{key}")).collect();
    flags.join(" with ")
}

fn to_table<T: Serialize>(args: &T) -> Result<Table, Failure> {
    Table::try_from(args).map_err(Failure::failed)
}

fn file_section(path: &Path, section: &str) -> Result<Table, Failure> {
    let text = std::fs::read_to_string(path).map_err(|error| Failure::in_file(path, error))?;
    let bad = |error: toml::de::Error| {
        Failure::in_file(path, explained(&error, &schemars::schema_for!(ConfigFile)))
    };
    toml::from_str::<ConfigFile>(&text).map_err(bad)?;
    let mut whole: Table = toml::from_str(&text).map_err(bad)?;
    Ok(match whole.remove(section) {
        Some(Value::Table(table)) => table,
        _ => Table::new(),
    })
}
