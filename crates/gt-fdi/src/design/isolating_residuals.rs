//! Combinations of residuals that each answer to one fault.

use std::ops::Range;

use gt_core::DimensionError;
use nalgebra::{DMatrix, DVector};
use serde::{Deserialize, Serialize};

use super::calibration::check_finite;
use super::signature::{Feature, check_window, feature};
use crate::FdiError;

/// Share of the largest energy that counts as noise in every direction, so that combinations whose
/// residuals cancel to rounding do not count as insensitive.
const FLOOR: f64 = 1e-10;

/// A linear combination of residuals for each fault that answers to it most, and least to the
/// others and to what moves the residuals without a fault: structured residuals (Gertler, *Fault
/// Detection and Diagnosis in Engineering Systems*, 1998), learned from records.
///
/// Combination `j` has the weights `w` with the largest `w' A w / w' B w`, where `A` is the energy of
/// feature `j` of the changes that fault `j` makes, `B` that of all other faults together and of the
/// healthy residuals themselves: the leading eigenvector of a generalised symmetric eigenproblem.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct IsolatingResiduals {
    /// A row of weights a fault, a column a residual, in one over the residual's unit: scaled so
    /// that fault `j` of the records gives combination `j` a feature of root mean square 1.
    pub weights: DMatrix<f64>,
}

impl IsolatingResiduals {
    /// Learns the combinations. `faulty` holds for each fault its name and residuals, `healthy` the
    /// residuals under the same operation; `features` has one a fault; `window` is a range of
    /// samples.
    ///
    /// # Errors
    /// [`FdiError`] when numbers of faults, residuals or samples differ, the window does not fit, a
    /// feature's window or the sample time is not positive, a sample is not finite, or a fault does
    /// not show ([`FdiError::NoEffect`]).
    pub fn learn(
        faulty: &[(&str, &[Vec<f64>])],
        healthy: &[Vec<f64>],
        features: &[Feature],
        sample_time_s: f64,
        window: Range<usize>,
    ) -> Result<Self, FdiError> {
        let len = check_window(healthy, features, sample_time_s, &window)?;
        DimensionError::check("features", faulty.len(), features.len())?;
        let size = healthy.len();
        check_residuals("healthy", healthy, (size, len))?;
        let mut changes = Vec::new();
        for (name, residuals) in faulty {
            check_residuals(name, residuals, (size, len))?;
            let pairs = residuals.iter().zip(healthy);
            let own = pairs.map(|(f, h)| f.iter().zip(h).map(|(f, h)| f - h).collect());
            changes.push(own.collect::<Vec<Vec<f64>>>());
        }
        let mut weights = DMatrix::zeros(faulty.len(), size);
        for (place, kind) in features.iter().enumerate() {
            let energy = |residuals: &[Vec<f64>]| {
                let rows: Vec<Vec<f64>> = residuals
                    .iter()
                    .map(|row| feature(row, sample_time_s, *kind)[window.clone()].to_vec())
                    .collect();
                let samples = window.len() as f64;
                DMatrix::from_fn(size, size, |i, j| {
                    let terms = rows[i].iter().zip(&rows[j]);
                    terms.map(|(left, right)| left * right).sum::<f64>() / samples
                })
            };
            let own = energy(&changes[place]);
            let mut others = energy(healthy);
            for (_, change) in changes.iter().enumerate().filter(|(i, _)| *i != place) {
                others += energy(change);
            }
            let row = leading(&own, &others).ok_or(FdiError::NoEffect)?;
            weights.row_mut(place).tr_copy_from(&row);
        }
        Ok(Self { weights })
    }

    /// The combinations of a run's residuals, a series a fault.
    ///
    /// # Errors
    /// [`FdiError`] when there is another number of residuals or their lengths differ.
    pub fn apply(&self, residuals: &[Vec<f64>]) -> Result<Vec<Vec<f64>>, FdiError> {
        let len = residuals.first().map_or(0, Vec::len);
        DimensionError::check("residuals", self.weights.ncols(), residuals.len())?;
        for own in residuals {
            DimensionError::check("samples of a residual", len, own.len())?;
        }
        let combine = |weights: DVector<f64>| {
            let mut combined = vec![0.0; len];
            for (weight, own) in weights.iter().zip(residuals) {
                for (to, value) in combined.iter_mut().zip(own) {
                    *to += weight * value;
                }
            }
            combined
        };
        let rows = self.weights.row_iter();
        Ok(rows.map(|row| combine(row.transpose())).collect())
    }
}

fn check_residuals(
    run: &str,
    residuals: &[Vec<f64>],
    (size, len): (usize, usize),
) -> Result<(), FdiError> {
    DimensionError::check(&format!("residuals of `{run}`"), size, residuals.len())?;
    for own in residuals {
        DimensionError::check(&format!("samples of a residual of `{run}`"), len, own.len())?;
        check_finite(&format!("residuals of `{run}`"), own)?;
    }
    Ok(())
}

/// The vector `w` with the largest `w' A w / w' B w`, scaled to `w' A w = 1`; `None` where `A` is
/// zero.
fn leading(own: &DMatrix<f64>, others: &DMatrix<f64>) -> Option<DVector<f64>> {
    // Each residual in a unit of its own, so that none is lost beside a large one.
    let total = own + others;
    let unit = total.diagonal().map(f64::sqrt);
    let scaled = |matrix: &DMatrix<f64>| {
        DMatrix::from_fn(matrix.nrows(), matrix.ncols(), |i, j| {
            let product = unit[i] * unit[j];
            if product > 0.0 {
                matrix[(i, j)] / product
            } else {
                0.0
            }
        })
    };
    let (own_scaled, mut others_scaled) = (scaled(own), scaled(others));
    for i in 0..others_scaled.nrows() {
        others_scaled[(i, i)] += FLOOR;
    }
    let root = others_scaled.cholesky()?.l();
    let half = root.solve_lower_triangular(&own_scaled)?;
    let whole = root.solve_lower_triangular(&half.transpose())?;
    let parts = ((&whole + whole.transpose()) * 0.5).symmetric_eigen();
    let (place, largest) = parts.eigenvalues.argmax();
    if largest.is_nan() || largest <= 0.0 {
        return None;
    }
    let leading = parts.eigenvectors.column(place).into_owned();
    let mut weights = root.tr_solve_lower_triangular(&leading)?;
    for (weight, unit) in weights.iter_mut().zip(unit.iter()) {
        *weight = if *unit > 0.0 { *weight / unit } else { 0.0 };
    }
    let size = weights.dot(&(own * &weights)).sqrt();
    // The largest part counts positive: a sign that rounding does not turn.
    let sign = weights[weights.iamax()].signum();
    (size > 0.0).then(|| weights * (sign / size))
}
