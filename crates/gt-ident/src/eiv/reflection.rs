//! Stable polynomials by their reflection coefficients (Levinson's and Schur and Cohn's recursion).

use nalgebra::{DMatrix, linalg::Schur};

use super::hermitian::C64;

/// Poles of a starting point are moved inside this radius: further out a start sits on a plateau
/// of the reflection coefficients. The estimate itself may go further.
pub(super) const START_RADIUS: f64 = 0.985;

/// `a_1..a_n` of `1 + a_1 q^-1 + .. + a_n q^-n` from its reflection coefficients, and the Jacobian
/// `da/dk (n x n)`. All roots lie inside the unit circle exactly where every `|k_i| < 1`.
pub(super) fn step_up(k: &[f64]) -> (Vec<f64>, DMatrix<f64>) {
    let n = k.len();
    let mut a: Vec<f64> = Vec::with_capacity(n);
    let mut jacobian = DMatrix::zeros(n, n);
    for (order, &k) in k.iter().enumerate() {
        let (before, jacobian_before) = (a.clone(), jacobian.clone());
        for j in 0..order {
            let mirror = order - 1 - j;
            a[j] += k * before[mirror];
            for l in 0..order {
                jacobian[(j, l)] += k * jacobian_before[(mirror, l)];
            }
            jacobian[(j, order)] = before[mirror];
        }
        a.push(k);
        jacobian[(order, order)] = 1.0;
    }
    (a, jacobian)
}

/// The reflection coefficients of `1 + a_1 q^-1 + ..`; `None` where it has a root on or outside
/// the unit circle.
pub(super) fn step_down(a: &[f64]) -> Option<Vec<f64>> {
    let mut a = a.to_vec();
    let mut reflections = vec![0.0; a.len()];
    for order in (0..a.len()).rev() {
        let k = a[order];
        if k.is_nan() || k.abs() >= 1.0 {
            return None;
        }
        reflections[order] = k;
        let scale = 1.0 - k * k;
        let before = a.clone();
        for j in 0..order {
            a[j] = (before[j] - k * before[order - 1 - j]) / scale;
        }
    }
    Some(reflections)
}

/// The polynomial with unstable roots mirrored in the unit circle and radii limited to
/// [`START_RADIUS`]; `None` where that changes nothing. Roots that cannot be found are replaced by
/// those of the polynomial with shrunken lags.
pub(super) fn stabilised(a: &[f64]) -> Option<Vec<f64>> {
    let n = a.len();
    let mut companion = DMatrix::zeros(n, n);
    for (j, &value) in a.iter().enumerate() {
        companion[(0, j)] = -value;
        if j + 1 < n {
            companion[(j + 1, j)] = 1.0;
        }
    }
    let finite = a.iter().all(|value| value.is_finite());
    let roots = if finite {
        Schur::try_new(companion, f64::EPSILON, 100 * n.max(1))
            .map(|schur| schur.complex_eigenvalues())
    } else {
        None
    };
    let Some(roots) = roots else {
        return Some(vec![0.0; n]);
    };
    if roots.iter().all(|root| root.norm() <= START_RADIUS) {
        return None;
    }
    let mut polynomial = vec![C64::new(1.0, 0.0)];
    for root in roots.iter() {
        let radius = root.norm();
        let inside = if radius > 1.0 { 1.0 / radius } else { radius };
        let moved = if radius > 0.0 {
            root * (inside.min(START_RADIUS) / radius)
        } else {
            *root
        };
        polynomial.push(C64::new(0.0, 0.0));
        for index in (1..polynomial.len()).rev() {
            let before = polynomial[index - 1];
            polynomial[index] -= moved * before;
        }
    }
    Some(polynomial[1..].iter().map(|value| value.re).collect())
}
