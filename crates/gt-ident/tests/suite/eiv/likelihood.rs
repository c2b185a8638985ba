//! The likelihood and the information, on systems whose spectrum is known exactly.

use gt_ident::eiv::{EivLags, EivRow, Likelihood, Spectrum};
use nalgebra::{DMatrix, DVector};
use proptest::prelude::*;
use rand::RngExt;
use rand_chacha::ChaCha8Rng;

use super::system::{Arma, System, m1, s1};
use crate::common::{cases, generator};

/// Frequencies of the random systems: identities hold frequency by frequency.
const FREQUENCIES: usize = 16;

/// `1 + a_1 q^-1 + ..` with roots of radius below 0.85.
fn stable(rng: &mut ChaCha8Rng, order: usize) -> Vec<f64> {
    let mut polynomial = vec![1.0];
    let mut times = |factor: &[f64]| {
        let mut product = vec![0.0; polynomial.len() + factor.len() - 1];
        for (i, a) in polynomial.iter().enumerate() {
            for (j, b) in factor.iter().enumerate() {
                product[i + j] += a * b;
            }
        }
        polynomial = product;
    };
    let mut left = order;
    while left >= 2 {
        let (radius, angle): (f64, f64) = (rng.random_range(0.2..0.85), rng.random_range(0.2..2.9));
        times(&[1.0, -2.0 * radius * angle.cos(), radius * radius]);
        left -= 2;
    }
    if left == 1 {
        times(&[1.0, rng.random_range(-0.85..0.85)]);
    }
    polynomial
}

/// One to three outputs, one or two inputs, orders to 3, 3 to 20 dB.
fn random(rng: &mut ChaCha8Rng) -> System {
    let (m, r) = (rng.random_range(1..=3), rng.random_range(1..=2));
    let rows = (0..m).map(|_| {
        let order = rng.random_range(1..=3);
        let nk: Vec<usize> = (0..r).map(|_| rng.random_range(0..=1)).collect();
        let lags = EivLags::new(order, nk).unwrap();
        let mut theta = stable(rng, order)[1..].to_vec();
        while theta.len() < lags.parameters() {
            let size: f64 = rng.random_range(0.2..1.0);
            theta.push(if rng.random() { size } else { -size });
        }
        EivRow::new(lags, DVector::from_vec(theta)).unwrap()
    });
    let rows: Vec<EivRow> = rows.collect();
    let inputs = (0..r).map(|_| Arma {
        num: stable(rng, 1),
        den: stable(rng, 2),
    });
    let inputs: Vec<Arma> = inputs.collect();
    let snr_db = rng.random_range(3.0..20.0);
    System::on_grid(rows, inputs, snr_db, 64)
}

proptest! {
    #![proptest_config(cases(48))]

    /// Five-point differences with steps of 2e-4 of the parameter: their error is of fourth order,
    /// 1e-15 of a fifth derivative, and rounding adds about 1e-12 over the step.
    #[test]
    fn prop_gradient_is_that_of_differences(seed in any::<u64>()) {
        let mut rng = generator(seed);
        let system = random(&mut rng);
        let spectrum = system.spectrum(FREQUENCIES).unwrap();
        let mut likelihood = Likelihood::new(&system.lags(), &spectrum).unwrap();
        let point: Vec<f64> = system
            .point()
            .iter()
            .map(|value| value * rng.random_range(0.9..1.1))
            .collect();
        let (_, gradient) = likelihood.gradient(&point).unwrap();
        // Slopes along relative changes, so that one scale fits all.
        let relative = |index: usize| point[index].abs().max(1e-2);
        let largest = (0..point.len())
            .map(|index| (gradient[index] * relative(index)).abs())
            .fold(1.0, f64::max);
        for index in 0..point.len() {
            let step = 2e-4 * relative(index);
            let mut at = |factor: f64| {
                let mut moved = point.clone();
                moved[index] += factor * step;
                likelihood.gradient(&moved).unwrap().0
            };
            let slope = (8.0 * (at(1.0) - at(-1.0)) - (at(2.0) - at(-2.0))) / 24e-4;
            let error = (slope - gradient[index] * relative(index)).abs();
            prop_assert!(error < 1e-6 * largest, "{index}: {error:e} of {largest:e}");
        }
    }

    /// With the exact spectrum the gradient vanishes at the truth, and the Hessian there is twice
    /// the information a sample: the bound and the likelihood were derived apart.
    #[test]
    fn prop_truth_is_stationary_and_its_hessian_is_the_information(seed in any::<u64>()) {
        let mut rng = generator(seed);
        let system = random(&mut rng);
        let spectrum = system.spectrum(FREQUENCIES).unwrap();
        let mut likelihood = Likelihood::new(&system.lags(), &spectrum).unwrap();
        let point = system.point();
        let scale: Vec<f64> = point.iter().map(|value| value.abs().max(1e-2)).collect();
        let information = likelihood.information(&point).unwrap();
        let expected = DMatrix::from_fn(point.len(), point.len(), |i, j| {
            2.0 * information[(i, j)] * scale[i] * scale[j]
        });
        let largest = expected.amax().max(1.0);
        let (value, gradient) = likelihood.gradient(&point).unwrap();
        for (index, slope) in gradient.iter().enumerate() {
            // Cancellation between terms of the size of the Hessian.
            prop_assert!((slope * scale[index]).abs() < 1e-9 * largest, "{index}: {slope:e}");
        }
        for index in 0..point.len() {
            let mut at = |factor: f64| {
                let mut moved = point.clone();
                moved[index] += factor * 2e-4 * scale[index];
                likelihood.gradient(&moved).unwrap()
            };
            let (one, two) = ((at(1.0), at(-1.0)), (at(2.0), at(-2.0)));
            let column = (8.0 * (&one.0.1 - &one.1.1) - (&two.0.1 - &two.1.1)) / 24e-4;
            for (other, found) in column.iter().enumerate() {
                let error = (found * scale[other] - expected[(other, index)]).abs();
                prop_assert!(error < 1e-5 * largest, "{other}, {index}: {error:e} of {largest:e}");
            }
            // A minimum, up to rounding of f itself.
            for side in [&one.0, &one.1, &two.0, &two.1] {
                prop_assert!(side.0 > value - 1e-11 * (1.0 + value.abs()));
            }
        }
    }

    /// `f` takes no notice of the units of the channels.
    #[test]
    fn prop_likelihood_has_no_units(seed in any::<u64>()) {
        let mut rng = generator(seed);
        let system = random(&mut rng);
        let (m, q) = (system.rows.len(), system.channels());
        let units: Vec<f64> = (0..q).map(|_| 10_f64.powf(rng.random_range(-3.0..3.0))).collect();
        let mut other = system.clone();
        for (output, row) in other.rows.iter_mut().enumerate() {
            let mut theta = row.a().to_vec();
            for input in 0..row.lags().inputs() {
                let factor = units[output] / units[m + input];
                theta.extend(row.b(input).iter().map(|b| b * factor));
            }
            *row = EivRow::new(row.lags().clone(), DVector::from_vec(theta)).unwrap();
        }
        for (noise, unit) in other.noise.iter_mut().zip(&units) {
            *noise *= unit * unit;
        }
        let scaled = Spectrum::from_fn(q, FREQUENCIES, |w| {
            let matrix = system.measured(w);
            DMatrix::from_fn(q, q, |i, j| matrix[(i, j)] * (units[i] * units[j]))
        });
        let (plain, scaled) = (system.spectrum(FREQUENCIES).unwrap(), scaled.unwrap());
        let value = |system: &System, spectrum: &Spectrum| {
            let mut likelihood = Likelihood::new(&system.lags(), spectrum).unwrap();
            likelihood.gradient(&system.point()).unwrap().0
        };
        let (before, after) = (value(&system, &plain), value(&other, &scaled));
        // The condition of the spectra, at most 1e4, times rounding.
        prop_assert!((before - after).abs() < 1e-9 * (1.0 + before.abs()), "{before} {after}");
    }
}

/// A variance that is not positive has no likelihood, and no information.
#[test]
fn variances_of_zero_have_no_likelihood() {
    let system = s1(20.0);
    let spectrum = system.spectrum(FREQUENCIES).unwrap();
    let mut likelihood = Likelihood::new(&system.lags(), &spectrum).unwrap();
    let mut point = system.point();
    point[4] = 0.0;
    point[5] = 0.0;
    assert_eq!(likelihood.gradient(&point).unwrap().0, f64::INFINITY);
    assert!(likelihood.information(&point).is_err());
}

/// What several outputs know together about the shared inputs' noise is more than any knows alone,
/// and an output that is not there changes nothing.
#[test]
fn outputs_together_bound_the_input_noise_more_tightly() {
    let system = super::system::four_outputs(15.0);
    let together = system.bound(1000);
    let first = system.rows[0].lags().parameters();
    let alone = System {
        rows: vec![system.rows[0].clone()],
        inputs: system.inputs.clone(),
        noise: [&system.noise[..1], &system.noise[4..]].concat(),
    };
    let alone = alone.bound(1000);
    for (parameter, (joint, single)) in together.iter().zip(&alone[..first]).enumerate() {
        assert!(joint < single, "coefficient {parameter}: {joint} {single}");
    }
    for input in 0..2 {
        let (joint, single) = (
            together[together.len() - 2 + input],
            alone[alone.len() - 2 + input],
        );
        assert!(joint < 0.7 * single, "input {input}: {joint} {single}");
    }
    // M1 is the first row alone.
    assert_eq!(m1(15.0).bound(1000).len(), alone.len());
    for (left, right) in m1(15.0).bound(1000).iter().zip(&alone) {
        assert!((left - right).abs() < 1e-12 * left);
    }
}
