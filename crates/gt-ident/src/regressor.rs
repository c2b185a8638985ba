//! Lagged channels of a record as columns.

use std::ops::Range;

use gt_core::{Dataset, OperatingPoint, Signal};
use nalgebra::DMatrix;

use crate::{Channel, IdentError, Regressor};

/// A record as deviations from an operating point, a channel a column (`N x nu`, `N x ny`), so
/// that a lagged channel is a slice.
pub(crate) struct Deviations {
    pub u: DMatrix<f64>,
    pub y: DMatrix<f64>,
}

impl Deviations {
    /// The record without the operating point; every sample must be finite.
    pub fn new(data: &Dataset, point: &OperatingPoint) -> Result<Self, IdentError> {
        data.check_finite()?;
        let relative = data.relative_to(point)?;
        Ok(Self {
            u: relative.u().transpose(),
            y: relative.y().transpose(),
        })
    }

    /// The channel at `t - lag` for `t` in `rows`; `rows` starts at `lag` or later.
    pub fn lagged(&self, regressor: Regressor, rows: &Range<usize>) -> &[f64] {
        let (matrix, index) = match regressor.channel {
            Channel::Output(index) => (&self.y, index),
            Channel::Input(index) => (&self.u, index),
        };
        let samples = matrix.nrows();
        let column = &matrix.as_slice()[index * samples..(index + 1) * samples];
        &column[rows.start - regressor.lag..rows.end - regressor.lag]
    }

    /// The regressor matrix (`rows x regressors`), for records that are small or weighted; a fit
    /// of a long record never forms it.
    pub fn design(&self, regressors: &[Regressor], rows: &Range<usize>) -> DMatrix<f64> {
        let mut design = DMatrix::zeros(rows.len(), regressors.len());
        for (mut column, &regressor) in design.column_iter_mut().zip(regressors) {
            column.copy_from_slice(self.lagged(regressor, rows));
        }
        design
    }
}

/// Refuses a channel of the record that does not vary: a range within rounding of its size.
pub(crate) fn check_varies(
    signal: &Signal,
    samples: impl Iterator<Item = f64>,
) -> Result<(), IdentError> {
    let (low, high) = samples.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), x| {
        (low.min(x), high.max(x))
    });
    check_range(signal, low, high)
}

/// Refuses a channel whose range is within rounding of its size.
pub(crate) fn check_range(signal: &Signal, low: f64, high: f64) -> Result<(), IdentError> {
    if high - low > 4.0 * f64::EPSILON * high.abs().max(low.abs()) {
        return Ok(());
    }
    Err(IdentError::ConstantChannel {
        channel: signal.name.clone(),
        value: low,
    })
}
