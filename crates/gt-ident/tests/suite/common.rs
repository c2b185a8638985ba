//! Random systems and records for the tests.

use std::cmp::Ordering;

use gt_core::{Dataset, Signal, StateSpace};
use gt_ident::CanonicalForm;
use nalgebra::{DMatrix, DVector};
use proptest::test_runner::Config;
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use rand_distr::StandardNormal;

/// Options of a property: failures print their input and leave no file behind.
pub fn cases(count: u32) -> Config {
    Config {
        cases: count,
        failure_persistence: None,
        ..Config::default()
    }
}

pub fn generator(seed: u64) -> ChaCha8Rng {
    ChaCha8Rng::seed_from_u64(seed)
}

pub fn signals(prefix: &str, count: usize) -> Vec<Signal> {
    (1..=count)
        .map(|index| Signal::new(format!("{prefix}{index}"), ""))
        .collect()
}

pub fn normal_matrix(rng: &mut ChaCha8Rng, rows: usize, columns: usize) -> DMatrix<f64> {
    DMatrix::from_fn(rows, columns, |_, _| rng.sample(StandardNormal))
}

/// `v_ij` of eq. 9, written again here.
pub fn v_ij(v: &[usize], i: usize, j: usize) -> usize {
    match i.cmp(&j) {
        Ordering::Equal => v[i],
        Ordering::Greater => (v[i] + 1).min(v[j]),
        Ordering::Less => v[i].min(v[j]),
    }
}

/// A random stable canonical system: coefficients in (-1, 1), the denominators shrunk (`alpha` of
/// lag l by `factor^l`) until the spectral radius is below 0.9.
pub fn random_form(rng: &mut ChaCha8Rng, v: &[usize], nu: usize, direct: bool) -> CanonicalForm {
    let m = v.len();
    let mut draw =
        |count: usize| -> Vec<f64> { (0..count).map(|_| rng.random_range(-1.0..1.0)).collect() };
    let beta: Vec<Vec<Vec<f64>>> = v
        .iter()
        .map(|&index| (0..index + usize::from(direct)).map(|_| draw(nu)).collect())
        .collect();
    let mut alpha: Vec<Vec<Vec<f64>>> = (0..m)
        .map(|i| (0..m).map(|j| draw(v_ij(v, i, j))).collect())
        .collect();
    for _ in 0..200 {
        let form = CanonicalForm::new(v.to_vec(), alpha.clone(), beta.clone()).unwrap();
        // The eigenvalues of one matrix in ten thousand are not found; those of the next are.
        let radius = state_space(&form).spectral_radius();
        if radius.is_ok_and(|radius| radius < 0.9) {
            return form;
        }
        for (i, row) in alpha.iter_mut().enumerate() {
            for list in row.iter_mut() {
                for (k, value) in list.iter_mut().enumerate() {
                    *value *= 0.9_f64.powi(i32::try_from(v[i] - k).unwrap());
                }
            }
        }
    }
    panic!("no stable system found");
}

pub fn state_space(form: &CanonicalForm) -> StateSpace {
    form.to_state_space(1.0, signals("u", form.nu()), signals("y", form.ny()))
        .unwrap()
}

/// Eq. 7 run directly: outputs (ny x N) from the inputs (nu x N), the equation errors (ny x N) and
/// zero before the record. It is the definition that everything else is compared with.
pub fn difference_equation(
    form: &CanonicalForm,
    u: &DMatrix<f64>,
    e: &DMatrix<f64>,
) -> DMatrix<f64> {
    let (v, ny) = (form.indices(), form.ny());
    let mut y = DMatrix::zeros(ny, u.ncols());
    for t in 0..u.ncols() {
        for i in 0..ny {
            let mut value = e[(i, t)];
            for j in 0..ny {
                for (k, alpha) in form.alpha()[i][j].iter().enumerate() {
                    if t + k >= v[i] {
                        value += alpha * y[(j, t + k - v[i])];
                    }
                }
            }
            for (k, row) in form.beta()[i].iter().enumerate() {
                for (j, beta) in row.iter().enumerate() {
                    if t + k >= v[i] {
                        value += beta * u[(j, t + k - v[i])];
                    }
                }
            }
            y[(i, t)] = value;
        }
    }
    y
}

/// A record of a system driven by white inputs, with equation errors of the given deviation.
pub fn record(
    rng: &mut ChaCha8Rng,
    form: &CanonicalForm,
    samples: usize,
    deviation: f64,
) -> Dataset {
    let u = normal_matrix(rng, form.nu(), samples);
    let e = normal_matrix(rng, form.ny(), samples) * deviation;
    let y = difference_equation(form, &u, &e);
    Dataset::new(signals("u", form.nu()), signals("y", form.ny()), u, y, 1.0).unwrap()
}

pub fn largest_form_difference(left: &CanonicalForm, right: &CanonicalForm) -> f64 {
    assert_eq!(left.indices(), right.indices());
    let flat = |form: &CanonicalForm| -> Vec<f64> {
        let alpha = form.alpha().iter().flatten().flatten();
        alpha
            .chain(form.beta().iter().flatten().flatten())
            .copied()
            .collect()
    };
    let (left, right) = (flat(left), flat(right));
    assert_eq!(left.len(), right.len());
    left.iter()
        .zip(&right)
        .map(|(a, b)| (a - b).abs())
        .fold(0.0, f64::max)
}

pub fn largest_difference(left: &DMatrix<f64>, right: &DMatrix<f64>) -> f64 {
    assert_eq!(left.shape(), right.shape());
    (left - right).amax()
}

pub fn zero_state(model: &StateSpace) -> DVector<f64> {
    DVector::zeros(model.nx())
}
