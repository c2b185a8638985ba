//! Records at a period that is asked for.

use std::path::Path;

use gt_core::Signal;

use super::{Imported, Resample, Resampled, Selection, Warning};
use crate::LogError;
use crate::quality::Quality;
use crate::table::Table;
use crate::time::Clock;

/// The readings of a tag, at times since the first reading of all.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Readings<'a> {
    pub(crate) times_s: &'a [f64],
    pub(crate) values: &'a [f64],
}

/// How readings become samples, and when the first of them is.
pub(crate) struct Grid<'a> {
    pub(crate) path: &'a Path,
    pub(crate) selection: &'a Selection,
    pub(crate) resample: Resample,
    /// A clock whose first time is that of the first sample.
    pub(crate) origin: Clock,
}

impl Grid<'_> {
    /// The record of the selected rows, which are samples at the new period.
    pub(crate) fn record(
        self,
        (signals, nu): (&[Signal], usize),
        readings: &[Readings<'_>],
        mut warnings: Vec<Warning>,
        sha256: String,
    ) -> Result<Imported, LogError> {
        let last_s = readings
            .iter()
            .filter_map(|tag| tag.times_s.last().copied());
        let last_s = last_s.fold(0.0, f64::max);
        let total_rows = self
            .resample
            .samples(last_s)
            .map_err(|cause| LogError::reading(self.path, cause))?;
        let rows = self.selection.rows_of(self.path, total_rows)?;
        let tags = readings.iter().zip(signals).map(|(tag, signal)| {
            let (times, values) = (tag.times_s, tag.values);
            self.resample
                .samples_of(&signal.name, total_rows, times, values)
        });
        let (columns, reports): (Vec<Vec<(f64, Quality)>>, Vec<_>) = tags.unzip();
        let mut values = Vec::with_capacity(rows.len() * columns.len());
        for row in rows.clone() {
            values.extend(columns.iter().map(|column| column[row].0));
        }
        let own = |column: &Vec<(f64, Quality)>| -> Vec<Quality> {
            column[rows.clone()].iter().map(|sample| sample.1).collect()
        };
        let qualities = columns.iter().map(own).collect();
        let table = Table {
            signals: signals.to_vec(),
            nu,
            values,
            len: rows.len(),
        };
        let step_s = self.resample.step_s;
        let shift_s = rows.start as f64 * step_s;
        let (start_time_s, start_unix_ns) = match &self.origin {
            Clock::Seconds(times) => (times.first().copied().unwrap_or(0.0) + shift_s, None),
            Clock::Nanoseconds(times) => {
                let first = times.first().map(|first| first + nanoseconds(shift_s));
                (shift_s, first)
            }
        };
        warnings.extend(table.invalid_samples());
        Ok(Imported {
            dataset: table.into_dataset(self.path, step_s, start_time_s)?,
            sha256,
            warnings,
            total_rows,
            start_unix_ns,
            gaps: Vec::new(),
            qualities,
            resampled: Some(Resampled {
                resample: self.resample,
                samples: total_rows,
                tags: reports,
            }),
        })
    }
}

#[expect(clippy::cast_possible_truncation, reason = "a cast saturates")]
fn nanoseconds(seconds: f64) -> i128 {
    (seconds * 1e9).round() as i128
}
