//! The Shiryaev-Roberts procedure against its sum over all onsets.

use gt_fdi::runtime::{ShiryaevRoberts, Sides, Statistic, StatisticError};
use proptest::prelude::*;

use crate::fixtures::noise;
use crate::statistics::{SIDES, check_against_batch, events};

/// `ln(1 + sum_j exp(sum_{i >= j} (d r_i - d^2 / 2)))`, the largest exponent taken out.
fn batch(samples: &[f64], shift: f64, sign: f64) -> f64 {
    let mut exponents = vec![0.0];
    let mut exponent = 0.0;
    for r in samples.iter().rev() {
        exponent += shift * (sign * r - 0.5 * shift);
        exponents.push(exponent);
    }
    log_sum(&exponents)
}

fn log_sum(exponents: &[f64]) -> f64 {
    let largest = exponents.iter().fold(f64::NEG_INFINITY, |a, b| a.max(*b));
    let sum: f64 = exponents.iter().map(|e| (e - largest).exp()).sum();
    largest + sum.ln()
}

proptest! {
    #[test]
    fn prop_shiryaev_roberts_is_its_batch_definition(
        events in events(200), shift in 0.01..3.0_f64, side in 0..3_usize,
    ) {
        let sides = SIDES[side];
        let mut statistic = ShiryaevRoberts::new(shift, 6.0, sides).unwrap();
        check_against_batch(&mut statistic, &events, |procedure, decision, samples| {
            let (upper, lower) = (batch(samples, shift, 1.0), batch(samples, shift, -1.0));
            let expected = match sides {
                Sides::Upper => upper,
                Sides::Lower => lower,
                Sides::Both => log_sum(&[upper, lower]) - 2.0_f64.ln(),
            };
            // Rounding of exponents that add up to this.
            let moduli: f64 = samples.iter().map(|r| shift * (r.abs() + shift)).sum();
            let tolerance = 1e-12 * (1.0 + moduli);
            prop_close(decision.value, expected, tolerance);
            let idle = |value: f64, side| if sides == side { 0.0 } else { value };
            prop_close(procedure.upper(), idle(upper, Sides::Lower), tolerance);
            prop_close(procedure.lower(), idle(lower, Sides::Upper), tolerance);
        });
    }
}

fn prop_close(found: f64, expected: f64, tolerance: f64) {
    assert!(
        (found - expected).abs() <= tolerance,
        "expected {expected}, found {found}, tolerance {tolerance}"
    );
}

/// With the shift 1: residuals of 0.5 have a ratio of 1, so that `R` counts samples; those of
/// `0.5 + ln 2` double `1 + R`.
#[test]
fn ratios_by_hand() {
    let mut procedure = ShiryaevRoberts::new(1.0, 3.5_f64.ln(), Sides::Upper).unwrap();
    for expected in [1.0, 2.0, 3.0] {
        let decision = procedure.step(0.5);
        prop_close(decision.value.exp(), 1.0 + expected, 1e-14);
        assert_eq!(decision.alarm, expected > 2.5);
    }
    // (1 + 3) x 2 = 8.
    let value = procedure.step(0.5 + 2.0_f64.ln()).value;
    prop_close(value.exp(), 9.0, 1e-14);
    // Both sides: the mean of R+ = 1 and R- = e^-1.
    let mut both = ShiryaevRoberts::new(1.0, 1.0, Sides::Both).unwrap();
    let value = both.step(0.5).value;
    prop_close(value.exp_m1(), 0.5 * (1.0 + (-1.0_f64).exp()), 1e-15);
    prop_close(
        ShiryaevRoberts::safe_threshold(1e6).unwrap().exp(),
        1e6 + 1.0,
        1e-8,
    );
}

/// `R - n` has the mean 0 on healthy residuals: after 30 samples, with the small shift 0.1 for which
/// `R` has a small variance.
#[test]
fn the_ratio_grows_by_one_a_sample_in_the_mean() {
    const PATHS: usize = 20_000;
    let samples = noise(71, 30 * PATHS);
    for sides in SIDES {
        let mut procedure = ShiryaevRoberts::new(0.1, 9.0, sides).unwrap();
        let ratios: Vec<f64> = samples
            .chunks(30)
            .map(|path| {
                procedure.reset();
                for &r in path {
                    procedure.step(r);
                }
                procedure.value().exp_m1()
            })
            .collect();
        let mean = ratios.iter().sum::<f64>() / PATHS as f64;
        let variance = ratios.iter().map(|r| (r - mean).powi(2)).sum::<f64>() / PATHS as f64;
        let error = (variance / PATHS as f64).sqrt();
        assert!(error < 0.1, "{error}");
        assert!((mean - 30.0).abs() < 2.58 * error, "{mean} +- {error}");
    }
}

#[test]
fn bad_procedures_are_refused() {
    for found in [0.0, -1.0, f64::INFINITY] {
        let error = |option| {
            Some(StatisticError::Option {
                option,
                expected: "a positive finite number",
                found,
            })
        };
        let made = ShiryaevRoberts::new(found, 5.0, Sides::Both);
        assert_eq!(made.err(), error("shift"));
        let threshold = ShiryaevRoberts::safe_threshold(found);
        assert_eq!(threshold.err(), error("run_length"));
        let made = ShiryaevRoberts::new(1.0, found, Sides::Both);
        assert_eq!(made.err(), Some(StatisticError::Threshold { found }));
    }
}
