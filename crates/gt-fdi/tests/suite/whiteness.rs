//! The sliding portmanteau statistic against its definition.

use gt_fdi::runtime::{MAX_LAGS, MAX_WINDOW, Statistic, StatisticError, Whiteness};
use proptest::prelude::*;
use statrs::distribution::{ChiSquared, ContinuousCDF};

use crate::fixtures::noise;
use crate::statistics::{check_against_batch, events, last};

/// Ljung and Box, from the samples as they are.
fn batch(samples: &[f64], lags: usize) -> f64 {
    let n = samples.len() as f64;
    let energy: f64 = samples.iter().map(|r| r * r).sum();
    if energy == 0.0 {
        return 0.0;
    }
    let terms = (1..=lags).map(|lag| {
        let products = samples.iter().zip(&samples[lag..]).map(|(a, b)| a * b);
        (products.sum::<f64>() / energy).powi(2) / (n - lag as f64)
    });
    n * (n + 2.0) * terms.sum::<f64>()
}

proptest! {
    #[test]
    fn prop_whiteness_is_its_batch_definition(
        events in events(200), window in 2..40_usize, lags in 1..20_usize,
    ) {
        let lags = lags.min(window - 1);
        let mut statistic = Whiteness::new(window, lags, 20.0).unwrap();
        assert_eq!((statistic.window(), statistic.lags()), (window, lags));
        check_against_batch(&mut statistic, &events, |whiteness, decision, samples| {
            let samples = last(samples, window);
            if samples.len() < window {
                assert_eq!(decision.value, 0.0);
                return;
            }
            let expected = batch(samples, lags);
            // Residuals are rounded to 1.2e-10, beside a spread that is seldom below 0.01; the
            // statistic is up to the square of the window.
            let tolerance = 1e-7 * (1.0 + (window * window) as f64);
            let found = decision.value;
            assert!((found - expected).abs() < tolerance, "{expected}, found {found}");
            assert_eq!(whiteness.correlations().count(), lags);
        });
    }
}

/// 2, 1, -1: the correlations (2 - 1) / 6 and -2 / 6; Q = 3 x 5 (1 / 36 / 2 + 4 / 36 / 1) = 15 / 8.
#[test]
fn correlations_by_hand() {
    let mut whiteness = Whiteness::new(3, 2, 1.0).unwrap();
    let values = [2.0, 1.0, -1.0].map(|r| whiteness.step(r).value);
    assert_eq!(values[..2], [0.0, 0.0]);
    assert!((values[2] - 1.875).abs() < 1e-14, "{}", values[2]);
    let found: Vec<f64> = whiteness.correlations().collect();
    assert_eq!(found, [1.0 / 6.0, -1.0 / 3.0]);
    // 1, -1, 0.
    whiteness.step(0.0);
    assert_eq!(whiteness.correlations().collect::<Vec<_>>(), [-0.5, 0.0]);
    // Nothing but zeros says nothing.
    whiteness.step(0.0);
    assert_eq!(whiteness.step(0.0).value, 0.0);
}

/// Sums are whole numbers: after a million samples, and after the largest ones, the same bits as a
/// statistic that saw only the last window.
#[test]
fn sums_do_not_drift() {
    let (window, lags) = (200, 10);
    let mut through = Whiteness::new(window, lags, 30.0).unwrap();
    let samples = noise(31, 1_000_000);
    for (k, &r) in samples.iter().enumerate() {
        through.step(if k % 1000 == 0 { 1e30 } else { r });
    }
    let mut fresh = Whiteness::new(window, lags, 30.0).unwrap();
    for &r in last(&samples, window) {
        fresh.step(r);
    }
    assert_eq!(through.value().to_bits(), fresh.value().to_bits());
    assert_eq!(through, fresh);
    let expected = batch(last(&samples, window), lags);
    assert!((fresh.value() - expected).abs() < 1e-8, "{expected}");
}

/// In windows that do not overlap, the statistic has the distribution of its reference: the share of
/// 2000 above its 50 %, 10 % and 5 % points, within four standard errors and a hundredth, and the
/// same for residuals of another variance.
#[test]
fn the_reference_distribution_is_chi_square() {
    const WINDOWS: usize = 2000;
    let (window, lags) = (300, 8);
    let law = ChiSquared::new(lags as f64).unwrap();
    let samples = noise(41, WINDOWS * window);
    for scale in [1.0, 0.1] {
        let mut whiteness = Whiteness::new(window, lags, 1.0).unwrap();
        let values: Vec<f64> = samples
            .chunks(window)
            .map(|chunk| {
                for r in chunk {
                    whiteness.step(scale * r);
                }
                whiteness.value()
            })
            .collect();
        for share in [0.5, 0.1, 0.05] {
            let point = law.inverse_cdf(1.0 - share);
            let found = values.iter().filter(|&&v| v > point).count() as f64 / WINDOWS as f64;
            let error = (share * (1.0 - share) / WINDOWS as f64).sqrt();
            assert!(
                (found - share).abs() < 4.0 * error + 0.01,
                "{share}: {found}"
            );
        }
    }
}

/// A residual with the correlation 0.3 from one sample to the next: the mean of the statistic is
/// above its reference's 8 by about `n sum_k 0.09^k` = 29.7 for 300 samples.
#[test]
fn coloured_residuals_stand_out() {
    let mut whiteness = Whiteness::new(300, 8, 8.0).unwrap();
    let (mut r, mut sum, mut count) = (0.0, 0.0, 0.0);
    for (k, e) in noise(51, 60_000).into_iter().enumerate() {
        r = 0.3 * r + e * 0.91_f64.sqrt();
        let value = whiteness.step(r).value;
        if k >= 300 {
            sum += value;
            count += 1.0;
        }
    }
    let mean = sum / count;
    assert!((32.0..44.0).contains(&mean), "{mean}");
}

#[test]
fn bad_windows_and_lags_are_refused() {
    for found in [0, 1, MAX_WINDOW + 1] {
        let (shortest, longest) = (2, MAX_WINDOW);
        let expected = StatisticError::WindowRange {
            shortest,
            longest,
            found,
        };
        assert_eq!(Whiteness::new(found, 1, 9.0).err(), Some(expected));
    }
    for (window, found, most) in [
        (10, 0, 9),
        (10, 10, 9),
        (MAX_WINDOW, MAX_LAGS + 1, MAX_LAGS),
    ] {
        let made = Whiteness::new(window, found, 9.0);
        assert_eq!(made.err(), Some(StatisticError::Lags { most, found }));
    }
    let found = f64::INFINITY;
    let made = Whiteness::new(10, 3, found);
    assert_eq!(made.err(), Some(StatisticError::Threshold { found }));
}
