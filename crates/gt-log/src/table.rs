//! Selected columns with their times, on the way into a dataset.

use std::path::Path;

use gt_core::{Dataset, Signal};
use nalgebra::DMatrix;

use crate::LogError;
use crate::import::{Columns, Warning};

/// The selected columns of a file.
#[derive(Debug)]
pub(crate) struct Table {
    /// The columns, each once: inputs first, then outputs.
    pub(crate) signals: Vec<Signal>,
    /// How many of them are inputs.
    pub(crate) nu: usize,
    /// The values, sample by sample.
    pub(crate) values: Vec<f64>,
    /// The number of samples.
    pub(crate) len: usize,
}

impl Table {
    /// An empty table of the selected columns.
    pub(crate) fn new(columns: &Columns, available: &[Signal]) -> Self {
        let signals = columns
            .all()
            .map(|index| available[index].clone())
            .collect();
        Self {
            signals,
            nu: columns.inputs.len(),
            values: Vec::new(),
            len: 0,
        }
    }

    /// Appends a sample.
    pub(crate) fn push(&mut self, sample: impl IntoIterator<Item = f64>) {
        self.values.extend(sample);
        self.len += 1;
    }

    /// A warning for each column that has values that are NaN.
    pub(crate) fn invalid_samples(&self) -> Vec<Warning> {
        let width = self.signals.len();
        let count = |column: usize| {
            let values = self.values.iter().skip(column).step_by(width);
            values.filter(|value| value.is_nan()).count()
        };
        let counts = self.signals.iter().enumerate();
        counts
            .map(|(column, signal)| (signal, count(column)))
            .filter(|&(_, count)| count > 0)
            .map(|(signal, count)| Warning::InvalidSamples {
                column: signal.name.clone(),
                count,
            })
            .collect()
    }

    /// The record at a sample time.
    pub(crate) fn into_dataset(
        self,
        path: &Path,
        sample_time_s: f64,
        start_time_s: f64,
    ) -> Result<Dataset, LogError> {
        let mut inputs = self.signals;
        let width = inputs.len();
        let outputs = inputs.split_off(self.nu);
        let all = DMatrix::from_vec(width, self.len, self.values);
        let u = all.rows(0, inputs.len()).into_owned();
        let y = all.rows(inputs.len(), outputs.len()).into_owned();
        Dataset::new(inputs, outputs, u, y, sample_time_s)
            .map(|dataset| dataset.starting_at(start_time_s))
            .map_err(|cause| LogError::Data {
                path: path.to_owned(),
                cause,
            })
    }
}
