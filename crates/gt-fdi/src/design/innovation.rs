//! One innovation of a Kalman filter.

use nalgebra::{Cholesky, DMatrix, DVector, Dyn};

/// The part of an output that its past did not tell.
#[derive(Debug, Clone, PartialEq)]
pub struct Innovation {
    /// `e = y - C x - D u` (ny), in the units of the outputs.
    pub value: DVector<f64>,
    /// Its covariance `L = C P C' + R` (ny x ny), in the products of those units.
    pub covariance: DMatrix<f64>,
    /// `W^-1 e` (ny) with the lower Cholesky factor `W W' = L`: unit covariance, no unit.
    pub normalised: DVector<f64>,
    /// `e' L^-1 e`, chi-square with ny degrees of freedom under the design's noise.
    pub squared: f64,
}

impl Innovation {
    pub(super) fn new(value: DVector<f64>, factor: &Cholesky<f64, Dyn>) -> Self {
        let normalised = whitened(factor, &value);
        let l = factor.l();
        Self {
            value,
            covariance: &l * l.transpose(),
            squared: normalised.norm_squared(),
            normalised,
        }
    }
}

/// `W^-1 e` with the lower factor W. The pivots of a Cholesky factor are positive, so that the
/// system has a solution; NaN would be the answer if it had none.
pub(super) fn whitened(factor: &Cholesky<f64, Dyn>, value: &DVector<f64>) -> DVector<f64> {
    let solved = factor.l_dirty().solve_lower_triangular(value);
    solved.unwrap_or_else(|| value.map(|_| f64::NAN))
}
