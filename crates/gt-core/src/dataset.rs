//! A record of inputs and outputs at a constant sample time.

use std::collections::HashSet;
use std::ops::Range;

use nalgebra::DMatrix;

use crate::{DataError, DimensionError, OperatingPoint, Signal, index_of};

/// A record: inputs `u (nu x N)` and outputs `y (ny x N)`, sampled every `sample_time_s` seconds.
///
/// A column is a sample, so the bytes are those of a C-ordered NumPy array of shape `(N, ny)`.
/// NaN is allowed and means *no valid sample*; [`Dataset::check_finite`] refuses it where a method
/// needs every sample.
#[derive(Debug, Clone, PartialEq)]
pub struct Dataset {
    inputs: Vec<Signal>,
    outputs: Vec<Signal>,
    u: DMatrix<f64>,
    y: DMatrix<f64>,
    sample_time_s: f64,
    start_time_s: f64,
}

impl Dataset {
    /// A checked record.
    ///
    /// `u (nu x N)` and `y (ny x N)` have a row per signal; `sample_time_s` is positive and
    /// finite; the first sample is at time 0 (see [`Dataset::starting_at`]).
    ///
    /// # Errors
    /// [`DataError`] when sizes disagree, a name is used twice or the sample time is not positive.
    pub fn new(
        inputs: Vec<Signal>,
        outputs: Vec<Signal>,
        u: DMatrix<f64>,
        y: DMatrix<f64>,
        sample_time_s: f64,
    ) -> Result<Self, DataError> {
        DimensionError::check("rows of u (inputs)", inputs.len(), u.nrows())?;
        DimensionError::check("rows of y (outputs)", outputs.len(), y.nrows())?;
        DimensionError::check("columns of y (samples)", u.ncols(), y.ncols())?;
        if !(sample_time_s.is_finite() && sample_time_s > 0.0) {
            return Err(DataError::SampleTime {
                found: sample_time_s,
            });
        }
        let mut seen = HashSet::new();
        for signal in inputs.iter().chain(&outputs) {
            if !seen.insert(&signal.name) {
                return Err(DataError::DuplicateName {
                    name: signal.name.clone(),
                });
            }
        }
        Ok(Self {
            inputs,
            outputs,
            u,
            y,
            sample_time_s,
            start_time_s: 0.0,
        })
    }

    /// The same record with its first sample at `start_time_s`.
    #[must_use]
    pub fn starting_at(mut self, start_time_s: f64) -> Self {
        self.start_time_s = start_time_s;
        self
    }

    /// The input signals, in the order of the rows of `u`.
    pub fn inputs(&self) -> &[Signal] {
        &self.inputs
    }

    /// The output signals, in the order of the rows of `y`.
    pub fn outputs(&self) -> &[Signal] {
        &self.outputs
    }

    /// Inputs, `nu x N`.
    pub fn u(&self) -> &DMatrix<f64> {
        &self.u
    }

    /// Outputs, `ny x N`.
    pub fn y(&self) -> &DMatrix<f64> {
        &self.y
    }

    /// Number of inputs.
    pub fn nu(&self) -> usize {
        self.u.nrows()
    }

    /// Number of outputs.
    pub fn ny(&self) -> usize {
        self.y.nrows()
    }

    /// Number of samples.
    pub fn len(&self) -> usize {
        self.u.ncols()
    }

    /// Whether there is no sample at all.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// Sample time in seconds.
    pub fn sample_time_s(&self) -> f64 {
        self.sample_time_s
    }

    /// Time of the first sample in seconds.
    pub fn start_time_s(&self) -> f64 {
        self.start_time_s
    }

    /// Time of sample `k` in seconds.
    pub fn time_s(&self, k: usize) -> f64 {
        self.start_time_s + k as f64 * self.sample_time_s
    }

    /// The samples of `rows` (0-based, half open).
    ///
    /// # Errors
    /// [`DataError::Range`] when the range is empty or reaches past the end.
    pub fn rows(&self, rows: Range<usize>) -> Result<Self, DataError> {
        if rows.start >= rows.end || rows.end > self.len() {
            return Err(DataError::Range {
                start: rows.start,
                end: rows.end,
                len: self.len(),
            });
        }
        let count = rows.end - rows.start;
        Ok(Self {
            inputs: self.inputs.clone(),
            outputs: self.outputs.clone(),
            u: self.u.columns(rows.start, count).into_owned(),
            y: self.y.columns(rows.start, count).into_owned(),
            sample_time_s: self.sample_time_s,
            start_time_s: self.time_s(rows.start),
        })
    }

    /// The record with the named channels as inputs and outputs, in the order asked for; a channel
    /// may come from either side of the present record.
    ///
    /// # Errors
    /// [`DataError::UnknownChannel`] or [`DataError::DuplicateName`].
    pub fn select<S: AsRef<str>, T: AsRef<str>>(
        &self,
        inputs: &[S],
        outputs: &[T],
    ) -> Result<Self, DataError> {
        let (input_signals, u) = self.gather(inputs.iter().map(AsRef::as_ref))?;
        let (output_signals, y) = self.gather(outputs.iter().map(AsRef::as_ref))?;
        let selected = Self::new(input_signals, output_signals, u, y, self.sample_time_s)?;
        Ok(selected.starting_at(self.start_time_s))
    }

    fn gather<'a>(
        &self,
        names: impl ExactSizeIterator<Item = &'a str>,
    ) -> Result<(Vec<Signal>, DMatrix<f64>), DataError> {
        let all: Vec<Signal> = self.inputs.iter().chain(&self.outputs).cloned().collect();
        let mut matrix = DMatrix::zeros(names.len(), self.len());
        let mut signals = Vec::with_capacity(names.len());
        for (row, name) in names.enumerate() {
            let index = index_of(&all, name)?;
            signals.push(all[index].clone());
            if index < self.nu() {
                matrix.set_row(row, &self.u.row(index));
            } else {
                matrix.set_row(row, &self.y.row(index - self.nu()));
            }
        }
        Ok((signals, matrix))
    }

    /// Refuses NaN and infinity.
    ///
    /// # Errors
    /// [`DataError::NotFinite`] with the first offending channel and sample.
    pub fn check_finite(&self) -> Result<(), DataError> {
        for (signals, matrix) in [(&self.inputs, &self.u), (&self.outputs, &self.y)] {
            for (sample, column) in matrix.column_iter().enumerate() {
                if let Some(row) = column.iter().position(|value| !value.is_finite()) {
                    return Err(DataError::NotFinite {
                        channel: signals[row].name.clone(),
                        sample,
                        found: column[row],
                    });
                }
            }
        }
        Ok(())
    }

    /// The means of all channels.
    pub fn mean(&self) -> OperatingPoint {
        OperatingPoint {
            u: self.u.column_mean(),
            y: self.y.column_mean(),
        }
    }

    /// The record as deviations from an operating point.
    ///
    /// # Errors
    /// [`DimensionError`] when the point has another number of channels.
    pub fn relative_to(&self, point: &OperatingPoint) -> Result<Self, DimensionError> {
        DimensionError::check("inputs of the operating point", self.nu(), point.u.len())?;
        DimensionError::check("outputs of the operating point", self.ny(), point.y.len())?;
        let mut shifted = self.clone();
        for mut column in shifted.u.column_iter_mut() {
            column -= &point.u;
        }
        for mut column in shifted.y.column_iter_mut() {
            column -= &point.y;
        }
        Ok(shifted)
    }

    /// The record with other samples, of the same numbers.
    pub(crate) fn with_samples(&self, u: DMatrix<f64>, y: DMatrix<f64>) -> Self {
        Self {
            u,
            y,
            ..self.clone()
        }
    }
}
