//! From a table of cells, wide or long, to a record.

use std::path::Path;

use gt_core::Signal;

use super::instant::{OwnCell, TimeReader};
use super::long::{self, Roles};
use super::number::Numerals;
use super::select::Columns;
use super::sheet::Sheet;
use super::tags::Conversion;
use super::{Imported, Reading, ReadingError, Selection, wide};
use crate::LogError;

/// What a reader of rows wants to know.
pub(crate) struct Wanted<'a> {
    pub(crate) path: &'a Path,
    /// All columns, or all tags of the rows, under their names in the record.
    pub(crate) named: &'a [Signal],
    /// What becomes of the readings of each.
    pub(crate) conversions: &'a [Conversion],
    pub(crate) columns: &'a Columns,
    pub(crate) numerals: &'a Numerals,
    pub(crate) selection: &'a Selection,
}

/// Reads a record.
pub(crate) fn read(
    path: &Path,
    sheet: &mut impl Sheet,
    numerals: &Numerals,
    selection: &Selection,
    sha256: String,
) -> Result<Imported, LogError> {
    let header = sheet.header().to_vec();
    match Roles::of(path, &header, selection)? {
        Some(roles) => read_long(path, sheet, roles, numerals, selection, sha256),
        None => read_wide(path, sheet, numerals, selection, sha256),
    }
}

fn read_wide(
    path: &Path,
    sheet: &mut impl Sheet,
    numerals: &Numerals,
    selection: &Selection,
    sha256: String,
) -> Result<Imported, LogError> {
    let mut named = sheet.header().to_vec();
    let conversions = conversions(path, &mut named, &selection.reading)?;
    let time = wide::time_column(path, &named, selection)?;
    let columns = Columns::resolve(path, &named, time, selection)?;
    // A sample time that is given makes the times in the file of no interest.
    let time = time.filter(|_| selection.sample_time_s.is_none());
    let resample = selection.reading.resample;
    if resample.is_some() && time.is_none() {
        return Err(LogError::reading(path, ReadingError::NoTimes));
    }
    let rows = selection.rows.clone().filter(|_| resample.is_none());
    let first = rows.as_ref().map_or(0, |rows| rows.start);
    let time = if let Some(column) = time {
        let reader = time_reader(path, sheet, column, first, numerals, &selection.reading)?;
        Some((column, reader))
    } else {
        None
    };
    let wanted = Wanted {
        path,
        named: &named,
        conversions: &conversions,
        columns: &columns,
        numerals,
        selection,
    };
    sheet.load(&columns.all().collect::<Vec<usize>>())?;
    let gathered = wide::read(sheet, &wanted, time, rows.unwrap_or(0..usize::MAX))?;
    if let Some(resample) = resample {
        return gathered.resampled(path, selection, resample, sha256);
    }
    let rows = selection.rows_of(path, gathered.total_rows)?;
    gathered.into_record(path, selection, &rows, sha256)
}

fn read_long(
    path: &Path,
    sheet: &mut impl Sheet,
    roles: Roles,
    numerals: &Numerals,
    selection: &Selection,
    sha256: String,
) -> Result<Imported, LogError> {
    sheet.load(&roles.all())?;
    let in_file = long::tags(path, sheet, roles)?;
    sheet.rewind()?;
    let mut named = in_file.clone();
    let conversions = conversions(path, &mut named, &selection.reading)?;
    let columns = Columns::resolve(path, &named, None, selection)?;
    let reader = time_reader(path, sheet, roles.time, 0, numerals, &selection.reading)?;
    let wanted = Wanted {
        path,
        named: &named,
        conversions: &conversions,
        columns: &columns,
        numerals,
        selection,
    };
    let mut tracks = long::read(sheet, &wanted, roles, &in_file, reader)?;
    tracks.sort();
    if let Some(resample) = selection.reading.resample {
        return tracks.resampled(path, selection, resample, sha256);
    }
    let mut gathered = tracks.into_table(path)?;
    let rows = selection.rows_of(path, gathered.total_rows)?;
    gathered.keep(&rows);
    gathered.into_record(path, selection, &rows, sha256)
}

/// Names the signals as the tags' file says; what becomes of the readings of each.
pub(crate) fn conversions(
    path: &Path,
    signals: &mut [Signal],
    reading: &Reading,
) -> Result<Vec<Conversion>, LogError> {
    match &reading.tags {
        Some(tags) => tags.apply(path, signals),
        None => Ok(vec![Conversion::NONE; signals.len()]),
    }
}

/// A reader of times like those of a column from a row on; the sheet is at its start afterwards.
pub(crate) fn time_reader(
    path: &Path,
    sheet: &mut impl Sheet,
    column: usize,
    first: usize,
    numerals: &Numerals,
    reading: &Reading,
) -> Result<TimeReader, LogError> {
    let name = sheet.header()[column].name.clone();
    sheet.load(&[column])?;
    let next = || match sheet.advance() {
        Ok(true) => Some(OwnCell::of(sheet.cell(column))),
        _ => None,
    };
    let cells = std::iter::from_fn(next).skip(first);
    let reader = TimeReader::new(&name, cells, reading, numerals);
    sheet.rewind()?;
    reader.map_err(|cause| LogError::reading(path, cause))
}
