//! The option `--report`: a page with its figures in a folder.

use std::path::{Path, PathBuf};

use gt_campaign::report::Document;
use gt_campaign::reports::Provenance;
use serde::Serialize;
use toml::Table;

use crate::failure::Failure;

/// Refuses a folder that cannot become one, before anything is computed.
///
/// # Errors
/// What is there in its place.
pub fn check_folder(folder: &Path) -> Result<(), Failure> {
    // What is there of the way to it has to be folders.
    match folder.ancestors().find(|own| own.exists()) {
        Some(standing) if !standing.is_dir() => Err(Failure::failed(format!(
            "{}: expected a folder, found a file",
            standing.display()
        ))),
        _ => Ok(()),
    }
}

/// What the foot of a report says: the files with their digests, the options of a verb, warnings.
///
/// # Errors
/// Options that have no form as TOML.
pub fn provenance<'a>(
    files: impl Iterator<Item = (&'a Path, Option<&'a str>)>,
    verb: &str,
    options: &impl Serialize,
    warnings: &[String],
) -> Result<Provenance, Failure> {
    let options = Table::try_from(options).map_err(Failure::failed)?;
    let whole = Table::from_iter([(verb.to_owned(), toml::Value::Table(options))]);
    Ok(Provenance {
        files: files
            .map(|(path, digest)| (path.display().to_string(), digest.map(str::to_owned)))
            .collect(),
        options_toml: toml::to_string(&whole).map_err(Failure::failed)?,
        warnings: warnings.to_vec(),
    })
}

/// Writes a report where one is asked for.
///
/// # Errors
/// What the document refuses, and files that cannot be written.
pub fn write_report(
    folder: Option<&PathBuf>,
    document: impl FnOnce() -> Result<Document, Failure>,
) -> Result<(), Failure> {
    match folder {
        Some(folder) => document()?.write(folder).map_err(Failure::failed),
        None => Ok(()),
    }
}
