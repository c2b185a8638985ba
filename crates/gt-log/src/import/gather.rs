//! The readings of a file, on their way to a record.

use std::collections::BTreeMap;
use std::ops::Range;
use std::path::Path;

use gt_core::Signal;

use super::grid::{Grid, Readings};
use super::{Imported, Resample, Selection, Warning};
use crate::table::Table;
use crate::time::{Clock, Uniform};
use crate::{LogError, Place};

/// The readings of the selected tags, inputs first.
#[derive(Debug)]
pub(crate) struct Gathered {
    pub(crate) signals: Vec<Signal>,
    /// How many of them are inputs.
    pub(crate) nu: usize,
    /// The readings of each tag; NaN where one is missing.
    pub(crate) columns: Vec<Vec<f64>>,
    /// The times of the rows, unless the file has none or none are wanted.
    pub(crate) clock: Option<Clock>,
    /// Where each row stands.
    pub(crate) places: Vec<Place>,
    /// The rows of the file, wanted or not.
    pub(crate) total_rows: usize,
    /// The words that stood for missing values, by tag.
    pub(crate) words: BTreeMap<(usize, String), usize>,
    pub(crate) warnings: Vec<Warning>,
}

impl Gathered {
    /// The record of the rows as they are.
    pub(crate) fn into_record(
        mut self,
        path: &Path,
        selection: &Selection,
        rows: &Range<usize>,
        sha256: String,
    ) -> Result<Imported, LogError> {
        let mut warnings = std::mem::take(&mut self.warnings);
        let mut start_time_s = None;
        let mut start_unix_ns = None;
        let uniform = match (selection.sample_time_s, &self.clock) {
            (Some(given), _) => Uniform::given(given),
            (None, Some(clock)) => {
                match clock {
                    Clock::Seconds(times) => start_time_s = times.first().copied(),
                    Clock::Nanoseconds(times) => start_unix_ns = times.first().copied(),
                }
                clock.uniform(path, selection.missing, |row| self.places[row])?
            }
            (None, None) => {
                warnings.push(Warning::TimeInSamples);
                Uniform::given(1.0)
            }
        };
        let start_time_s = start_time_s.unwrap_or(rows.start as f64 * uniform.sample_time_s);
        let total_rows = self.total_rows;
        warnings.extend(self.word_warnings());
        let table = self.into_table();
        warnings.extend(table.invalid_samples());
        let dataset = table.into_dataset(path, uniform.sample_time_s, start_time_s)?;
        Ok(Imported {
            dataset,
            sha256,
            warnings,
            total_rows,
            start_unix_ns,
            gaps: uniform.gaps,
            qualities: Vec::new(),
            resampled: None,
        })
    }

    fn word_warnings(&self) -> Vec<Warning> {
        word_warnings(&self.signals, &self.words)
    }

    /// Keeps some of the rows.
    pub(crate) fn keep(&mut self, rows: &Range<usize>) {
        for column in &mut self.columns {
            column.truncate(rows.end);
            column.drain(..rows.start);
        }
        self.places.truncate(rows.end);
        self.places.drain(..rows.start);
        match &mut self.clock {
            Some(Clock::Seconds(times)) => {
                times.truncate(rows.end);
                times.drain(..rows.start);
            }
            Some(Clock::Nanoseconds(times)) => {
                times.truncate(rows.end);
                times.drain(..rows.start);
            }
            None => {}
        }
    }

    /// The record at another period, from all rows.
    pub(crate) fn resampled(
        self,
        path: &Path,
        selection: &Selection,
        resample: Resample,
        sha256: String,
    ) -> Result<Imported, LogError> {
        let words = self.word_warnings();
        let clock = self.clock.unwrap_or(Clock::Seconds(Vec::new()));
        clock.check_order(path, |row| self.places[row])?;
        let origin = clock.clone();
        let times = clock.since(&origin);
        let columns = self.columns.iter();
        let readings: Vec<Readings> = columns
            .map(|values| Readings {
                times_s: &times,
                values,
            })
            .collect();
        let grid = Grid {
            path,
            selection,
            resample,
            origin,
        };
        let warnings = self.warnings.into_iter().chain(words).collect();
        grid.record((&self.signals, self.nu), &readings, warnings, sha256)
    }

    fn into_table(self) -> Table {
        let len = self.columns.first().map_or(0, Vec::len);
        let mut values = Vec::with_capacity(len * self.columns.len());
        for row in 0..len {
            values.extend(self.columns.iter().map(|column| column[row]));
        }
        Table {
            signals: self.signals,
            nu: self.nu,
            values,
            len,
        }
    }
}

/// A warning for each word of each tag.
pub(crate) fn word_warnings(
    signals: &[Signal],
    words: &BTreeMap<(usize, String), usize>,
) -> Vec<Warning> {
    let warning = |((column, word), &count): (&(usize, String), &usize)| Warning::BadWord {
        column: signals[*column].name.clone(),
        word: word.clone(),
        count,
    };
    words.iter().map(warning).collect()
}
