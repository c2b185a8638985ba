//! Roots of a real polynomial.

use gt_core::ModelError;
use gt_core::la::as_faer;
use nalgebra::{Complex, DMatrix};

use crate::IdentError;

/// Newton steps after the eigenvalues; each is kept only where it makes the polynomial smaller.
const NEWTON_STEPS: usize = 3;

/// The roots of `sum coefficients[k] z^(n - k)`, highest power first, that are neither zero nor
/// infinite: zeros at either end of the coefficients are stripped.
///
/// They are the eigenvalues of the companion matrix of the polynomial in `z / s`, where `s` makes
/// the outer coefficients equal, polished by Newton's method.
pub(crate) fn roots(coefficients: &[f64]) -> Result<Vec<Complex<f64>>, IdentError> {
    let first = coefficients.iter().position(|&value| value != 0.0);
    let last = coefficients.iter().rposition(|&value| value != 0.0);
    let (Some(first), Some(last)) = (first, last) else {
        return Ok(Vec::new());
    };
    let stripped = &coefficients[first..=last];
    let order = stripped.len() - 1;
    if order == 0 {
        return Ok(Vec::new());
    }
    // By logarithms: the quotient of the outer coefficients may overflow.
    let ratio = stripped[order].abs().ln() - stripped[0].abs().ln();
    let scale = (ratio / order as f64).exp();
    let mut companion = DMatrix::zeros(order, order);
    let mut power = 1.0;
    for column in 0..order {
        power /= scale;
        companion[(0, column)] = -(stripped[column + 1] / stripped[0]) * power;
        if column + 1 < order {
            companion[(column + 1, column)] = 1.0;
        }
    }
    let stalled = IdentError::Model(ModelError::NoConvergence {
        order,
        iterations: 30 * order,
    });
    if !companion.iter().all(|value| value.is_finite()) {
        return Err(stalled);
    }
    let Ok(values) = as_faer(&companion).eigenvalues() else {
        return Err(stalled);
    };
    Ok(values
        .into_iter()
        .map(|value| polish(stripped, value * scale))
        .collect())
}

fn polish(coefficients: &[f64], start: Complex<f64>) -> Complex<f64> {
    let mut root = start;
    let (mut value, mut slope) = evaluate(coefficients, root);
    for _ in 0..NEWTON_STEPS {
        let next = root - value / slope;
        let (next_value, next_slope) = evaluate(coefficients, next);
        // A step to NaN is not smaller either.
        if next_value.norm() < value.norm() {
            (root, value, slope) = (next, next_value, next_slope);
        } else {
            break;
        }
    }
    root
}

/// The polynomial and its derivative by Horner's rule.
fn evaluate(coefficients: &[f64], z: Complex<f64>) -> (Complex<f64>, Complex<f64>) {
    let zero = Complex::new(0.0, 0.0);
    coefficients
        .iter()
        .fold((zero, zero), |(value, slope), &coefficient| {
            (value * z + coefficient, slope * z + value)
        })
}
