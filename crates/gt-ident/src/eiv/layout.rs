//! Where the coefficients and variances of several outputs stand in one vector.

use nalgebra::DVector;

use super::row::{EivLags, EivRow};
use crate::IdentError;

/// One coefficient of `h(w) = [P(w), -Q(w)]` (`m x (m + r)`), `h H = 0`.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Entry {
    /// Row of `h`: the output.
    pub row: usize,
    /// Column of `h`: the channel, outputs before inputs.
    pub channel: usize,
    /// The lag in samples.
    pub lag: usize,
}

/// The coefficients of all rows, one row after the other, then `m` output and `r` input variances.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) struct Layout {
    pub lags: Vec<EivLags>,
    pub entries: Vec<Entry>,
    pub outputs: usize,
    pub inputs: usize,
    /// The longest lag.
    pub longest: usize,
}

impl Layout {
    /// Of a row per output.
    ///
    /// # Errors
    /// [`IdentError::NoOutputs`] without rows, [`IdentError::NoInputs`] without inputs,
    /// [`IdentError::Dimension`] for rows of different numbers of inputs.
    pub fn new(lags: &[EivLags]) -> Result<Self, IdentError> {
        let Some(first) = lags.first() else {
            return Err(IdentError::NoOutputs);
        };
        let (outputs, inputs) = (lags.len(), first.inputs());
        if inputs == 0 {
            return Err(IdentError::NoInputs);
        }
        let mut entries = Vec::new();
        for (row, lags) in lags.iter().enumerate() {
            gt_core::DimensionError::check(
                "inputs of an errors-in-variables row",
                inputs,
                lags.inputs(),
            )?;
            entries.extend((1..=lags.order()).map(|lag| Entry {
                row,
                channel: row,
                lag,
            }));
            for (input, &nk) in lags.nk().iter().enumerate() {
                entries.extend((nk..=lags.order()).map(|lag| Entry {
                    row,
                    channel: outputs + input,
                    lag,
                }));
            }
        }
        let longest = lags.iter().map(EivLags::order).max().unwrap_or(0);
        Ok(Self {
            lags: lags.to_vec(),
            entries,
            outputs,
            inputs,
            longest,
        })
    }

    /// Number of channels `m + r`.
    pub fn channels(&self) -> usize {
        self.outputs + self.inputs
    }

    /// Number of coefficients.
    pub fn coefficients(&self) -> usize {
        self.entries.len()
    }

    /// Number of coefficients and variances.
    pub fn len(&self) -> usize {
        self.coefficients() + self.channels()
    }

    /// The sign with which a coefficient enters `h`: inputs stand on the right of the relation.
    pub fn sign(&self, entry: Entry) -> f64 {
        if entry.channel < self.outputs {
            1.0
        } else {
            -1.0
        }
    }

    /// First coefficient of each row.
    pub fn row_starts(&self) -> Vec<usize> {
        let mut start = 0;
        let starts = self.lags.iter().map(|lags| {
            let here = start;
            start += lags.parameters();
            here
        });
        starts.collect()
    }

    /// The rows of a vector of coefficients.
    ///
    /// # Errors
    /// [`IdentError::Dimension`] for another number of coefficients.
    pub fn rows(&self, coefficients: &[f64]) -> Result<Vec<EivRow>, IdentError> {
        let starts = self.row_starts();
        let pairs = self.lags.iter().zip(starts);
        pairs
            .map(|(lags, start)| {
                let end = (start + lags.parameters()).min(coefficients.len());
                let theta = DVector::from_column_slice(&coefficients[start.min(end)..end]);
                EivRow::new(lags.clone(), theta)
            })
            .collect()
    }
}
