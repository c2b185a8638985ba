//! Records in and files out, with the checks that every verb wants.

use std::ops::Range;
use std::path::Path;

use gt_log::{
    CellProblem, Decimal, Imported, Layout, LogError, Reading, Resample, ResampleMethod, Selection,
    TagMap, Warning, read_dataset,
};

use gtfdi::core::{Dataset, Signal};
use gtfdi::ident::{ArxModel, Missing, unbroken};

use crate::cli::{DataArgs, DecimalSign, MissingSamples, ResampleBy, TableLayout};
use crate::failure::Failure;
use crate::output::complain;

/// The selection of channels and rows that `reading` and the other options describe.
///
/// # Errors
/// A file of tags that cannot be read, options that need another.
pub fn selection(
    inputs: Vec<String>,
    outputs: Vec<String>,
    reading: &DataArgs,
    rows: Option<Range<usize>>,
) -> Result<Selection, Failure> {
    let missing = match reading.missing {
        Some(MissingSamples::Break) => Missing::Break,
        Some(MissingSamples::Error) | None => Missing::Refuse,
    };
    Ok(Selection {
        inputs,
        outputs,
        time: reading.time.clone(),
        sample_time_s: reading.sample_time,
        topic: reading.topic.clone(),
        rows,
        missing,
        reading: Reading {
            encoding: reading.encoding.clone(),
            decimal: reading.decimal.map(|sign| match sign {
                DecimalSign::Point => Decimal::Point,
                DecimalSign::Comma => Decimal::Comma,
            }),
            header_line: reading.header_line,
            bad_values: reading.bad_values.clone().unwrap_or_default(),
            time_zone: reading.time_zone.clone(),
            time_format: reading.time_format.clone(),
            layout: reading.layout.map(|layout| match layout {
                TableLayout::Wide => Layout::Wide,
                TableLayout::Long => Layout::Long,
            }),
            resample: resample(reading)?,
            tags: match &reading.tags {
                Some(path) => Some(TagMap::read(path).map_err(Failure::input)?),
                None => None,
            },
        },
    })
}

fn resample(reading: &DataArgs) -> Result<Option<Resample>, Failure> {
    let Some(step_s) = reading.resample else {
        let more = [
            ("--resample-method", reading.resample_method.is_some()),
            ("--hold-at-most", reading.hold_at_most.is_some()),
        ];
        return match more.into_iter().find(|(_, given)| *given) {
            Some((option, _)) => Err(Failure::input(format!(
                "{option}: expected with --resample, found without"
            ))),
            None => Ok(None),
        };
    };
    let method = match reading.resample_method {
        Some(ResampleBy::Mean) | None => ResampleMethod::Mean,
        Some(ResampleBy::Hold) => ResampleMethod::Hold,
        Some(ResampleBy::Linear) => ResampleMethod::Linear,
    };
    Ok(Some(Resample {
        step_s,
        method,
        hold_at_most_s: reading.hold_at_most,
    }))
}

/// The selection of a model's channels.
///
/// # Errors
/// As [`selection`].
pub fn selection_for(
    model: &ArxModel,
    reading: &DataArgs,
    rows: Option<Range<usize>>,
) -> Result<Selection, Failure> {
    let names = |signals: &[Signal]| signals.iter().map(|signal| signal.name.clone()).collect();
    selection(names(model.inputs()), names(model.outputs()), reading, rows)
}

/// A file that cannot be read as it is, with what to do about it where that is known.
pub fn unreadable(error: &LogError) -> Failure {
    let fits_around_it = "; --missing break fits around it";
    let advice = match error {
        LogError::Cell { problem, .. } => match problem {
            CellProblem::Empty | CellProblem::Bad(_) | CellProblem::BadQuality(_) => fits_around_it,
            CellProblem::NotFinite(cell) if cell.parse::<f64>().is_ok_and(f64::is_nan) => {
                fits_around_it
            }
            CellProblem::Text(_) => "; if it stands for a missing value, name it with --bad-values",
            _ => "",
        },
        LogError::TimeNotUniform {
            expected_s,
            found_s,
            ..
        } if found_s > expected_s => "; --missing break fits around the gap",
        _ => "",
    };
    Failure::input(format!("{error}{advice}"))
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
/// nor the options tell one. Where time may jump, the samples that are not there are missing ones.
///
/// # Errors
/// As [`read_dataset`], and a sample time that is not the model's.
pub fn read_for(
    path: &Path,
    selection: &Selection,
    of: &Path,
    sample_time_s: f64,
) -> Result<Read, Failure> {
    let mut imported = read_dataset(path, selection).map_err(|error| unreadable(&error))?;
    let mut warnings = Vec::new();
    if imported.warnings.contains(&Warning::TimeInSamples) {
        let with_time = Selection {
            sample_time_s: Some(sample_time_s),
            ..selection.clone()
        };
        imported = read_dataset(path, &with_time).map_err(|error| unreadable(&error))?;
        warnings.push(format!(
            "no column named time, timestamp or t and no sample time given: that of {} is taken, \
             {sample_time_s} s",
            of.display()
        ));
    }
    let imported = imported.filled(path).map_err(Failure::input)?;
    Ok(passed_on(path, imported, warnings))
}

/// The parts of a record between missing samples, where those break it; else the record as it is.
///
/// # Errors
/// An infinite sample, or no sample of all channels.
pub fn parts(path: &Path, data: Dataset, missing: Missing) -> Result<Vec<Dataset>, Failure> {
    if missing == Missing::Refuse {
        return Ok(vec![data]);
    }
    let parts = unbroken(&data).map_err(|error| Failure::in_file(path, error))?;
    if parts.is_empty() {
        let found = "expected samples of all channels, found none";
        return Err(Failure::in_file(path, found));
    }
    Ok(parts)
}

fn passed_on(path: &Path, imported: Imported, mut warnings: Vec<String>) -> Read {
    warnings.extend(imported.remarks());
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
