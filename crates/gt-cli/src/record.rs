//! Records in and files out, with the checks that every verb wants.

use std::ops::Range;
use std::path::Path;

use gt_log::{Imported, LogError, Selection, Warning, read_dataset};

use gtfdi::core::Signal;
use gtfdi::ident::ArxModel;

use crate::cli::DataArgs;
use crate::failure::Failure;
use crate::output::complain;

/// The selection of channels and rows that `reading` and the other options describe.
pub fn selection(
    inputs: Vec<String>,
    outputs: Vec<String>,
    reading: &DataArgs,
    rows: Option<Range<usize>>,
) -> Selection {
    Selection {
        inputs,
        outputs,
        time: reading.time.clone(),
        sample_time_s: reading.sample_time,
        topic: reading.topic.clone(),
        rows,
        ..Selection::default()
    }
}

/// The selection of a model's channels.
pub fn selection_for(
    model: &ArxModel,
    reading: &DataArgs,
    rows: Option<Range<usize>>,
) -> Selection {
    let names = |signals: &[Signal]| signals.iter().map(|signal| signal.name.clone()).collect();
    selection(names(model.inputs()), names(model.outputs()), reading, rows)
}

/// A record and what the user should know of it.
pub struct Read {
    /// The record.
    pub imported: Imported,
    /// The warnings, as they were printed.
    pub warnings: Vec<String>,
}

/// Reads a record and passes its warnings on.
///
/// # Errors
/// As [`read_dataset`].
pub fn read(path: &Path, selection: &Selection) -> Result<Read, LogError> {
    Ok(passed_on(path, read_dataset(path, selection)?, Vec::new()))
}

/// Reads a record for a model or bank, `of`, whose sample time stands in where neither the file
/// nor the options tell one.
///
/// # Errors
/// As [`read_dataset`], and a sample time that is not the model's.
pub fn read_for(
    path: &Path,
    selection: &Selection,
    of: &Path,
    sample_time_s: f64,
) -> Result<Read, Failure> {
    let mut imported = read_dataset(path, selection).map_err(Failure::input)?;
    let mut warnings = Vec::new();
    if imported.warnings.contains(&Warning::TimeInSamples) {
        let with_time = Selection {
            sample_time_s: Some(sample_time_s),
            ..selection.clone()
        };
        imported = read_dataset(path, &with_time).map_err(Failure::input)?;
        warnings.push(format!(
            "no column named time, timestamp or t and no sample time given: that of {} is taken, \
             {sample_time_s} s",
            of.display()
        ));
    }
    Ok(passed_on(path, imported, warnings))
}

fn passed_on(path: &Path, imported: Imported, mut warnings: Vec<String>) -> Read {
    warnings.extend(imported.warnings.iter().map(ToString::to_string));
    for warning in &warnings {
        complain(&format!("warning: {}: {warning}", path.display()));
    }
    Read { imported, warnings }
}

/// Refuses, before any work, an output file that could not be written or that is one of `inputs`.
///
/// # Errors
/// [`Failure::Input`] for an input file, [`Failure::Failed`] for a folder that is missing or a
/// folder in the file's place.
pub fn check_out(out: &Path, inputs: &[&Path]) -> Result<(), Failure> {
    let name = out.display();
    if out.is_dir() {
        let found = format!("{name}: expected a file to write, found a directory");
        return Err(Failure::failed(found));
    }
    match out.parent() {
        Some(folder) if !folder.as_os_str().is_empty() && !folder.is_dir() => {
            return Err(Failure::failed(format!(
                "{name}: expected the folder {}, found none",
                folder.display()
            )));
        }
        _ => {}
    }
    let same = |input: &&&Path| match (out.canonicalize(), input.canonicalize()) {
        (Ok(out), Ok(input)) => out == input,
        _ => false,
    };
    match inputs.iter().find(same) {
        None => Ok(()),
        Some(input) => Err(Failure::input(format!(
            "--out: expected another file than those that are read, found {}",
            input.display()
        ))),
    }
}
