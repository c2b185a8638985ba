//! Files with a column for each tag.

use std::collections::BTreeMap;
use std::ops::Range;
use std::path::Path;

use gt_core::Signal;

use super::gather::Gathered;
use super::instant::TimeReader;
use super::number::Sample;
use super::select::names;
use super::sheet::Sheet;
use super::tabular::Wanted;
use super::{Selection, Warning};
use crate::error::CellProblem;
use crate::{LogError, Place};

/// Names that make a column the time, first come first served.
pub(crate) const TIME_NAMES: [&str; 3] = ["time", "timestamp", "t"];

/// Reads some rows of the selected columns; `time` reads the times of a column.
pub(crate) fn read(
    sheet: &mut impl Sheet,
    wanted: &Wanted<'_>,
    mut time: Option<(usize, TimeReader)>,
    rows: Range<usize>,
) -> Result<Gathered, LogError> {
    let (path, named) = (wanted.path, wanted.named);
    let missing = wanted.selection.missing;
    let chosen: Vec<usize> = wanted.columns.all().collect();
    let mut clock = time.as_ref().map(|(_, reader)| reader.clock());
    let mut values = vec![Vec::new(); chosen.len()];
    let mut outside = vec![0; chosen.len()];
    let mut words = BTreeMap::new();
    let mut places = Vec::new();
    let mut total_rows = 0;
    while sheet.advance()? {
        if rows.contains(&total_rows) {
            let place = sheet.place();
            check_count(path, place, named.len(), sheet.fields())?;
            for (index, &column) in chosen.iter().enumerate() {
                let problem = |problem| cell_error(path, place, &named[column], problem);
                let sample = wanted
                    .numerals
                    .sample(sheet.cell(column))
                    .map_err(problem)?;
                let value = sample.allowed(missing).map_err(problem)?;
                count_word(&mut words, index, sample);
                let value = wanted.conversions[column].of(value);
                outside[index] += usize::from(value.is_none());
                values[index].push(value.unwrap_or(f64::NAN));
            }
            if let (Some((column, reader)), Some(clock)) = (&mut time, &mut clock) {
                let read = reader.push(sheet.cell(*column), clock);
                read.map_err(|problem| cell_error(path, place, &named[*column], problem))?;
            }
            places.push(place);
        }
        total_rows += 1;
    }
    if total_rows == 0 {
        return Err(LogError::NoRows {
            path: path.to_owned(),
        });
    }
    let mut warnings = Vec::new();
    if let Some((column, reader)) = &time {
        warnings.extend(time_warnings(&named[*column], reader));
    }
    let signals: Vec<Signal> = chosen.iter().map(|&index| named[index].clone()).collect();
    warnings.extend(range_warnings(&signals, &outside));
    Ok(Gathered {
        signals,
        nu: wanted.columns.inputs.len(),
        columns: values,
        clock,
        places,
        total_rows,
        words,
        warnings,
    })
}

/// A warning for each signal that has readings outside its range.
pub(crate) fn range_warnings(signals: &[Signal], outside: &[usize]) -> Vec<Warning> {
    let counts = signals.iter().zip(outside).filter(|&(_, &count)| count > 0);
    let warning = |(signal, &count): (&Signal, &usize)| Warning::OutOfRange {
        column: signal.name.clone(),
        count,
    };
    counts.map(warning).collect()
}

/// Counts a word for a missing value; nothing and NaN are none.
pub(crate) fn count_word(
    words: &mut BTreeMap<(usize, String), usize>,
    index: usize,
    sample: Sample<'_>,
) {
    if let Sample::Missing(word) = sample
        && !word.is_empty()
        && word.parse::<f64>().is_err()
    {
        *words.entry((index, word.to_owned())).or_default() += 1;
    }
}

/// What the user should know of how times were read.
pub(crate) fn time_warnings(column: &Signal, reader: &TimeReader) -> Vec<Warning> {
    let mut warnings = Vec::new();
    warnings.extend(reader.taken_as(&column.name));
    if reader.folded > 0 {
        warnings.push(Warning::Folded {
            count: reader.folded,
        });
    }
    warnings
}

/// Refuses a row with more or fewer fields than the header.
pub(crate) fn check_count(
    path: &Path,
    place: Place,
    expected: usize,
    found: usize,
) -> Result<(), LogError> {
    let line = match place {
        Place::Line(line) if found != expected => line,
        _ => return Ok(()),
    };
    Err(LogError::Ragged {
        path: path.to_owned(),
        line,
        expected,
        found,
    })
}

/// What is wrong with a cell, with its place.
pub(crate) fn cell_error(
    path: &Path,
    place: Place,
    column: &Signal,
    problem: CellProblem,
) -> LogError {
    LogError::Cell {
        path: path.to_owned(),
        place,
        column: column.name.clone(),
        problem,
    }
}

/// The position of the time column, where there is one.
pub(crate) fn time_column(
    path: &Path,
    header: &[Signal],
    selection: &Selection,
) -> Result<Option<usize>, LogError> {
    if let Some(name) = &selection.time {
        let index = header.iter().position(|signal| signal.name == *name);
        return index.map(Some).ok_or_else(|| LogError::UnknownColumn {
            path: path.to_owned(),
            column: name.clone(),
            available: names(header),
        });
    }
    // `T` may be a temperature: who selects it by name says so.
    let is_signal = |name: &String| {
        selection
            .inputs
            .iter()
            .chain(&selection.outputs)
            .any(|s| s == name)
    };
    Ok(TIME_NAMES.iter().find_map(|time| {
        header
            .iter()
            .position(|s| s.name.eq_ignore_ascii_case(time) && !is_signal(&s.name))
    }))
}
