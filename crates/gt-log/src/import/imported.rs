//! Records from files.

use std::ops::Range;
use std::path::Path;

use gt_core::{DataError, Dataset};
use nalgebra::DMatrix;

use super::{ReadingError, Resampled, Warning};
use crate::LogError;
use crate::quality::Quality;

/// A record from a file.
#[derive(Debug, Clone, PartialEq)]
pub struct Imported {
    /// The record. Its first sample is at the time in the time column, or else at the number of
    /// rows before it times the sample time.
    pub dataset: Dataset,
    /// The SHA-256 of the whole file, in hexadecimal digits.
    pub sha256: String,
    /// What the user should know.
    pub warnings: Vec<Warning>,
    /// The data rows of the file (messages of the topic), selected or not.
    pub total_rows: usize,
    /// The time of the first sample in nanoseconds since 1970, where the file tells it.
    pub start_unix_ns: Option<i128>,
    /// The samples before which time jumps; none unless breaks are allowed.
    pub gaps: Vec<TimeGap>,
    /// How good each sample of each channel is, inputs first, where resampling made the samples: held
    /// ones are stale, those on a line between readings interpolated. Empty where it did not.
    pub qualities: Vec<Vec<Quality>>,
    /// What resampling made of the file, where it was asked for.
    pub resampled: Option<Resampled>,
}

/// A sample that comes later than a sample time after the one before it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct TimeGap {
    /// The sample, 0-based.
    pub sample: usize,
    /// Its time since the first sample, in seconds.
    pub since_first_s: f64,
}

impl Imported {
    /// All that the user should know, a line each: the warnings and what resampling did.
    pub fn remarks(&self) -> Vec<String> {
        let warnings = self.warnings.iter().map(ToString::to_string);
        let tags = self.resampled.iter().flat_map(|done| &done.tags);
        warnings
            .chain(tags.map(|tag| format!("resampled {}", tag.text())))
            .collect()
    }

    /// The samples of `rows`, a record of its own from each gap in time on, at its own time.
    ///
    /// # Errors
    /// As [`Dataset::rows`].
    pub fn pieces(&self, rows: Range<usize>) -> Result<Vec<Dataset>, DataError> {
        let start = |sample: usize| -> f64 {
            let before = self.gaps.iter().rev().find(|gap| gap.sample <= sample);
            let (first, since_first_s) =
                before.map_or((0, 0.0), |gap| (gap.sample, gap.since_first_s));
            let steps = (sample - first) as f64;
            self.dataset.start_time_s() + since_first_s + steps * self.dataset.sample_time_s()
        };
        let inside = self.gaps.iter().map(|gap| gap.sample);
        let inside = inside.filter(|sample| (rows.start + 1..rows.end).contains(sample));
        let bounds: Vec<usize> = [rows.start]
            .into_iter()
            .chain(inside)
            .chain([rows.end])
            .collect();
        let piece = |ends: &[usize]| {
            let data = self.dataset.rows(ends[0]..ends[1])?;
            Ok(data.starting_at(start(ends[0])))
        };
        bounds.windows(2).map(piece).collect()
    }
}

impl Imported {
    /// The record without gaps: the samples that are not there are missing ones (NaN).
    ///
    /// # Errors
    /// [`ReadingError::OddGap`] for a gap that is no whole number of sample times,
    /// [`ReadingError::LongGap`] for more samples than anyone wants.
    pub fn filled(mut self, path: &Path) -> Result<Self, LogError> {
        const MOST_SAMPLES: f64 = 5e7;
        const WHOLE: f64 = 0.05;
        if self.gaps.is_empty() {
            return Ok(self);
        }
        let data = &self.dataset;
        let period_s = data.sample_time_s();
        let mut absent = vec![0; data.len()];
        let (mut sample, mut since_first_s) = (0, 0.0);
        let mut total = data.len() as f64;
        for gap in &self.gaps {
            let before_s = since_first_s + (gap.sample - 1 - sample) as f64 * period_s;
            let steps = (gap.since_first_s - before_s) / period_s;
            let cause = |found| match found {
                None => ReadingError::LongGap {
                    seconds: gap.since_first_s - before_s,
                    most: MOST_SAMPLES,
                },
                Some(steps) => ReadingError::OddGap {
                    sample: gap.sample,
                    steps,
                    period_s,
                },
            };
            if (steps - steps.round()).abs() > WHOLE {
                return Err(LogError::reading(path, cause(Some(steps))));
            }
            total += steps.round() - 1.0;
            if total > MOST_SAMPLES {
                return Err(LogError::reading(path, cause(None)));
            }
            absent[gap.sample] = whole(steps) - 1;
            (sample, since_first_s) = (gap.sample, gap.since_first_s);
        }
        let spread = |from: &DMatrix<f64>| {
            let mut values = Vec::with_capacity(from.nrows() * from.ncols());
            for (column, &absent) in from.column_iter().zip(&absent) {
                values.extend(std::iter::repeat_n(f64::NAN, absent * from.nrows()));
                values.extend(column.iter());
            }
            let len = data.len() + absent.iter().sum::<usize>();
            DMatrix::from_vec(from.nrows(), len, values)
        };
        let (u, y) = (spread(data.u()), spread(data.y()));
        let (inputs, outputs) = (data.inputs().to_vec(), data.outputs().to_vec());
        let start_time_s = data.start_time_s();
        let filled = Dataset::new(inputs, outputs, u, y, period_s);
        let filled = filled.map_err(|cause| LogError::Data {
            path: path.to_owned(),
            cause,
        })?;
        self.dataset = filled.starting_at(start_time_s);
        self.gaps.clear();
        Ok(self)
    }
}

/// A number of steps, which is checked to be one.
#[expect(
    clippy::cast_possible_truncation,
    clippy::cast_sign_loss,
    reason = "a cast saturates"
)]
fn whole(steps: f64) -> usize {
    steps.round().max(1.0) as usize
}
