//! What several healthy residuals look like together: their mean and their joint colour.

use gt_core::stored_matrix;
use nalgebra::{Cholesky, DMatrix, DVector};
use serde::{Deserialize, Serialize};

use super::whitening::MAX_WHITENING_ORDER;
use crate::FdiError;
use crate::runtime;

/// Samples needed for each coefficient of a vector autoregression.
const SAMPLES_A_COEFFICIENT: usize = 4;
/// White noise that is added to each residual, as a share of its variance: residuals without noise
/// would otherwise be predicted to the last digit, and whatever those digits do would be a fault.
const NOISE_FLOOR: f64 = 1e-6;

/// Samples that count for the order at most: beyond, the criterion finds colour that is certain and
/// changes nothing, and every order more is one more way for directions to turn.
const MOST_COUNTED: usize = 100_000;

/// How `m` residuals become white together, with unit covariance, while the plant is healthy:
/// `v(t) = W (e(t) + A_1 e(t-1) + ... + A_p e(t-p))` with `e = r - mean`, a vector autoregression.
///
/// Noise on an input reaches all outputs, and the slower the more alike: the residuals of the
/// outputs are then nearly independent from sample to sample and nearly one over minutes, which is
/// when slow faults show. Whitening each by itself does not see that; the matrices `A_k (m x m)` do.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(try_from = "Unchecked")]
pub struct JointWhitening {
    mean: DVector<f64>,
    /// `A_1 .. A_p`, each `m x m`, in the residuals' units.
    coefficients: Vec<DMatrix<f64>>,
    /// `W (m x m)`, lower triangular.
    factor: DMatrix<f64>,
}

/// The fields of a [`JointWhitening`] as they come from a file.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Unchecked {
    mean: DVector<f64>,
    coefficients: Vec<Stored>,
    #[serde(deserialize_with = "stored_matrix")]
    factor: DMatrix<f64>,
}

#[derive(Deserialize)]
struct Stored(#[serde(deserialize_with = "stored_matrix")] DMatrix<f64>);

impl TryFrom<Unchecked> for JointWhitening {
    type Error = FdiError;

    fn try_from(raw: Unchecked) -> Result<Self, FdiError> {
        let size = raw.mean.len();
        if size == 0 {
            return Err(FdiError::NoHealthyData);
        }
        if raw.coefficients.len() > MAX_WHITENING_ORDER {
            return Err(FdiError::Option {
                option: "whitening coefficients",
                expected: "at most 30 matrices",
                found: raw.coefficients.len() as f64,
            });
        }
        let coefficients: Vec<DMatrix<f64>> = raw
            .coefficients
            .into_iter()
            .map(|stored| stored.0)
            .collect();
        for matrix in coefficients.iter().chain([&raw.factor]) {
            for (what, found) in [("rows", matrix.nrows()), ("columns", matrix.ncols())] {
                gt_core::DimensionError::check(&format!("joint whitening, {what}"), size, found)?;
            }
        }
        let mut numbers = raw.mean.iter().chain(&raw.factor);
        let of_coefficients = coefficients
            .iter()
            .flatten()
            .find(|value| !value.is_finite());
        if let Some(&found) = numbers.find(|value| !value.is_finite()).or(of_coefficients) {
            return Err(FdiError::Option {
                option: "joint whitening",
                expected: "finite numbers",
                found,
            });
        }
        if let Some(&found) = raw.factor.diagonal().iter().find(|&&value| value <= 0.0) {
            return Err(FdiError::Option {
                option: "joint whitening's diagonal",
                expected: "numbers above 0",
                found,
            });
        }
        Ok(Self {
            mean: raw.mean,
            coefficients,
            factor: raw.factor,
        })
    }
}

impl JointWhitening {
    /// The whitening of healthy residuals: a matrix (m x N) a record, a column a sample. The order
    /// is the one that the Bayesian information criterion chooses, up to [`MAX_WHITENING_ORDER`], as
    /// if there were no more than 100 000 samples;
    /// the coefficients solve the Yule-Walker equations over all records (Whittle's recursion,
    /// *Biometrika* 50, 1963), so that the whitening can be undone stably.
    ///
    /// # Errors
    /// [`FdiError::NoHealthyData`] without a sample, [`FdiError::HealthySamples`] with fewer than
    /// four for each coefficient of order 1, [`FdiError::ConstantResidual`] of one that does not
    /// move.
    pub fn estimate(records: &[&DMatrix<f64>]) -> Result<Self, FdiError> {
        let samples: usize = records.iter().map(|record| record.ncols()).sum();
        let size = records.first().map_or(0, |record| record.nrows());
        if samples == 0 || size == 0 {
            return Err(FdiError::NoHealthyData);
        }
        let needed = SAMPLES_A_COEFFICIENT * size * (size + 1);
        if samples < needed {
            return Err(FdiError::HealthySamples {
                record: 0,
                needed,
                found: samples,
            });
        }
        let mut mean = DVector::zeros(size);
        for record in records {
            mean += record.column_sum();
        }
        mean /= samples as f64;
        let highest = MAX_WHITENING_ORDER.min(samples / needed);
        let mut covariances = lagged_covariances(records, &mean, highest, samples);
        let deviations = covariances[0].diagonal().map(f64::sqrt);
        let still = |deviation: &f64| !(*deviation > 0.0 && deviation.is_finite());
        if let Some(index) = deviations.iter().position(still) {
            return Err(FdiError::ConstantResidual {
                index,
                found: deviations[index],
            });
        }
        for covariance in &mut covariances {
            for row in 0..size {
                for column in 0..size {
                    covariance[(row, column)] /= deviations[row] * deviations[column];
                }
            }
        }
        for index in 0..size {
            covariances[0][(index, index)] += NOISE_FLOOR;
        }
        let no_root = || FdiError::ConstantResidual {
            index: 0,
            found: 0.0,
        };
        let (scaled, covariance) = autoregression(&covariances, samples).ok_or_else(no_root)?;
        let root = Cholesky::new(covariance)
            .and_then(|own| {
                own.l()
                    .solve_lower_triangular(&DMatrix::identity(size, size))
            })
            .ok_or_else(no_root)?;
        // Back from residuals of unit variance to those in their units.
        let unit = DMatrix::from_diagonal(&deviations);
        let per_unit = DMatrix::from_diagonal(&deviations.map(f64::recip));
        let coefficients = scaled
            .iter()
            .map(|matrix| &unit * matrix * &per_unit)
            .collect();
        Ok(Self {
            mean,
            coefficients,
            factor: root * per_unit,
        })
    }

    /// The healthy means (m) in the residuals' units.
    pub fn mean(&self) -> &DVector<f64> {
        &self.mean
    }

    /// `A_1 .. A_p`, each `m x m`, entry `(i, j)` in units of residual `i` per unit of residual `j`.
    pub fn coefficients(&self) -> &[DMatrix<f64>] {
        &self.coefficients
    }

    /// `W (m x m)`, lower triangular, in inverse units of the residuals.
    pub fn factor(&self) -> &DMatrix<f64> {
        &self.factor
    }

    /// The order `p` of the autoregression.
    pub fn order(&self) -> usize {
        self.coefficients.len()
    }

    /// The whitened residuals (m x N) of residuals (m x N) in their units, whose past is at the
    /// mean; not finite where one of the last `p + 1` samples is not.
    ///
    /// # Errors
    /// [`gt_core::DimensionError`] for another number of residuals.
    pub fn whiten(&self, residuals: &DMatrix<f64>) -> Result<DMatrix<f64>, FdiError> {
        let mut centred = residuals.clone();
        gt_core::DimensionError::check("residuals", self.mean.len(), residuals.nrows())?;
        for mut column in centred.column_iter_mut() {
            column -= &self.mean;
        }
        Ok(self.filter(&centred))
    }

    /// What the whitening makes of a change of the residuals (m x N).
    ///
    /// # Errors
    /// As [`JointWhitening::whiten`].
    pub fn response(&self, change: &DMatrix<f64>) -> Result<DMatrix<f64>, FdiError> {
        gt_core::DimensionError::check("residuals", self.mean.len(), change.nrows())?;
        Ok(self.filter(change))
    }

    /// In flat arrays, for residuals round `mean`, each component over its `scale` (m).
    pub(super) fn runtime(
        &self,
        mean: &DVector<f64>,
        scale: &DVector<f64>,
    ) -> runtime::JointWhitener {
        let by_rows = |matrix: &DMatrix<f64>| matrix.transpose().as_slice().to_vec();
        let per_scale = DMatrix::from_diagonal(&scale.map(f64::recip));
        runtime::JointWhitener::new(runtime::JointWhitenerParts {
            mean: mean.as_slice().to_vec(),
            coefficients: self.coefficients.iter().map(by_rows).collect(),
            factor: by_rows(&(per_scale * &self.factor)),
        })
    }

    /// `W (I + A_1 + ... + A_p) (m x m)`: what a lasting change of the residuals becomes.
    pub fn steady_gain(&self) -> DMatrix<f64> {
        let size = self.mean.len();
        let sum = self.coefficients.iter();
        &self.factor * sum.fold(DMatrix::identity(size, size), |sum, matrix| sum + matrix)
    }

    fn filter(&self, centred: &DMatrix<f64>) -> DMatrix<f64> {
        let mut errors = centred.clone();
        for (index, matrix) in self.coefficients.iter().enumerate() {
            let lag = index + 1;
            if lag >= centred.ncols() {
                break;
            }
            let kept = centred.ncols() - lag;
            let mut later = errors.columns_mut(lag, kept);
            later.gemm(1.0, matrix, &centred.columns(0, kept), 1.0);
        }
        &self.factor * errors
    }
}

/// `E[e(t) e(t-k)']` for `k = 0 ..= highest`.
fn lagged_covariances(
    records: &[&DMatrix<f64>],
    mean: &DVector<f64>,
    highest: usize,
    samples: usize,
) -> Vec<DMatrix<f64>> {
    let mut sums = vec![DMatrix::zeros(mean.len(), mean.len()); highest + 1];
    for record in records {
        let mut centred = (*record).clone();
        for mut column in centred.column_iter_mut() {
            column -= mean;
        }
        for (lag, sum) in sums.iter_mut().enumerate().take(record.ncols()) {
            let kept = record.ncols() - lag;
            sum.gemm(
                1.0,
                &centred.columns(lag, kept),
                &centred.columns(0, kept).transpose(),
                1.0,
            );
        }
    }
    for sum in &mut sums {
        *sum /= samples as f64;
    }
    sums
}

/// The coefficients of the order that the criterion chooses, with the covariance of the errors.
fn autoregression(
    covariances: &[DMatrix<f64>],
    samples: usize,
) -> Option<(Vec<DMatrix<f64>>, DMatrix<f64>)> {
    let size = covariances[0].nrows();
    let counted = samples.min(MOST_COUNTED) as f64;
    let penalty = (size * size) as f64 * counted.ln() / counted;
    let (mut forward, mut backward): (Vec<DMatrix<f64>>, Vec<DMatrix<f64>>) = (vec![], vec![]);
    let (mut ahead, mut behind) = (covariances[0].clone(), covariances[0].clone());
    let mut best = (log_determinant(&ahead)?, Vec::new(), ahead.clone());
    for order in 1..covariances.len() {
        let terms = forward.iter().enumerate();
        let cross = terms.fold(covariances[order].clone(), |sum, (index, matrix)| {
            sum + matrix * &covariances[order - 1 - index]
        });
        let Some((for_ahead, for_behind)) =
            Cholesky::new(behind.clone()).zip(Cholesky::new(ahead.clone()))
        else {
            break;
        };
        let new_forward = -for_ahead.solve(&cross.transpose()).transpose();
        let new_backward = -for_behind.solve(&cross).transpose();
        let before = forward.clone();
        for (index, matrix) in forward.iter_mut().enumerate() {
            *matrix += &new_forward * &backward[order - 2 - index];
        }
        for (index, matrix) in backward.iter_mut().enumerate() {
            *matrix += &new_backward * &before[order - 2 - index];
        }
        ahead += &new_forward * cross.transpose();
        behind += &new_backward * &cross;
        forward.push(new_forward);
        backward.push(new_backward);
        ahead = symmetric(&ahead);
        behind = symmetric(&behind);
        let Some(logarithm) = log_determinant(&ahead) else {
            break;
        };
        let criterion = logarithm + order as f64 * penalty;
        if criterion < best.0 {
            best = (criterion, forward.clone(), ahead.clone());
        }
    }
    Some((best.1, best.2))
}

fn symmetric(matrix: &DMatrix<f64>) -> DMatrix<f64> {
    (matrix + matrix.transpose()) * 0.5
}

fn log_determinant(matrix: &DMatrix<f64>) -> Option<f64> {
    let root = Cholesky::new(matrix.clone())?;
    let logarithms = root.l_dirty().diagonal().map(f64::ln);
    Some(2.0 * logarithms.sum())
}
