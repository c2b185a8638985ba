//! The Shiryaev-Roberts procedure against its sum over all onsets.

use gt_fdi::FdiError;
use gt_fdi::design::{
    CusumRunLength, MAX_RUN_LENGTH, MAX_SHIRYAEV_ROBERTS_THRESHOLD, ShiryaevRobertsRunLength,
};
use gt_fdi::runtime::{ShiryaevRoberts, Sides, Statistic, StatisticError};
use nalgebra::{DMatrix, DVector};
use proptest::prelude::*;
use statrs::distribution::{Continuous, ContinuousCDF, Normal};

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

/// The mean run length is that of `R` at the alarm, whose overshoot is that of a random walk with
/// normal steps: `R / (run length)` tends to `2 / d^2 exp(-2 sum_n Phi(-d sqrt(n) / 2) / n)` (Siegmund,
/// *Sequential Analysis*, 1985).
#[test]
fn run_lengths_have_the_overshoot_of_renewal_theory() {
    let normal = Normal::new(0.0, 1.0).unwrap();
    for shift in [0.2_f64, 0.5, 1.0, 2.0] {
        let terms = (1..20_000).map(|n| {
            let n = f64::from(n);
            normal.cdf(-0.5 * shift * n.sqrt()) / n
        });
        let share = 2.0 / (shift * shift) * (-2.0 * terms.sum::<f64>()).exp();
        let threshold = 1e9_f64.ln_1p();
        let procedure = ShiryaevRobertsRunLength::new(shift, threshold).unwrap();
        let found = 1e9 / procedure.samples(0.0).unwrap();
        assert!(
            (found / share - 1.0).abs() < 1e-6,
            "{shift}: {found} {share}"
        );
    }
}

/// The same integral equation on a grid in `R` itself, by Simpson's rule and LU.
#[test]
fn run_lengths_by_another_quadrature() {
    let normal = Normal::new(0.0, 1.0).unwrap();
    for (shift, limit, mean) in [(1.0, 50.0, 0.0), (1.0, 50.0, 1.0), (0.7, 20.0, -0.3)] {
        // The square of the grid is finer near R = 0, where the density is narrow.
        const STEPS: usize = 1600;
        let step = f64::sqrt(limit) / STEPS as f64;
        let node = |index: usize| index as f64 * step;
        let weight = |index: usize| {
            let simpson = match index {
                0 | STEPS => 1.0,
                _ if index % 2 == 1 => 4.0,
                _ => 2.0,
            };
            // dR = 2 x dx.
            simpson * step / 3.0 * 2.0 * node(index)
        };
        // R' = (1 + R) exp(d r - d^2 / 2).
        let density = |from: f64, to: f64| {
            let r = ((to / (1.0 + from)).ln() + 0.5 * shift * shift) / shift;
            if to > 0.0 {
                normal.pdf(r - mean) / (shift * to)
            } else {
                0.0
            }
        };
        let equation = DMatrix::from_fn(STEPS + 1, STEPS + 1, |row, column| {
            let (from, to) = (node(row) * node(row), node(column) * node(column));
            f64::from(u8::from(row == column)) - weight(column) * density(from, to)
        });
        let ones = DVector::from_element(STEPS + 1, 1.0);
        let expected = equation.lu().solve(&ones).unwrap()[0];
        let procedure = ShiryaevRobertsRunLength::new(shift, f64::ln_1p(limit)).unwrap();
        let found = procedure.samples(mean).unwrap();
        assert!((found / expected - 1.0).abs() < 1e-8, "{found} {expected}");
    }
}

/// Thresholds give the time they were found for; from the start the mean delay is above that of a
/// CUSUM, which is best in the worst case, by a quarter at most.
#[test]
fn thresholds_have_the_run_length_they_were_found_for() {
    for shift in [0.1, 0.5, 1.0, 3.0] {
        for run_length in [10.0, 1e3, 1.08e6] {
            let threshold = ShiryaevRobertsRunLength::threshold_for(shift, run_length).unwrap();
            let procedure = ShiryaevRobertsRunLength::new(shift, threshold).unwrap();
            let found = procedure.samples(0.0).unwrap();
            assert!((found / run_length - 1.0).abs() < 1e-8, "{shift}: {found}");
            let safe = ShiryaevRoberts::safe_threshold(run_length).unwrap();
            assert!(threshold < safe);
            if run_length > 1e2 {
                let delay = procedure.samples(shift).unwrap();
                let allowance = 0.5 * shift;
                let limit = CusumRunLength::threshold_for(allowance, Sides::Upper, run_length);
                let cusum = CusumRunLength::new(allowance, limit.unwrap(), Sides::Upper).unwrap();
                let best = cusum.samples(shift).unwrap();
                assert!(
                    best < delay && delay < 1.25 * best,
                    "{shift}: {delay} {best}"
                );
            }
        }
    }
}

#[test]
fn bad_run_lengths_are_refused() {
    let error = |option, expected, found| {
        Some(FdiError::Option {
            option,
            expected,
            found,
        })
    };
    let expected = "a number from 0.1 to 5";
    for found in [0.05, 5.5] {
        let made = ShiryaevRobertsRunLength::new(found, 5.0);
        assert_eq!(made.err(), error("shift", expected, found));
        let made = ShiryaevRobertsRunLength::threshold_for(found, 500.0);
        assert_eq!(made.err(), error("shift", expected, found));
    }
    for found in [0.0, MAX_SHIRYAEV_ROBERTS_THRESHOLD + 1.0] {
        let made = ShiryaevRobertsRunLength::new(1.0, found);
        let expected = "a number above 0 up to 30";
        assert_eq!(made.err(), error("threshold", expected, found));
    }
    let procedure = ShiryaevRobertsRunLength::new(1.0, 5.0).unwrap();
    let found = f64::INFINITY;
    let expected = error("mean", "a finite number", found);
    assert_eq!(procedure.samples(found).err(), expected);
    for found in [0.5, 2.0 * MAX_RUN_LENGTH] {
        let error = ShiryaevRobertsRunLength::threshold_for(1.0, found).err();
        assert!(matches!(error, Some(FdiError::RunLength { found: f, .. }) if f == found));
    }
}
