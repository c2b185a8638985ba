//! The minimiser on functions whose minima are known.

use gt_ident::eiv::Lbfgs;
use nalgebra::{DMatrix, DVector};
use proptest::prelude::*;
use rand::RngExt;

use crate::common::{cases, generator, normal_matrix};

const FREE: (f64, f64) = (f64::NEG_INFINITY, f64::INFINITY);

/// Rosenbrock's valley in any even dimension, minimum 0 at (1, .., 1).
fn rosenbrock(x: &[f64], gradient: &mut [f64]) -> f64 {
    gradient.fill(0.0);
    let mut sum = 0.0;
    for i in (0..x.len()).step_by(2) {
        let (valley, wall) = (x[i + 1] - x[i] * x[i], 1.0 - x[i]);
        sum += 100.0 * valley * valley + wall * wall;
        gradient[i] = -400.0 * x[i] * valley - 2.0 * wall;
        gradient[i + 1] = 200.0 * valley;
    }
    sum
}

#[test]
fn published_rosenbrock_valley_is_followed_to_its_end() {
    for dimension in [2, 20] {
        let start: Vec<f64> = (0..dimension)
            .map(|i| if i % 2 == 0 { -1.2 } else { 1.0 })
            .collect();
        let (lower, upper) = (vec![FREE.0; dimension], vec![FREE.1; dimension]);
        let end = Lbfgs::default().minimise(&start, &lower, &upper, None, rosenbrock);
        assert!(end.converged);
        // The tolerance on the decrease is 1e-13; the curvature across the valley's end is 0.4.
        assert!(end.value < 1e-12, "{}", end.value);
        assert!(end.x.iter().all(|x| (x - 1.0).abs() < 1e-5), "{:?}", end.x);
        assert!(end.evaluations < 120, "{}", end.evaluations);
    }
}

/// With x <= 0.5 the minimum lies at (0.5, 0.25) and is 0.25.
#[test]
fn bound_holds_the_minimum() {
    let start = [-1.2, 1.0];
    let end = Lbfgs::default().minimise(&start, &[FREE.0; 2], &[0.5, 9.0], None, rosenbrock);
    assert!(end.converged);
    assert_eq!(end.x[0], 0.5);
    assert!((end.x[1] - 0.25).abs() < 1e-6);
    assert!((end.value - 0.25).abs() < 1e-12);
}

/// `x - ln x` is not defined for x <= 0, where the first step of this start would end.
#[test]
fn steps_out_of_the_domain_are_taken_back() {
    let function = |x: &[f64], gradient: &mut [f64]| {
        gradient[0] = 1.0 - 1.0 / x[0];
        if x[0] > 0.0 {
            x[0] - x[0].ln()
        } else {
            f64::NAN
        }
    };
    for start in [0.01, 0.9, 30.0] {
        let end = Lbfgs::default().minimise(&[start], &[FREE.0], &[FREE.1], None, function);
        assert!(end.converged, "{start}");
        assert!((end.x[0] - 1.0).abs() < 1e-6, "{start}: {}", end.x[0]);
    }
}

/// The longest step is kept, and a start outside the bounds is moved inside.
#[test]
fn steps_and_starts_keep_their_limits() {
    let far = |x: &[f64], gradient: &mut [f64]| {
        gradient[0] = 2.0 * (x[0] - 100.0);
        (x[0] - 100.0).powi(2)
    };
    let short = Lbfgs {
        longest_step: 0.5,
        iterations: 3,
        ..Lbfgs::default()
    };
    let end = short.minimise(&[-7.0], &[0.0], &[FREE.1], None, far);
    assert_eq!((end.x[0], end.iterations, end.converged), (1.5, 3, false));
}

proptest! {
    #![proptest_config(cases(64))]

    /// A convex quadratic in a box: inside the gradient vanishes, at a bound it points outwards.
    #[test]
    fn prop_quadratic_in_a_box_ends_at_its_optimum(seed in any::<u64>()) {
        let mut rng = generator(seed);
        let n = rng.random_range(1..8);
        let root = normal_matrix(&mut rng, n, n);
        let hessian = root.tr_mul(&root) + DMatrix::identity(n, n) * 0.1;
        let linear = DVector::from_column_slice(normal_matrix(&mut rng, n, 1).as_slice()) * 3.0;
        let lower: Vec<f64> = (0..n).map(|_| rng.random_range(-2.0..0.0)).collect();
        let upper: Vec<f64> = (0..n).map(|_| rng.random_range(0.0..2.0)).collect();
        let slope = |x: &[f64]| &hessian * DVector::from_column_slice(x) + &linear;
        let function = |x: &[f64], gradient: &mut [f64]| {
            gradient.copy_from_slice(slope(x).as_slice());
            let x = DVector::from_column_slice(x);
            0.5 * x.dot(&(&hessian * &x)) + linear.dot(&x)
        };
        for metric in [None, Some(&hessian)] {
            let end = Lbfgs::default().minimise(&vec![0.0; n], &lower, &upper, metric, function);
            prop_assert!(end.converged);
            let gradient = slope(&end.x);
            for i in 0..n {
                let outwards = if end.x[i] == lower[i] {
                    (-gradient[i]).max(0.0)
                } else if end.x[i] == upper[i] {
                    gradient[i].max(0.0)
                } else {
                    gradient[i].abs()
                };
                // A decrease of 1e-13 (1 + |f|) left, curvatures of 0.1 to 30, |f| to 100.
                prop_assert!(outwards < 1e-4, "{i}: {outwards:e}");
            }
        }
    }
}
