//! The fit of an errors-in-variables model.

use gt_core::{Dataset, Never, Stop};
use nalgebra::{DMatrix, DVector};

use super::estimate::{EivEstimate, EivVariance};
use super::information::covariance;
use super::joint::estimate;
use super::layout::Layout;
use super::likelihood::Likelihood;
use super::record::{Record, autoregression_order};
use super::refine::Refined;
use super::row::{EivLags, EivRow, NoiseVariances};
use crate::IdentError;

/// An errors-in-variables model that is still to be fitted: a relation per output, inputs shared.
///
/// | Name | Default | Purpose | Range |
/// |---|---|---|---|
/// | `lags` | none | lags of each output's relation | one per output |
/// | `autoregression_order` | `max(2 n, min(60, N / (8 (m + r))))` | order of the spectrum | `1..` |
/// | `frequencies` | 256, 128 for several outputs | points of the likelihood | `1..` |
/// | `pole_prior` | 0 | weight of the prior that keeps needless poles off the unit circle | `0..` |
/// | `starts` | none | points to start from beside the built-in ones | one pair per output |
#[derive(Debug, Clone, PartialEq)]
pub struct Eiv {
    lags: Vec<EivLags>,
    autoregression_order: Option<usize>,
    frequencies: Option<usize>,
    pole_prior: f64,
    starts: Vec<Vec<(EivRow, NoiseVariances)>>,
}

impl Eiv {
    /// A model with the given lags, one entry per output.
    pub fn new(lags: Vec<EivLags>) -> Self {
        Self {
            lags,
            autoregression_order: None,
            frequencies: None,
            pole_prior: 0.0,
            starts: Vec::new(),
        }
    }

    /// The same model with another order of the autoregression behind the spectrum (at least 1).
    #[must_use]
    pub fn autoregression_order(mut self, order: usize) -> Self {
        self.autoregression_order = Some(order.max(1));
        self
    }

    /// The same model with another number of frequencies (at least 1).
    #[must_use]
    pub fn frequencies(mut self, count: usize) -> Self {
        self.frequencies = Some(count.max(1));
        self
    }

    /// The same model with a prior on the poles: `-2 ln L` grows by `-weight sum ln(1 - k^2)` over the
    /// reflection coefficients `k` of all denominators (the density `prod (1 - k^2)^(weight / 2)`).
    ///
    /// An order beyond what the record tells leaves poles that nearly cancel; without a prior they may
    /// ring at frequencies where the inputs have less power than their noise, and a free run is lost in
    /// it. A weight of 1 costs next to nothing where the record tells all parameters (S2 at 10 dB,
    /// N = 2000: RMSE 1.04 instead of 1.03 bounds); one of 10 holds even the poles of far too high an
    /// order off the circle, but is felt on a slow plant in strong noise (1.6 bounds). It is no
    /// default: on a short record it takes a side where the record takes none, and a variance that is
    /// not told (S2 at 10 dB, N = 200) passes for one that is. The better cure is the order that
    /// [`super::eiv_order_table`] finds. Deviations are those without the prior.
    #[must_use]
    pub fn pole_prior(mut self, weight: f64) -> Self {
        self.pole_prior = weight;
        self
    }

    /// The same model with another point to start from: a relation and its noise per output, in
    /// the units of the record. Unstable relations are made stable, variances moved into the
    /// bounds; input variances that differ between the outputs are averaged.
    #[must_use]
    pub fn start(mut self, start: Vec<(EivRow, NoiseVariances)>) -> Self {
        self.starts.push(start);
        self
    }

    /// Fits all relations and variances by profile Whittle maximum likelihood (see
    /// [`Likelihood`]): means are removed, channels scaled to unit deviation inside.
    ///
    /// # Errors
    /// [`IdentError::NoOutputs`], [`IdentError::NoInputs`] or [`IdentError::Dimension`] for a
    /// structure that does not fit the record; [`IdentError::EivTooFewSamples`];
    /// [`IdentError::PolePrior`]; [`IdentError::Data`] for a sample that is not finite; [`IdentError::ConstantChannel`];
    /// [`IdentError::EivScale`] for a channel whose deviation over- or underflows;
    /// [`IdentError::EivDetermined`] for a channel without noise of its own;
    /// [`IdentError::EivStartLags`], [`IdentError::EivStartValue`] or [`IdentError::Dimension`]
    /// for a start that does not fit; [`IdentError::EivNoStart`] where no relation was found.
    pub fn fit(&self, data: &Dataset) -> Result<EivEstimate, IdentError> {
        self.fit_until(data, &Never)
    }

    /// As [`Eiv::fit`], until `stop` wants it to end; it is asked at every evaluation of the
    /// likelihood.
    ///
    /// # Errors
    /// As [`Eiv::fit`]; [`IdentError::Stopped`].
    pub fn fit_until(&self, data: &Dataset, stop: &dyn Stop) -> Result<EivEstimate, IdentError> {
        let Some(first) = self.lags.first() else {
            return Err(IdentError::NoOutputs);
        };
        if first.inputs() == 0 {
            return Err(IdentError::NoInputs);
        }
        Record::check(data, self.lags.len(), first.inputs())?;
        let found = self.pole_prior;
        if !(found >= 0.0 && found.is_finite()) {
            return Err(IdentError::PolePrior { found });
        }
        // Before anything of the size of the order is allocated.
        let channels = data.ny() + data.nu();
        let longest = self.lags.iter().map(EivLags::order).max().unwrap_or(0);
        let own = autoregression_order(longest, channels, data.len());
        let order = self.autoregression_order.unwrap_or(own);
        Record::check_length(data.len(), channels, order.max(longest.saturating_mul(2)))?;
        let layout = Layout::new(&self.lags)?;
        self.check_starts(&layout)?;
        let frequencies = self
            .frequencies
            .unwrap_or(default_frequencies(layout.outputs));
        let record = Record::new(data, order, frequencies)?;
        let starts: Vec<Vec<f64>> = self
            .starts
            .iter()
            .map(|start| scaled_start(&layout, &record.scales, start))
            .collect();
        let prior = self.pole_prior / record.samples as f64;
        let joint = estimate(&record.spectrum, &self.lags, &starts, None, prior, stop)?;
        finish(data, &layout, &record, &joint.together)
    }

    fn check_starts(&self, layout: &Layout) -> Result<(), IdentError> {
        for (start, pairs) in self.starts.iter().enumerate() {
            gt_core::DimensionError::check(
                "outputs of a starting point",
                layout.outputs,
                pairs.len(),
            )?;
            for (output, (row, noise)) in pairs.iter().enumerate() {
                if row.lags() != &layout.lags[output] {
                    return Err(IdentError::EivStartLags { start, output });
                }
                gt_core::DimensionError::check(
                    "input variances of a starting point",
                    layout.inputs,
                    noise.inputs.len(),
                )?;
                let coefficients = row.theta().iter();
                let bad = coefficients.copied().find(|value| !value.is_finite());
                let mut variances = std::iter::once(&noise.output).chain(noise.inputs.iter());
                let bad = bad.or_else(|| {
                    variances
                        .find(|value| !(**value >= 0.0 && value.is_finite()))
                        .copied()
                });
                if let Some(found) = bad {
                    return Err(IdentError::EivStartValue {
                        start,
                        output,
                        found,
                    });
                }
            }
        }
        Ok(())
    }
}

/// Frequencies of the likelihood of so many outputs.
pub(super) fn default_frequencies(outputs: usize) -> usize {
    if outputs == 1 { 256 } else { 128 }
}

/// What a coefficient or variance in scaled units is multiplied by: `s_y / s_u` for an input
/// coefficient, squares for variances.
fn factors(layout: &Layout, scales: &[f64]) -> Vec<f64> {
    let coefficients = layout
        .entries
        .iter()
        .map(|entry| scales[entry.row] / scales[entry.channel]);
    coefficients
        .chain(scales.iter().map(|scale| scale * scale))
        .collect()
}

/// A starting point as one vector in units of the channels' deviations.
fn scaled_start(layout: &Layout, scales: &[f64], start: &[(EivRow, NoiseVariances)]) -> Vec<f64> {
    let mut point: Vec<f64> = Vec::with_capacity(layout.len());
    for (row, _) in start {
        point.extend(row.theta().iter());
    }
    point.extend(start.iter().map(|(_, noise)| noise.output));
    for input in 0..layout.inputs {
        let sum: f64 = start.iter().map(|(_, noise)| noise.inputs[input]).sum();
        point.push(sum / start.len() as f64);
    }
    for (value, factor) in point.iter_mut().zip(factors(layout, scales)) {
        *value /= factor;
    }
    point
}

/// The estimate in the units of the record, with its deviations.
fn finish(
    data: &Dataset,
    layout: &Layout,
    record: &Record,
    refined: &Refined,
) -> Result<EivEstimate, IdentError> {
    let likelihood = Likelihood::new(&layout.lags, &record.smooth)?;
    let information = likelihood.information(&refined.point)? * record.samples as f64;
    let factors = factors(layout, &record.scales);
    let scaled = covariance(&information);
    let count = layout.len();
    let covariance = DMatrix::from_fn(count, count, |i, j| {
        scaled[(i, j)] * factors[i] * factors[j]
    });
    let point: Vec<f64> = refined
        .point
        .iter()
        .zip(&factors)
        .map(|(value, factor)| value * factor)
        .collect();
    let deviation = |index: usize| covariance[(index, index)].sqrt();
    let starts = layout.row_starts();
    let row_deviations = layout.lags.iter().zip(starts).map(|(lags, start)| {
        DVector::from_fn(lags.parameters(), |index, _| deviation(start + index))
    });
    let first = layout.coefficients();
    let noise: Vec<EivVariance> = refined
        .at_bounds
        .iter()
        .enumerate()
        .map(|(channel, &(at_lower_bound, at_upper_bound))| EivVariance {
            value: point[first + channel],
            deviation: deviation(first + channel),
            at_lower_bound,
            at_upper_bound,
        })
        .collect();
    Ok(EivEstimate {
        inputs: data.inputs().to_vec(),
        outputs: data.outputs().to_vec(),
        sample_time_s: data.sample_time_s(),
        operating_point: record.point.clone(),
        rows: layout.rows(&point[..first])?,
        row_deviations: row_deviations.collect(),
        output_noise: noise[..layout.outputs].to_vec(),
        input_noise: noise[layout.outputs..].to_vec(),
        covariance,
        criterion: refined.value,
        samples: record.samples,
        autoregression_order: record.order,
        frequencies: record.spectrum.frequencies(),
        short_record: record.samples < 20 * layout.longest * layout.channels(),
        converged: refined.converged,
        evaluations: refined.evaluations,
    })
}
