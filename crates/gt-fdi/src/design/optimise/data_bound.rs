//! What no filter of a class could do better than, on the same records.

use nalgebra::{DMatrix, DVector, SymmetricEigen};
use serde::{Deserialize, Serialize};

use super::energy_ratio::EnergyRatio;
use super::sections::Sections;

/// A column of the basis counts as a combination of those before when less than this share of it
/// is left without them.
const DEPENDENT: f64 = 1e-13;
/// Iterations per eigenvalue after which the eigenvalue problem is given up.
const EIGEN_ITERATIONS: usize = 100;

/// The least ratio of a criterion over all filters of the equation error in a finite span:
/// `lambda_min(R_h, R_f)`, `R = sum b(eps) b(eps)'`, a convex problem without local minima.
///
/// The span is `N(z^-1) / (P(z^-1) (1 - p z^-1)^q)` with any numerator `N` of degree `n + q`, for the
/// poles `P` (n) that were found and `q` more at `p`: the basis `b` is the equation error itself and
/// the Laguerre functions of `p` behind the like ones of the sections of `P` (S. Takenaka 1925,
/// F. Malmquist 1925), filtered without truncation. So it bounds the V of the observer found and of
/// all observers with up to `q` poles at `p` and the others at 0; others come closer as `q` grows,
/// and may lie below. With many functions it fits the records rather than the fault, which
/// `validation` shows.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct DataBound {
    /// The least ratio; 0 when the healthy records leave a combination of the basis without energy.
    pub value: f64,
    /// The ratio of the same filter on the validation records, if there are any.
    pub validation: Option<f64>,
    /// The pole `p` of the Laguerre functions.
    pub pole: f64,
    /// The filter: weights of the equation error, of the `n` functions of the poles found and of
    /// the `q` Laguerre functions, unscaled (n + q + 1); 0 when `value` is.
    pub weights: Vec<f64>,
}

impl DataBound {
    /// The bound for these sections and `functions` Laguerre functions with the pole `pole`, inside
    /// the unit circle; `None` when an eigenvalue problem is not solved.
    pub(super) fn of(
        training: &EnergyRatio,
        validation: Option<&EnergyRatio>,
        found: &Sections,
        pole: f64,
        functions: usize,
    ) -> Option<Self> {
        let laguerre = Sections::new(DVector::from_element(1, -pole));
        let mut chain = found.parts();
        chain.extend(std::iter::repeat_n(laguerre, functions));
        let size = found.order() + functions + 1;
        let basis = |errors: &[Vec<f64>], skip: usize| stacked(errors, skip, &chain, size);
        let mut healthy = basis(&training.healthy, training.skip);
        let mut effect = basis(&training.effect, training.skip);
        let scales = DVector::from_iterator(
            size,
            healthy.column_iter().map(|column| {
                let norm = column.norm();
                if norm > 0.0 { 1.0 / norm } else { 1.0 }
            }),
        );
        for (column, scale) in scales.iter().enumerate() {
            healthy.column_mut(column).scale_mut(*scale);
            effect.column_mut(column).scale_mut(*scale);
        }
        // Ratios of R_h and R_f are those of their factors: v = R^-1 w with X_h = Q R.
        let r = healthy.clone().qr().r();
        let independent = r.diagonal().iter().all(|value| value.abs() > DEPENDENT);
        let weights = if independent {
            let of_effect = effect.clone().qr().r();
            let quotient = r.tr_solve_upper_triangular(&of_effect.transpose())?;
            let square = &quotient * quotient.transpose();
            let iterations = EIGEN_ITERATIONS * size;
            let eigen = SymmetricEigen::try_new(square, f64::EPSILON, iterations)?;
            let largest = eigen.eigenvectors.column(eigen.eigenvalues.imax());
            r.solve_upper_triangular(&largest.into_owned())?
        } else {
            DVector::zeros(size)
        };
        let value = if independent {
            (&healthy * &weights).norm_squared() / (&effect * &weights).norm_squared()
        } else {
            0.0
        };
        let weights = weights.component_mul(&scales);
        let validation = validation.filter(|_| independent).map(|records| {
            let through =
                |errors: &[Vec<f64>]| (basis(errors, records.skip) * &weights).norm_squared();
            through(&records.healthy) / through(&records.effect)
        });
        Some(Self {
            value,
            validation,
            pole,
            weights: weights.as_slice().to_vec(),
        })
    }
}

/// The basis of all records below each other, a function a column (N in all x `size`).
fn stacked(errors: &[Vec<f64>], skip: usize, chain: &[Sections], size: usize) -> DMatrix<f64> {
    let rows: usize = errors.iter().map(|error| error.len() - skip).sum();
    let mut basis = DMatrix::zeros(rows, size);
    let mut row = 0;
    for error in errors {
        let kept = error.len() - skip;
        let mut keep = |column: usize, signal: &[f64]| {
            let mut place = basis.view_mut((row, column), (kept, 1));
            place.copy_from_slice(&signal[skip..]);
        };
        keep(0, error);
        let mut column = 1;
        let mut signal = error.clone();
        for section in chain {
            // The signal through 1 / S, delayed by one sample and, for two poles, by another; then
            // on through the all-pass with the coefficients of S in reverse over S.
            let filtered = section.filter(&signal);
            signal = filtered
                .iter()
                .map(|value| value * section.last())
                .collect();
            let mut delayed = filtered;
            for coefficient in section.reversed() {
                delay(&mut delayed);
                keep(column, &delayed);
                column += 1;
                for (sum, value) in signal.iter_mut().zip(&delayed) {
                    *sum += coefficient * value;
                }
            }
        }
        row += kept;
    }
    basis
}

fn delay(signal: &mut [f64]) {
    signal.rotate_right(1);
    if let Some(first) = signal.first_mut() {
        *first = 0.0;
    }
}
