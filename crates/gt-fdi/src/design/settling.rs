//! How fast a linear recursion forgets its start.

use nalgebra::DMatrix;

use super::generator::{MAX_SETTLE_SAMPLES, SETTLE_LEVEL};

/// The smallest `k` with `||closed^j||_2 < SETTLE_LEVEL` for all `j >= k`, or `None` beyond
/// [`MAX_SETTLE_SAMPLES`].
pub(super) fn settling(closed: &DMatrix<f64>) -> Option<usize> {
    let nx = closed.nrows();
    if nx == 0 {
        return Some(0);
    }
    let mut power = DMatrix::<f64>::identity(nx, nx);
    let mut next = power.clone();
    let mut settled = 0;
    let mut largest = 0.0_f64;
    for k in 0..=MAX_SETTLE_SAMPLES {
        let frobenius = power.norm();
        if !frobenius.is_finite() {
            return None;
        }
        if !spectral_norm_below(&power, frobenius, SETTLE_LEVEL) {
            settled = k + 1;
        }
        largest = largest.max(frobenius);
        // The norm is submultiplicative: from here on, every power is this one times one of the
        // powers seen, and so on, none of them above the level.
        if frobenius * largest < SETTLE_LEVEL {
            return Some(settled);
        }
        power.mul_to(closed, &mut next);
        core::mem::swap(&mut power, &mut next);
    }
    None
}

/// Whether `||matrix||_2 < level`; the Frobenius norm settles most cases without singular values.
fn spectral_norm_below(matrix: &DMatrix<f64>, frobenius: f64, level: f64) -> bool {
    if frobenius < level {
        return true;
    }
    if frobenius >= level * (matrix.nrows() as f64).sqrt() {
        return false;
    }
    let largest = (matrix.transpose() * matrix).symmetric_eigenvalues().max();
    largest.sqrt() < level
}

/// Largest modulus of an eigenvalue; NaN when the iteration does not converge.
pub(super) fn spectral_radius(matrix: &DMatrix<f64>) -> f64 {
    let largest = matrix.amax();
    if matrix.is_empty() || largest == 0.0 {
        return 0.0;
    }
    // Scaled as in `StateSpace::poles`: near a double eigenvalue the rounding of the scaling that
    // the decomposition does itself can make an imaginary part NaN.
    let iterations = 100 * matrix.nrows();
    let schur = nalgebra::Schur::try_new(matrix / largest, f64::EPSILON, iterations);
    schur.map_or(f64::NAN, |schur| {
        let moduli = schur.complex_eigenvalues().map(nalgebra::Complex::norm);
        if moduli.iter().any(|modulus| modulus.is_nan()) {
            f64::NAN
        } else {
            largest * moduli.max()
        }
    })
}
