//! Options of the residual tests.

use serde::{Deserialize, Serialize};

use crate::IdentError;

/// What the record is to the model. The estimated coefficients make the residuals of the record
/// that they were fitted to look too white and too independent of the inputs, those of any other
/// record too little; the tests allow for either.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum RecordOrigin {
    /// The model was fitted to this record.
    Fitted,
    /// The model was fitted to another, independent record.
    Fresh,
}

/// Options of [`crate::test_residuals`].
///
/// | Name | Default | Purpose | Range |
/// |---|---|---|---|
/// | `lags` | 20 | largest lag `M` of all correlations, in samples | above the model's longest lag of its outputs, below the number of residuals |
/// | `significance` | 0.01 | rate of false rejections of each test; bands have `1 - significance` | 0 to 1, exclusive |
/// | `origin` | fresh | whether the model was fitted to the record | `fitted`, `fresh` |
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ResidualOptions {
    /// The largest lag, in samples.
    pub lags: usize,
    /// The rate of false rejections of each test.
    pub significance: f64,
    /// What the record is to the model.
    pub origin: RecordOrigin,
}

impl Default for ResidualOptions {
    fn default() -> Self {
        Self {
            lags: 20,
            significance: 0.01,
            origin: RecordOrigin::Fresh,
        }
    }
}

/// Residuals that the laws of the tests want for each lag of the correlations.
const SAMPLES_PER_LAG: usize = 5;

impl ResidualOptions {
    /// The defaults over fewer lags where there are few residuals: the laws of the tests hold for
    /// correlations over many samples.
    pub fn for_residuals(residuals: usize) -> Self {
        let defaults = Self::default();
        Self {
            lags: defaults.lags.min(residuals / SAMPLES_PER_LAG),
            ..defaults
        }
    }

    /// Refuses a significance outside 0 to 1 and a number of lags outside
    /// `lowest..=highest`.
    pub(crate) fn validate(&self, lowest: usize, highest: usize) -> Result<(), IdentError> {
        if !(self.significance > 0.0 && self.significance < 1.0) {
            return Err(IdentError::Significance {
                found: self.significance,
            });
        }
        if !(lowest..=highest).contains(&self.lags) {
            return Err(IdentError::ResidualLags {
                lowest,
                highest,
                found: self.lags,
            });
        }
        Ok(())
    }
}
