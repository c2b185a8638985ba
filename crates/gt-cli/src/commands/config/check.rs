//! `gtfdi config check`: whether a file is sound.

use std::path::Path;

use serde::Serialize;
use toml::Table;

use crate::Outcome;
use crate::cli::GlobalArgs;
use crate::commands::SCHEMA_VERSION;
use crate::failure::Failure;
use crate::output::{print, print_json};
use crate::toml_kind::TomlKind;

#[derive(Serialize)]
struct Report<'a> {
    schema_version: u32,
    file: &'a Path,
    kind: TomlKind,
    valid: bool,
}

/// Runs the verb.
pub fn check(file: &Path, kind: Option<TomlKind>, global: &GlobalArgs) -> Result<Outcome, Failure> {
    let text = std::fs::read_to_string(file).map_err(|error| Failure::in_file(file, error))?;
    let table: Table = toml::from_str(&text)
        .map_err(|error| Failure::in_file(file, error.to_string().trim_end()))?;
    let kind = match kind {
        Some(kind) => kind,
        None => TomlKind::recognised(&table).map_err(|error| Failure::in_file(file, error))?,
    };
    kind.check(file, &text)
        .map_err(|error| Failure::in_file(file, format!("expected {}: {error}", kind.title())))?;
    if global.json {
        print_json(&Report {
            schema_version: SCHEMA_VERSION,
            file,
            kind,
            valid: true,
        })?;
    } else {
        print(&format!("{}: {}, sound\n", file.display(), kind.title()))?;
    }
    Ok(Outcome::Done)
}
