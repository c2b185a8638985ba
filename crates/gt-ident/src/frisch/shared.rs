//! The Frisch scheme for several outputs with the noise of their inputs in common.

use gt_core::{Dataset, Never, Stop};
use nalgebra::DVector;

use super::covariance::{LaggedCovariance, ScaledRecord};
use super::criterion::Objective;
use super::estimate::{FrischNoise, channel_noise, in_units};
use super::fit::{Frisch, noise_errors};
use super::nelder_mead::nelder_mead;
use super::search::{ZERO_SHARE, best_of_grid, limits};
use crate::IdentError;
use crate::eiv::EivRow;

/// The relations of all outputs, with one variance of the noise on each input.
#[derive(Debug, Clone, PartialEq)]
pub struct SharedFrischEstimate {
    /// The relation of each output (`ny`).
    pub rows: Vec<EivRow>,
    /// Variance of the noise on each output (`ny`), in squared units of the channels.
    pub output_noise: DVector<f64>,
    /// Variance of the noise on each input (`nu`), in squared units of the channels.
    pub input_noise: DVector<f64>,
    /// What is known of each variance, the outputs first. The largest admissible variance and the
    /// standard error of an input are those of the output that knows most of it.
    pub channels: Vec<FrischNoise>,
    /// The least sum of the outputs' criteria, for channels of unit deviation.
    pub criterion_value: f64,
    /// Rows of the window.
    pub window_rows: usize,
}

impl Frisch {
    /// The relations of all outputs of a record; the noise of an input is that of every relation
    /// it enters.
    ///
    /// The input variances are sought in the intersection of the outputs' admissible sets; each
    /// output's own variance follows ([`super::AdmissibleSurface::at_inputs`]). The sum of the
    /// outputs' criteria is least there, each for channels of unit deviation.
    ///
    /// # Errors
    /// What [`Frisch::fit`] refuses, for any output; [`IdentError::NoOutputs`];
    /// [`IdentError::NoRelation`] where no point that all outputs admit has their relations.
    pub fn fit_shared(&self, data: &Dataset) -> Result<SharedFrischEstimate, IdentError> {
        self.fit_shared_until(data, &Never)
    }

    /// As [`Frisch::fit_shared`], until `stop` wants it to end; it is asked at every evaluation of
    /// the criterion.
    ///
    /// # Errors
    /// As [`Frisch::fit_shared`]; [`IdentError::Stopped`].
    pub fn fit_shared_until(
        &self,
        data: &Dataset,
        stop: &dyn Stop,
    ) -> Result<SharedFrischEstimate, IdentError> {
        self.check(data)?;
        let max_lag = self.selection().max_lag(self.lags().order());
        let records = (0..data.ny())
            .map(|output| ScaledRecord::new(data, output))
            .collect::<Result<Vec<_>, _>>()?;
        let covariances = records
            .iter()
            .map(|record| LaggedCovariance::of_scaled(record, max_lag))
            .collect::<Result<Vec<_>, _>>()?;
        let objectives = covariances
            .iter()
            .map(|covariance| Objective::new(self.lags(), self.selection(), covariance))
            .collect::<Result<Vec<_>, _>>()?;
        let Some(first) = covariances.first() else {
            return Err(IdentError::NoOutputs);
        };

        let largest = common_intercepts(&objectives);
        let value_at = |inputs: &[f64]| -> f64 {
            if stop.is_stopped() {
                return f64::INFINITY;
            }
            let values = objectives.iter().map(|objective| {
                let point = objective.surface().at_inputs(inputs);
                point.map_or(f64::INFINITY, |point| objective.value(&point))
            });
            values.sum()
        };
        let least = least_inputs(&largest, value_at);
        stop.check()?;
        let Some((inputs, criterion_value)) = least else {
            return Err(IdentError::NoRelation {
                output: first.names()[0].clone(),
            });
        };

        let mut found = SharedFrischEstimate {
            rows: Vec::with_capacity(data.ny()),
            output_noise: DVector::zeros(data.ny()),
            input_noise: DVector::zeros(data.nu()),
            channels: Vec::with_capacity(data.ny() + data.nu()),
            criterion_value,
            window_rows: first.window_rows(),
        };
        let mut of_inputs: Vec<FrischNoise> = Vec::new();
        for (output, objective) in objectives.iter().enumerate() {
            let (record, covariance) = (&records[output], &covariances[output]);
            let surface = objective.surface();
            let point = surface.at_inputs(&inputs)?;
            let scales = covariance.scales();
            let (row, noise) = in_units(self.lags(), &point, covariance)?;
            found.rows.push(row);
            found.output_noise[output] = noise.output;
            found.input_noise = noise.inputs;
            stop.check()?;
            let errors = noise_errors(self.lags(), record, covariance, &point);
            let mut known = channel_noise(&point, surface.intercepts(), &errors, scales, output);
            let inputs = known.split_off(1);
            found.channels.append(&mut known);
            of_inputs = most_known(of_inputs, inputs);
        }
        found.channels.append(&mut of_inputs);
        Ok(found)
    }
}

/// For each input the smaller bound and the smaller standard error.
fn most_known(mut some: Vec<FrischNoise>, other: Vec<FrischNoise>) -> Vec<FrischNoise> {
    if some.is_empty() {
        return other;
    }
    for (known, other) in some.iter_mut().zip(other) {
        known.largest = known.largest.min(other.largest);
        known.least_standard_error = known.least_standard_error.min(other.least_standard_error);
        known.at_boundary &= other.at_boundary;
    }
    some
}

/// The smallest of the outputs' largest variances, of each input.
fn common_intercepts(objectives: &[Objective]) -> Vec<f64> {
    let mut each = objectives
        .iter()
        .map(|objective| objective.surface().intercepts()[1..].to_vec());
    let first = each.next().unwrap_or_default();
    each.fold(first, |common, other| {
        let pairs = common.iter().zip(&other);
        pairs.map(|(a, b)| a.min(*b)).collect()
    })
}

/// The input variances where `f` is least, and its value.
///
/// The admissible sets are convex and hold the origin and the points `largest_j` of the axes, so
/// that they hold the simplex between them: the grid starts there.
fn least_inputs(largest: &[f64], f: impl Fn(&[f64]) -> f64) -> Option<(Vec<f64>, f64)> {
    /// Variances of the grid keep off the border, where a square root has no finite value.
    const LARGEST_SHARE: f64 = 0.98;
    let nu = largest.len();
    if nu == 0 {
        let value = f(&[]);
        return value.is_finite().then(|| (Vec::new(), value));
    }
    let inputs = |x: &DVector<f64>| -> Vec<f64> {
        let pairs = x.iter().zip(largest);
        pairs
            .map(|(root, largest)| {
                let share = root * root / (1.0 + root * root);
                if share < ZERO_SHARE {
                    0.0
                } else {
                    share * largest
                }
            })
            .collect()
    };
    let roots = |shares: &[f64]| {
        let root = |share: &f64| {
            let share = share.min(LARGEST_SHARE);
            (share / (1.0 - share)).sqrt()
        };
        DVector::from_iterator(nu, shares[1..].iter().map(root))
    };
    let mut best: Option<(Vec<f64>, f64)> = None;
    for (shares, _) in best_of_grid(nu + 1, |shares| f(&inputs(&roots(shares)))) {
        let (x, value) = nelder_mead(|x| f(&inputs(x)), &roots(&shares), limits(nu));
        if best.as_ref().is_none_or(|(_, least)| value < *least) {
            best = Some((inputs(&x), value));
        }
    }
    best
}
