//! `r = eps / P(z^-1)`: an observer's residual is the equation error of the model's ARX form,
//! filtered by its poles.

use gt_core::{Dataset, OperatingPoint, Signal, StateSpace};
use gt_fdi::design::ResidualGenerator;
use nalgebra::{Complex, DMatrix};
use proptest::prelude::*;

use crate::fixtures::{TS, noise};

/// Coefficients of `prod (1 - root z^-1)`, that of `z^-l` at index `l`.
fn falling(roots: &[Complex<f64>]) -> Vec<f64> {
    let one = vec![Complex::new(1.0, 0.0)];
    let product = roots.iter().fold(one, |p, root| {
        let shifted = p.iter().map(|value| -value * root);
        let mut next = p.clone();
        next.push(Complex::new(0.0, 0.0));
        next[1..]
            .iter_mut()
            .zip(shifted)
            .for_each(|(next, value)| *next += value);
        next
    });
    product.iter().map(|value| value.re).collect()
}

/// Poles within a radius of 0.7: pairs as far as the number goes, a real one when it is odd.
fn poles(nx: usize, draws: &[f64]) -> Vec<Complex<f64>> {
    let squash = |x: f64| 0.5 * x.tanh();
    let mut poles = Vec::new();
    for k in 0..nx / 2 {
        let pole = Complex::new(squash(draws[2 * k]), squash(draws[2 * k + 1]));
        // Now and then two real ones.
        if draws[2 * k] > 1.0 {
            poles.extend([pole.re, pole.im].map(|re| Complex::new(re, 0.0)));
        } else {
            poles.extend([pole, pole.conj()]);
        }
    }
    if nx % 2 == 1 {
        poles.push(Complex::new(squash(draws[nx]), 0.0));
    }
    poles
}

proptest! {
    /// Random models with one to three inputs and a direct term, in the canonical form of their
    /// random ARX equation in random orthogonal coordinates; the record is noise that no model
    /// made, so that nothing cancels.
    #[test]
    fn prop_residual_from_rest_is_the_filtered_equation_error(
        nx in 1_usize..6,
        nu in 1_usize..4,
        seed in any::<u64>(),
    ) {
        let len = 300;
        let draws = noise(seed, 100);
        let (open, placed) = (poles(nx, &draws[..10]), poles(nx, &draws[10..20]));
        let (a, p) = (falling(&open), falling(&placed));
        let b = DMatrix::from_column_slice(nu, nx + 1, &draws[20..20 + nu * (nx + 1)]);

        // Observer form: x_i+ = x_{i+1} - a_i y + b_i u, y = x_1 + b_0 u.
        let companion = DMatrix::from_fn(nx, nx, |i, j| {
            f64::from(u8::from(j == i + 1)) - if j == 0 { a[i + 1] } else { 0.0 }
        });
        let inputs = DMatrix::from_fn(nx, nu, |i, j| b[(j, i + 1)] - a[i + 1] * b[(j, 0)]);
        let c = DMatrix::from_fn(1, nx, |_, j| f64::from(u8::from(j == 0)));
        let d = DMatrix::from_fn(1, nu, |_, j| b[(j, 0)]);
        let q = DMatrix::from_vec(nx, nx, noise(seed ^ 1, nx * nx)).qr().q();
        let names: Vec<String> = (0..nu).map(|j| format!("u{j}")).collect();
        let matrices = [&q * companion * q.transpose(), &q * inputs, c * q.transpose(), d];
        let (from, to) = (Signal::named(&names), Signal::named(&["y"]));
        let model = StateSpace::new(matrices, TS, from.clone(), to.clone()).unwrap();

        let u = DMatrix::from_vec(nu, len, noise(seed ^ 2, nu * len));
        let y = DMatrix::from_vec(1, len, noise(seed ^ 3, len));
        let mut expected: Vec<f64> = Vec::new();
        for t in 0..len {
            let mut value = 0.0;
            for k in 0..=nx.min(t) {
                value += a[k] * y[(0, t - k)] - b.column(k).dot(&u.column(t - k));
                if k > 0 {
                    value -= p[k] * expected[t - k];
                }
            }
            expected.push(value);
        }

        let point = OperatingPoint::zero(nu, 1);
        let generator = ResidualGenerator::observer_complex(model, point, &placed).unwrap();
        let data = Dataset::new(from, to, u, y, TS).unwrap();
        let residual = generator.residuals(&data).unwrap().row(0).transpose();
        let expected = nalgebra::DVector::from_vec(expected);
        let error = (&residual - &expected).norm() / expected.norm();
        // Up to 7.6e-14 among 20 000 cases.
        prop_assert!(error < 1e-12, "{error:e}");
    }
}
