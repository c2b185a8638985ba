//! Poles and zeros that may be the same.

use nalgebra::{DMatrix, Matrix2, Vector2};
use serde::Serialize;

use super::Root;

/// A zero within this many standard errors of a pole is not told from it.
pub const CANCELLATION_LIMIT: f64 = 2.0;

/// A zero that is not told from a pole: with both gone the channel would be as well described.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Cancellation {
    /// Index of the pole in [`super::PoleZeroReport::poles`].
    pub pole: usize,
    /// Index of the zero in [`super::ChannelZeros::zeros`].
    pub zero: usize,
    /// Their distance in the plane of `z`.
    pub distance: f64,
    /// Their distance in standard errors of their difference (pole and zero come from the same
    /// coefficients: their errors are correlated); at most [`CANCELLATION_LIMIT`].
    pub standard_errors: f64,
}

impl Cancellation {
    /// The pair, where the two are not told apart. An unresolved root is told from nothing that
    /// its first-order error reaches, and one without any is not judged.
    pub(crate) fn between(
        (pole_index, pole): (usize, &Root),
        (zero_index, zero): (usize, &Root),
        covariances: &[DMatrix<f64>],
    ) -> Option<Self> {
        let difference = zero.value - pole.value;
        let known = |root: &Root| root.covariance.is_some() || !root.gradient.is_empty();
        if !known(pole) || !known(zero) {
            return None;
        }
        let covariance = zero.covariance_of_difference(pole, covariances);
        let standard_errors = mahalanobis(Vector2::new(difference.re, difference.im), covariance);
        (standard_errors <= CANCELLATION_LIMIT).then_some(Self {
            pole: pole_index,
            zero: zero_index,
            distance: difference.norm(),
            standard_errors,
        })
    }
}

/// The length of a vector in standard errors; a direction without error has only the length 0 or
/// infinity.
fn mahalanobis(vector: Vector2<f64>, covariance: Matrix2<f64>) -> f64 {
    if vector.norm() == 0.0 {
        return 0.0;
    }
    // The larger eigenvalue of a 2 x 2 matrix and its vector; real roots move along one axis.
    let decomposed = covariance.symmetric_eigen();
    let largest = decomposed.eigenvalues.max();
    if largest <= 0.0 {
        return f64::INFINITY;
    }
    let mut square = 0.0;
    for index in 0..2 {
        let along = decomposed.eigenvectors.column(index).dot(&vector);
        let variance = decomposed.eigenvalues[index].max(0.0);
        if variance > 1e-14 * largest {
            square += along * along / variance;
        } else if along.abs() > 1e-7 * vector.norm() {
            return f64::INFINITY;
        }
    }
    square.sqrt()
}
