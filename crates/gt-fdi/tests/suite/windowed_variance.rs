//! The variance in a sliding window against its definition.

use gt_fdi::runtime::{MAX_WINDOW, Sides, Statistic, StatisticError, WindowedVariance};
use proptest::prelude::*;

use crate::fixtures::noise;
use crate::statistics::{SIDES, assert_near, check_against_batch, events, folded, last};

/// `sum (r - mean)^2`, in two passes.
pub fn squared_deviations(samples: &[f64]) -> f64 {
    let mean = samples.iter().sum::<f64>() / samples.len() as f64;
    samples.iter().map(|r| (r - mean) * (r - mean)).sum()
}

/// The normal score of Wilson and Hilferty.
pub fn score(chi_square: f64, degrees: f64) -> f64 {
    let v = 2.0 / (9.0 * degrees);
    ((chi_square / degrees).cbrt() - 1.0 + v) / v.sqrt()
}

proptest! {
    #[test]
    fn prop_windowed_variance_is_its_batch_definition(
        events in events(300), window in 2..40_usize, side in 0..3_usize,
    ) {
        let mut statistic = WindowedVariance::new(window, 3.0, SIDES[side]).unwrap();
        check_against_batch(&mut statistic, &events, |variance, decision, samples| {
            let samples = last(samples, window);
            if samples.len() < window {
                assert_eq!((variance.variance(), decision.value), (None, 0.0));
                return;
            }
            let degrees = (window - 1) as f64;
            let squares = squared_deviations(samples);
            let moduli: f64 = samples.iter().map(|r| r * r).sum();
            assert_near(variance.variance().unwrap() * degrees, squares, moduli);
            // From the variance as found: the root is steep at 0.
            let expected = score(variance.variance().unwrap() * degrees, degrees);
            assert_near(decision.value, folded(SIDES[side], expected), expected.abs());
        });
    }
}

/// Short windows, and a score at a cube.
#[test]
fn variances_by_hand() {
    let mut variance = WindowedVariance::new(4, 1.0, Sides::Upper).unwrap();
    for r in [1.0, 2.0, 3.0] {
        assert_eq!(variance.step(r).value, 0.0);
    }
    variance.step(4.0);
    assert!((variance.variance().unwrap() - 5.0 / 3.0).abs() < 1e-15);
    // 3, 4, 0 and 5: the mean 3, the squares 0 + 1 + 9 + 4.
    variance.step(0.0);
    variance.step(5.0);
    assert!((variance.variance().unwrap() - 14.0 / 3.0).abs() < 1e-15);
    // A variance of 8 with 3 degrees: v = 2 / 27, (2 - 1 + v) / sqrt(v) = (29 / 27) sqrt(27 / 2).
    let mut variance = WindowedVariance::new(4, 1.0, Sides::Upper).unwrap();
    let side = 6.0_f64.sqrt();
    let value = [-side, side, -side, side].map(|r| variance.step(100.0 + r).value)[3];
    let expected = 29.0 / 27.0 * 13.5_f64.sqrt();
    assert!((value - expected).abs() < 1e-12, "{value} {expected}");
}

/// A sensor that stands still, whatever its offset, has no variance: as unlikely as that is.
#[test]
fn a_residual_that_stands_still_is_below() {
    for offset in [0.0, 3.7, -1e6] {
        let mut lower = WindowedVariance::new(100, 10.0, Sides::Lower).unwrap();
        let mut upper = WindowedVariance::new(100, 10.0, Sides::Upper).unwrap();
        for r in noise(5, 150) {
            assert!(!lower.step(r).alarm && !upper.step(r).alarm);
        }
        for _ in 0..100 {
            lower.step(offset);
            upper.step(offset);
        }
        assert_eq!(lower.variance(), Some(0.0));
        // (1 - v) / sqrt(v) with v = 2 / 891.
        assert!((lower.value() - 21.06).abs() < 0.01, "{}", lower.value());
        assert!(lower.value() > lower.threshold());
        assert_eq!(upper.value(), -lower.value());
    }
}

/// The spread keeps its digits beside a mean ten million times as large, and after a sample of 1e12
/// has left the window.
#[test]
fn neither_offsets_nor_spikes_cost_digits() {
    let samples = noise(6, 20_000);
    let mut plain = WindowedVariance::new(64, 3.0, Sides::Both).unwrap();
    let mut shifted = plain.clone();
    let mut spiked = plain.clone();
    for (k, &r) in samples.iter().enumerate() {
        plain.step(r);
        shifted.step(r + 1e7);
        spiked.step(if k % 1000 == 0 { 1e12 } else { r });
        if k >= 64 {
            let expected = plain.variance().unwrap();
            // Rounding of r + 1e7 is 1e-9.
            assert!((shifted.variance().unwrap() / expected - 1.0).abs() < 1e-8);
            if k % 1000 >= 64 {
                assert!((spiked.variance().unwrap() / expected - 1.0).abs() < 1e-13);
            }
        }
    }
}

#[test]
fn bad_windows_are_refused() {
    for found in [0, 1, MAX_WINDOW + 1] {
        let (shortest, longest) = (2, MAX_WINDOW);
        let expected = StatisticError::WindowRange {
            shortest,
            longest,
            found,
        };
        let made = WindowedVariance::new(found, 3.0, Sides::Both);
        assert_eq!(made.err(), Some(expected));
    }
    let made = WindowedVariance::new(5, 0.0, Sides::Both);
    let found = 0.0;
    assert_eq!(made.err(), Some(StatisticError::Threshold { found }));
}
