//! A fitted errors-in-variables model.

use gt_core::{OperatingPoint, Signal};
use nalgebra::{DMatrix, DVector};

use super::row::{EivRow, NoiseVariances};

/// The relative standard deviation beyond which a variance counts as not identifiable.
pub const IDENTIFIABLE_DEVIATION: f64 = 0.5;

/// The estimated variance of the white noise on a channel.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct EivVariance {
    /// The variance, in squared units of the channel.
    pub value: f64,
    /// Its standard deviation; infinite where the record does not tell.
    pub deviation: f64,
    /// Whether it stands at the lower bound of the search, a ten thousandth of the largest that
    /// the covariances admit: the true value may be anything below.
    pub at_lower_bound: bool,
    /// Whether it stands at the upper bound, 1.2 times the largest that the covariances admit.
    pub at_upper_bound: bool,
}

impl EivVariance {
    /// Whether the record tells the variance: a relative deviation of at most
    /// [`IDENTIFIABLE_DEVIATION`].
    pub fn identifiable(&self) -> bool {
        self.deviation <= IDENTIFIABLE_DEVIATION * self.value
    }
}

/// Relations between the noise-free channels and the variances of the noise, estimated together.
///
/// Deviations are the semiparametric bound (see [`super::Likelihood::information`]) at the
/// estimate, not the spread of repeated fits.
#[derive(Debug, Clone, PartialEq)]
pub struct EivEstimate {
    /// The inputs of the record.
    pub inputs: Vec<Signal>,
    /// The outputs of the record.
    pub outputs: Vec<Signal>,
    /// Sample time in seconds.
    pub sample_time_s: f64,
    /// The means, which were removed.
    pub operating_point: OperatingPoint,
    /// The relation of each output (`ny`); every one is stable.
    pub rows: Vec<EivRow>,
    /// Standard deviations of each row's coefficients, in their order.
    pub row_deviations: Vec<DVector<f64>>,
    /// Noise of each output (`ny`).
    pub output_noise: Vec<EivVariance>,
    /// Noise of each input (`nu`), shared by all outputs.
    pub input_noise: Vec<EivVariance>,
    /// Covariance of the coefficients of all rows, then output and input variances.
    pub covariance: DMatrix<f64>,
    /// `f` of [`super::Likelihood`] at the estimate; `-2 ln L = N f` up to a constant of the
    /// record and its spectrum.
    pub criterion: f64,
    /// Samples of the record, `N`.
    pub samples: usize,
    /// Order of the autoregression behind the spectrum.
    pub autoregression_order: usize,
    /// Frequencies at which the likelihood was taken.
    pub frequencies: usize,
    /// Whether `N < 20 n (m + r)`, so that the deviations promise too much.
    pub short_record: bool,
    /// Whether the descent met its tolerance.
    pub converged: bool,
    /// Evaluations of the likelihood, over all starts.
    pub evaluations: usize,
}

impl EivEstimate {
    /// The noise variances of an output's relation; `None` past the last output.
    pub fn noise(&self, output: usize) -> Option<NoiseVariances> {
        let own = self.output_noise.get(output)?;
        let inputs = self.input_noise.iter().map(|noise| noise.value);
        Some(NoiseVariances {
            output: own.value,
            inputs: DVector::from_iterator(self.input_noise.len(), inputs),
        })
    }
}
