//! What the Frisch scheme finds.

use nalgebra::DVector;

use super::surface::{AdmissibleSurface, SurfacePoint};
use crate::eiv::{EivRow, NoiseVariances};
use crate::{Channel, IdentError};

/// A variance below this part of its largest admissible value is at the boundary, zero.
pub const BOUNDARY_SHARE: f64 = 1e-6;

/// The relation of one output and the noise variances, chosen by a criterion on the admissible
/// surface.
#[derive(Debug, Clone, PartialEq)]
pub struct FrischEstimate {
    /// The relation between the noise-free channels.
    pub row: EivRow,
    /// The noise variances, in squared units of the channels.
    pub noise: NoiseVariances,
    /// The largest admissible variance of each channel, that of all noise on it alone.
    pub largest_noise: NoiseVariances,
    /// The channels whose variance is at the boundary of the admissible surface, zero: the
    /// criterion would be smaller still with a negative variance, and the estimate is then no
    /// stationary point of it.
    pub boundary: Vec<Channel>,
    /// The least value of the criterion, for channels of unit deviation.
    pub criterion_value: f64,
    /// Rows of the window; 0 where the covariances were exact.
    pub window_rows: usize,
}

/// An estimate in the units of the channels, from a point for channels scaled by `scales`.
pub(crate) fn estimate(
    surface: &AdmissibleSurface,
    point: &SurfacePoint,
    scales: &[f64],
    output: usize,
    (criterion_value, window_rows): (f64, usize),
) -> Result<FrischEstimate, IdentError> {
    let row = unscaled(&point.row(surface.lags())?, scales)?;
    Ok(FrischEstimate {
        row,
        noise: variances(&point.variances, scales),
        largest_noise: variances(surface.intercepts(), scales),
        boundary: boundary(&point.variances, surface.intercepts(), output),
        criterion_value,
        window_rows,
    })
}

/// The relation of the channels from that of the channels over their scales: `b s_y / s_u`.
pub(crate) fn unscaled(row: &EivRow, scales: &[f64]) -> Result<EivRow, IdentError> {
    let mut theta = row.theta().clone();
    let mut position = row.lags().order();
    for input in 0..row.lags().inputs() {
        for _ in 0..row.lags().input_terms(input) {
            theta[position] *= scales[0] / scales[input + 1];
            position += 1;
        }
    }
    EivRow::new(row.lags().clone(), theta)
}

/// Variances of the channels from those of the channels over their scales.
pub(crate) fn variances(scaled: &[f64], scales: &[f64]) -> NoiseVariances {
    let squared = |index: usize| scaled[index] * scales[index].powi(2);
    NoiseVariances {
        output: squared(0),
        inputs: DVector::from_iterator(scales.len() - 1, (1..scales.len()).map(squared)),
    }
}

/// The channels whose variance is at zero.
pub(crate) fn boundary(variances: &[f64], largest: &[f64], output: usize) -> Vec<Channel> {
    let at_zero = |index: &usize| variances[*index] <= BOUNDARY_SHARE * largest[*index];
    let channel = |index: usize| match index.checked_sub(1) {
        None => Channel::Output(output),
        Some(input) => Channel::Input(input),
    };
    (0..variances.len()).filter(at_zero).map(channel).collect()
}
