//! What the Frisch scheme finds.

use nalgebra::DVector;

use super::covariance::LaggedCovariance;
use super::surface::SurfacePoint;
use crate::eiv::{EivLags, EivRow, NoiseVariances};
use crate::{Channel, IdentError};

/// A variance below this part of its largest admissible value is at the boundary, zero.
pub const BOUNDARY_SHARE: f64 = 1e-6;

/// A variance below this number of its standard errors cannot be told from zero.
const IDENTIFIABLE_ERRORS: f64 = 2.0;

/// What is known of the noise on one channel.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct FrischNoise {
    /// The channel.
    pub channel: Channel,
    /// The variance, in squared units of the channel.
    pub variance: f64,
    /// The largest admissible variance, that of all noise on this channel alone.
    pub largest: f64,
    /// The variance is at the boundary of the admissible surface, zero: the criterion would be
    /// smaller still with a negative one, and the estimate is no stationary point of it.
    pub at_boundary: bool,
    /// The standard error of the best estimate from the covariances used (optimally weighted
    /// moments with Gaussian noise, at the estimate): no criterion has a smaller one in large
    /// records, and theirs are up to several times larger. Zero where the covariances were exact,
    /// infinite where they do not determine the variance.
    pub least_standard_error: f64,
}

impl FrischNoise {
    /// Whether the record tells the variance from zero: it is at least twice the standard error
    /// of even the best estimate. If not, the variance is a number without a meaning of its own.
    pub fn is_identifiable(&self) -> bool {
        self.variance > 0.0 && self.variance >= IDENTIFIABLE_ERRORS * self.least_standard_error
    }
}

/// The relation of one output and the noise variances, chosen by a criterion on the admissible
/// surface.
#[derive(Debug, Clone, PartialEq)]
pub struct FrischEstimate {
    /// The relation between the noise-free channels.
    pub row: EivRow,
    /// The noise variances, in squared units of the channels.
    pub noise: NoiseVariances,
    /// What is known of each variance, the output first: whether it is at the boundary, whether
    /// it is identifiable.
    pub channels: Vec<FrischNoise>,
    /// The least value of the criterion, for channels of unit deviation.
    pub criterion_value: f64,
    /// Rows of the window; 0 where the covariances were exact.
    pub window_rows: usize,
}

impl FrischEstimate {
    /// The channels whose variance is at the boundary, zero.
    pub fn boundary(&self) -> Vec<Channel> {
        let at_boundary = self.channels.iter().filter(|noise| noise.at_boundary);
        at_boundary.map(|noise| noise.channel).collect()
    }
}

/// What is known of each channel, in its units, from a point for channels over their scales and
/// the standard errors there.
pub(crate) fn channel_noise(
    point: &SurfacePoint,
    largest: &[f64],
    errors: &[f64],
    scales: &[f64],
    output: usize,
) -> Vec<FrischNoise> {
    let known = |(index, scale): (usize, &f64)| FrischNoise {
        channel: match index.checked_sub(1) {
            None => Channel::Output(output),
            Some(input) => Channel::Input(input),
        },
        variance: point.variances[index] * scale.powi(2),
        largest: largest[index] * scale.powi(2),
        at_boundary: point.variances[index] <= BOUNDARY_SHARE * largest[index],
        least_standard_error: errors[index] * scale.powi(2),
    };
    scales.iter().enumerate().map(known).collect()
}

/// Relation and variances of the channels from those of the channels over their scales.
///
/// # Errors
/// [`IdentError::CoefficientNotFinite`] where a number overflows in the units of the channels.
pub(crate) fn in_units(
    lags: &EivLags,
    point: &SurfacePoint,
    covariance: &LaggedCovariance,
) -> Result<(EivRow, NoiseVariances), IdentError> {
    let scales = covariance.scales();
    let row = unscaled(&point.row(lags)?, scales)?;
    let noise = variances(&point.variances, scales);
    let variances = std::iter::once(&noise.output).chain(noise.inputs.iter());
    let mut numbers = row.theta().iter().chain(variances);
    match numbers.find(|value| !value.is_finite()) {
        None => Ok((row, noise)),
        Some(&found) => Err(IdentError::CoefficientNotFinite {
            output: covariance.names()[0].clone(),
            found,
        }),
    }
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
