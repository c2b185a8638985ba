//! Gauss-Legendre quadrature.

use std::f64::consts::PI;

/// Newton's iteration doubles the digits of a start good to three: four steps reach rounding.
const NEWTON_STEPS: usize = 6;

/// Nodes in `0..length` and their weights, `count` of each: exact for polynomials of degree
/// `2 count - 1`.
///
/// The roots of the Legendre polynomial by Newton's iteration from Tricomi's approximation
/// (Abramowitz and Stegun, 22.16.6 and 25.4.29).
pub(super) fn gauss_legendre(count: usize, length: f64) -> Vec<(f64, f64)> {
    let half = 0.5 * length;
    (1..=count)
        .map(|index| {
            let mut x = (PI * (index as f64 - 0.25) / (count as f64 + 0.5)).cos();
            let mut slope = 1.0;
            for _ in 0..NEWTON_STEPS {
                let (value, derivative) = legendre(count, x);
                slope = derivative;
                x -= value / derivative;
            }
            (
                half * (1.0 - x),
                2.0 * half / ((1.0 - x * x) * slope * slope),
            )
        })
        .collect()
}

/// The Legendre polynomial of degree `count >= 1` and its derivative, by the three-term recursion.
fn legendre(count: usize, x: f64) -> (f64, f64) {
    let (mut before, mut value) = (1.0, x);
    for degree in 2..=count {
        let n = degree as f64;
        let next = ((2.0 * n - 1.0) * x * value - (n - 1.0) * before) / n;
        (before, value) = (value, next);
    }
    let derivative = count as f64 * (before - x * value) / (1.0 - x * x);
    (value, derivative)
}
