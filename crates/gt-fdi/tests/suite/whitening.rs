//! Whitening: known colours and covariances, and what is refused.

use gt_fdi::FdiError;
use gt_fdi::design::{MAX_WHITENING_ORDER, Whitening};
use nalgebra::DMatrix;
use proptest::prelude::*;

use crate::fixtures::noise;

/// `v(t) = 1.2 v(t-1) - 0.5 v(t-2) + w(t)`, times 3, round 7, after it has forgotten its start.
fn coloured(seed: u64, len: usize) -> DMatrix<f64> {
    let draws = noise(seed, len + 200);
    let mut values = vec![0.0, 0.0];
    for draw in draws {
        let past = &values[values.len() - 2..];
        values.push(1.2 * past[1] - 0.5 * past[0] + draw);
    }
    let kept = values[values.len() - len..].iter().map(|v| 7.0 + 3.0 * v);
    DMatrix::from_row_iterator(1, len, kept)
}

#[test]
fn a_known_colour_is_found() {
    let records = [coloured(1, 20_000), coloured(2, 20_000)];
    let whitening = Whitening::estimate(&records.each_ref(), true).unwrap();
    assert_eq!(whitening.order(), 2);
    let found = &whitening.coefficients()[0];
    // Standard errors of the coefficients: sqrt((1 - 0.5^2) / N) = 0.0043; five of them.
    let tolerance = 5.0 * (0.75_f64 / 40_000.0).sqrt();
    assert!((found[0] + 1.2).abs() < tolerance, "{found:?}");
    assert!((found[1] - 0.5).abs() < tolerance, "{found:?}");
    // A mean whose long-run deviation is 3 / (1 - 1.2 + 0.5) = 10: five standard errors.
    assert!((whitening.mean()[0] - 7.0).abs() < 5.0 * 10.0 / 200.0);
    // Driving noise of deviation 3, through 1 - 1.2 + 0.5 = 0.3: a lasting 10 moves z by one.
    assert!(
        (whitening.unit() - 10.0).abs() < 1.0,
        "{}",
        whitening.unit()
    );
    let plain = Whitening::estimate(&records.each_ref(), false).unwrap();
    assert_eq!(plain.order(), 0);
}

#[test]
fn white_residuals_get_no_colour() {
    let orders = (0..40).map(|seed| {
        let record = DMatrix::from_vec(1, 2000, noise(100 + seed, 2000));
        Whitening::estimate(&[&record], true).unwrap().order()
    });
    // Each extra order passes the criterion with probability P(chi-square > ln 2000) = 0.006.
    assert!(orders.filter(|order| *order > 0).count() <= 3);
}

proptest! {
    /// `W L W' = I` but for the floor of 1e-3 on the correlations.
    #[test]
    fn prop_the_factor_makes_the_covariance_the_identity(
        seed in any::<u64>(),
        size in 1_usize..6,
        scale in -3.0_f64..3.0,
    ) {
        let len = 500;
        let draws = DMatrix::from_vec(size, len, noise(seed, size * len));
        let mixing = DMatrix::from_vec(size, size, noise(seed ^ 1, size * size));
        let record = (mixing + DMatrix::identity(size, size) * 2.0) * draws * 10_f64.powf(scale);
        let whitening = Whitening::estimate(&[&record], false).unwrap();
        let mut centred = record.clone();
        for mut column in centred.column_iter_mut() {
            column -= whitening.mean();
        }
        let covariance = &centred * centred.transpose() / len as f64;
        let deviations = covariance.diagonal().map(f64::sqrt);
        let floored = DMatrix::from_fn(size, size, |i, j| {
            let keep = if i == j { 1.0 } else { 1.0 - 1e-3 };
            keep * covariance[(i, j)]
        });
        let whitened = whitening.factor() * floored * whitening.factor().transpose();
        // Correlations with a floor have a condition below 1e4.
        let error = (whitened - DMatrix::identity(size, size)).amax();
        prop_assert!(error < 1e-10, "{error:e}");
        prop_assert!(deviations.iter().all(|value| *value > 0.0));
        prop_assert!(whitening.factor().upper_triangle().iter().filter(|v| **v != 0.0).count() <= size);
    }
}

#[test]
fn what_says_nothing_of_noise_is_refused() {
    let estimate = |record: DMatrix<f64>| Whitening::estimate(&[&record], true);
    assert_eq!(Whitening::estimate(&[], true), Err(FdiError::NoHealthyData));
    assert_eq!(
        estimate(DMatrix::from_element(2, 11, 1.0)),
        Err(FdiError::HealthySamples {
            record: 0,
            needed: 12,
            found: 11
        })
    );
    assert_eq!(
        estimate(DMatrix::from_element(1, 50, 4.0)),
        Err(FdiError::ConstantResidual {
            index: 0,
            found: 0.0
        })
    );
}

#[test]
fn files_are_checked() {
    let record = coloured(3, 4000);
    let whitening = Whitening::estimate(&[&record], true).unwrap();
    let json = serde_json::to_value(&whitening).unwrap();
    let back: Whitening = serde_json::from_value(json.clone()).unwrap();
    assert_eq!(back, whitening);
    let error = |pointer: &str, value: serde_json::Value| {
        let mut changed = json.clone();
        *changed.pointer_mut(pointer).unwrap() = value;
        serde_json::from_value::<Whitening>(changed)
            .unwrap_err()
            .to_string()
    };
    let scale = error("/scale/0", serde_json::json!([0.0]));
    assert_eq!(
        scale,
        "option `whitening scale`: expected a number above 0, found 0"
    );
    let long = error(
        "/coefficients/0",
        serde_json::json!(vec![0.0; MAX_WHITENING_ORDER + 1]),
    );
    assert_eq!(
        long,
        "option `whitening coefficients`: expected as many for each component, at most 30, found 31"
    );
    let sizes = error("/coefficients", serde_json::json!([]));
    assert_eq!(
        sizes,
        "whitening, components with coefficients: expected 1, found 0"
    );
}
