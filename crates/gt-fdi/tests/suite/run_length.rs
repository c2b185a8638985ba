//! Average run lengths against published tables, closed forms and other ways to compute them.

use gt_fdi::FdiError;
use gt_fdi::design::{
    CusumRunLength, ExceedanceRunLength, MAX_CONSECUTIVE, MAX_CUSUM_THRESHOLD, MAX_RUN_LENGTH,
    mean_delay_bound,
};
use gt_fdi::runtime::{Sides, Waveform};
use nalgebra::{DMatrix, DVector};
use proptest::prelude::*;
use statrs::distribution::{ContinuousCDF, Normal};

/// Samples in 24 h at 0.08 s.
pub const DAY: f64 = 1.08e6;
/// Published values are compared to 0.1 %, or to half a unit of their last digit where that is more.
const PUBLISHED: f64 = 1e-3;

fn cusum(allowance: f64, threshold: f64, sides: Sides, shift: f64) -> f64 {
    let chart = CusumRunLength::new(allowance, threshold, sides).unwrap();
    chart.samples(shift).unwrap()
}

pub fn assert_close(what: &str, found: f64, expected: f64, tolerance: f64) {
    assert!(
        (found - expected).abs() <= tolerance,
        "{what}: expected {expected}, found {found}"
    );
}

/// D. Brook, D. A. Evans, *Biometrika* 59 (1972): one-sided, k = 0.5, h = 3.
#[test]
fn published_brook_evans() {
    for (shift, expected) in [(0.0, 117.59), (1.5, 3.75)] {
        let found = cusum(0.5, 3.0, Sides::Upper, shift);
        assert_close(
            "upper",
            found,
            expected,
            f64::max(PUBLISHED * expected, 5e-3),
        );
        // The other side is the mirror image.
        assert_eq!(cusum(0.5, 3.0, Sides::Lower, -shift), found);
    }
}

/// J. M. Lucas, R. B. Crosier, *Technometrics* 24 (1982): two-sided, k = 0.5. The table has three
/// digits; the shifts are as reprinted in D. C. Montgomery, *Introduction to Statistical Quality
/// Control*, "ARL performance of the tabular cusum with k = 1/2 and h = 4 or h = 5".
#[test]
fn published_lucas_crosier() {
    let shifts = [0.0, 0.25, 0.5, 0.75, 1.0, 1.5, 2.0, 2.5, 3.0, 4.0];
    let four = [168.0, 74.2, 26.6, 13.3, 8.38, 4.75, 3.34, 2.62, 2.19, 1.71];
    let five = [465.0, 139.0, 38.0, 17.0, 10.4, 5.75, 4.01, 3.11, 2.57, 2.01];
    for (threshold, expected) in [(4.0, four), (5.0, five)] {
        for (shift, expected) in shifts.into_iter().zip(expected) {
            let found = cusum(0.5, threshold, Sides::Both, shift);
            // Half a unit of the third digit.
            let unit = if expected >= 100.0 {
                0.5
            } else if expected >= 10.0 {
                0.05
            } else {
                0.005
            };
            assert_close("both", found, expected, unit);
            assert_close(
                "mirrored",
                cusum(0.5, threshold, Sides::Both, -shift) / found,
                1.0,
                1e-14,
            );
        }
    }
}

/// L. C. Vance, *Journal of Quality Technology* 18 (1986), as in the documentation of R's spc:
/// one-sided, k = 0, h = 10.
#[test]
fn published_vance() {
    for (shift, expected) in [
        (-0.25, 2071.51),
        (-0.125, 400.28),
        (0.0, 124.66),
        (0.125, 59.30),
        (0.25, 36.71),
        (0.5, 20.37),
        (0.75, 14.06),
        (1.0, 10.75),
    ] {
        let found = cusum(0.0, 10.0, Sides::Upper, shift);
        // Half a unit of the last digit, and the table's own error of 0.003 %.
        assert_close("upper", found, expected, 5e-3 + 3e-5 * expected);
    }
}

/// The integral equation by Brook and Evans' other way: a Markov chain of `states` states of equal
/// width (the lowest is zero and half as wide), whose error falls with the square of the width.
fn markov_chain(allowance: f64, threshold: f64, shift: f64, states: usize) -> f64 {
    let width = 2.0 * threshold / (2 * states - 1) as f64;
    let normal = Normal::standard();
    let q = DMatrix::from_fn(states, states, |row, column| {
        let step = (column as f64 - row as f64) * width + allowance - shift;
        let upper = normal.cdf(step + 0.5 * width);
        if column == 0 {
            upper
        } else {
            upper - normal.cdf(step - 0.5 * width)
        }
    });
    let ones = DVector::from_element(states, 1.0);
    (DMatrix::identity(states, states) - q)
        .lu()
        .solve(&ones)
        .unwrap()[0]
}

/// Richardson's extrapolation of the chain agrees: what is left is the chain's next term, of the
/// fourth power of the width, below 2e-6 here.
#[test]
fn the_markov_chain_extrapolates_to_the_integral_equation() {
    for (allowance, threshold, shift) in [(0.5, 3.0, 0.0), (0.25, 6.0, 0.0), (0.5, 4.0, 1.0)] {
        let chain = |states| markov_chain(allowance, threshold, shift, states);
        let (coarse, fine) = (chain(60), chain(120));
        // Widths are as 1 / (2 n - 1).
        let ratio = (239.0_f64 / 119.0).powi(2);
        let extrapolated = fine + (fine - coarse) / (ratio - 1.0);
        let found = cusum(allowance, threshold, Sides::Upper, shift);
        assert_close("extrapolated", extrapolated / found, 1.0, 2e-6);
        // Without extrapolation it is far from that, so the comparison says something.
        assert!((coarse / found - 1.0).abs() > 2e-5);
    }
}

/// Long run lengths keep their digits, where the equations are singular to rounding: the run length
/// grows as `exp(2 k h)`, with a factor that no longer depends on `h` (renewal theory).
#[test]
fn rare_alarms_keep_their_digits() {
    let found = |threshold| {
        let chart = CusumRunLength::new(1.0, threshold, Sides::Upper).unwrap();
        match chart.samples(0.0) {
            Ok(found) | Err(FdiError::RunLength { found, .. }) => found,
            Err(other) => panic!("{other}"),
        }
    };
    for threshold in [10.0, 20.0, 50.0] {
        let growth = found(threshold + 1.0) / found(threshold);
        // What does not grow is a share of h exp(-2 k h) of the rest: 2e-8 at 10.
        assert_close("growth", growth / 2.0_f64.exp(), 1.0, 1e-7);
    }
}

/// D. Siegmund, *Sequential Analysis* (1985), eq. 2.56: within a few per cent where h is not small.
#[test]
fn siegmunds_approximation_is_near() {
    for (allowance, threshold, shift) in [(0.5, 4.0, 0.0), (0.5, 8.0, 0.0), (0.25, 8.0, 1.0)] {
        let (d, b): (f64, f64) = (shift - allowance, threshold + 1.166);
        let siegmund = ((-2.0 * d * b).exp() + 2.0 * d * b - 1.0) / (2.0 * d * d);
        let found = cusum(allowance, threshold, Sides::Upper, shift);
        assert_close("ratio", siegmund / found, 1.0, 0.03);
    }
}

/// At threshold 0 the sum is above it when one sample is above the allowance.
#[test]
fn threshold_0_is_a_limit_on_the_sample() {
    for (allowance, shift) in [(0.5, 0.0), (2.0, 0.3), (0.0, -1.0)] {
        let limit = ExceedanceRunLength::new(allowance, 1, Sides::Upper).unwrap();
        let found = cusum(allowance, 0.0, Sides::Upper, shift);
        let expected = limit.samples(shift).unwrap();
        // Rounding of two ways to the same tail.
        assert_close("ratio", found / expected, 1.0, 1e-13);
    }
}

/// A threshold for a run length gives that run length back, to the accuracy that is promised.
#[test]
fn thresholds_give_the_run_length_asked_for() {
    for sides in [Sides::Upper, Sides::Lower, Sides::Both] {
        for allowance in [0.05, 0.25, 0.5, 1.0, 2.0] {
            for asked in [10.0, 370.0, DAY, 8.0 * DAY, 1e9] {
                let threshold = CusumRunLength::threshold_for(allowance, sides, asked);
                if asked < cusum(allowance, 0.0, sides, 0.0) {
                    assert!(threshold.is_err(), "{allowance} {asked}");
                    continue;
                }
                let threshold = threshold.unwrap();
                let found = cusum(allowance, threshold, sides, 0.0);
                // The root's tolerance of 1e-13 (1 + h) times the slope of the logarithm, about 2 k.
                assert_close("ratio", found / asked, 1.0, 1e-11);
            }
        }
    }
}

/// A CUSUM whose allowance is half the step is optimal: its delays at a mean time of 24 h between
/// false alarms are those of the specification's table, and the bound lies 1.22 to 1.44 times below.
#[test]
fn regress_optimal_delays_for_steps_and_their_bound() {
    for (step, expected) in [(0.25, 301.7), (0.5, 86.5), (1.0, 24.5), (2.0, 6.90)] {
        let threshold = CusumRunLength::threshold_for(0.5 * step, Sides::Upper, DAY).unwrap();
        let delay = cusum(0.5 * step, threshold, Sides::Upper, step);
        // Half a unit of the table's last digit, at most 0.3 %.
        let unit = if expected < 10.0 { 5e-3 } else { 5e-2 };
        assert_close("delay", delay, expected, unit);
        let ratio = delay / mean_delay_bound(Waveform::Step, step, DAY).unwrap();
        assert!((1.215..1.445).contains(&ratio), "{step}: {ratio}");
    }
}

/// A sample that is surely beyond the limit: the alarm comes with the n-th.
#[test]
fn a_huge_shift_alarms_at_once() {
    for sides in [Sides::Upper, Sides::Both] {
        let rule = ExceedanceRunLength::new(3.0, 7, sides).unwrap();
        assert_eq!(rule.samples(50.0), Ok(7.0));
        for shift in 8..60 {
            // Q(-3.5) is 1 - 2e-4, all others are nearer to 1.
            let found = cusum(0.5, 4.0, sides, f64::from(shift));
            assert!((1.0..1.001).contains(&found), "{found}");
        }
    }
    // All samples are beyond a limit of 0 on both sides.
    let rule = ExceedanceRunLength::new(0.0, 3, Sides::Both).unwrap();
    assert_eq!(rule.samples(0.0), Ok(3.0));
}

#[test]
fn what_is_out_of_range_is_refused() {
    let option = |option, expected, found| {
        Err::<f64, FdiError>(FdiError::Option {
            option,
            expected,
            found,
        })
    };
    let new =
        |allowance, threshold| CusumRunLength::new(allowance, threshold, Sides::Both).map(|_| 0.0);
    let expected = "a finite number not below 0";
    assert_eq!(new(-0.1, 4.0), option("allowance", expected, -0.1));
    assert_eq!(
        new(f64::INFINITY, 4.0),
        option("allowance", expected, f64::INFINITY)
    );
    for found in [-1.0, MAX_CUSUM_THRESHOLD * 1.01] {
        assert_eq!(
            new(0.5, found),
            option("threshold", "a number from 0 to 250", found)
        );
    }
    let chart = CusumRunLength::new(0.5, 4.0, Sides::Both).unwrap();
    assert_eq!(
        chart.samples(f64::INFINITY),
        option("shift", "a finite number", f64::INFINITY)
    );
    let rule = |limit, n| ExceedanceRunLength::new(limit, n, Sides::Both).map(|_| 0.0);
    assert_eq!(rule(-1.0, 1), option("limit", expected, -1.0));
    for n in [0, MAX_CONSECUTIVE + 1] {
        let expected = "1 to 1000000 samples";
        assert_eq!(rule(3.0, n), option("consecutive", expected, n as f64));
    }
    for found in [0.0, -1.0, f64::INFINITY] {
        let expected = "a positive finite number";
        assert_eq!(
            mean_delay_bound(Waveform::Ramp, found, DAY),
            option("size", expected, found)
        );
    }
    assert_eq!(
        mean_delay_bound(Waveform::Step, 1e-9, 1e12),
        option("size", "a size that is found within 1e7 samples", 1e-9)
    );
}

#[test]
fn run_lengths_out_of_range_are_refused() {
    let high = MAX_RUN_LENGTH;
    // One-sided, allowance 0: threshold 0 alarms every second sample.
    let found = 1.9;
    let low = match CusumRunLength::threshold_for(0.0, Sides::Upper, found) {
        Err(FdiError::RunLength { low, .. }) => low,
        other => panic!("{other:?}"),
    };
    // The tail at 0 is 1/2 to rounding.
    assert_close("low", low, 2.0, 1e-13);
    assert_eq!(
        CusumRunLength::threshold_for(0.0, Sides::Upper, found),
        Err(FdiError::RunLength { low, high, found })
    );
    assert!(matches!(
        CusumRunLength::threshold_for(0.5, Sides::Upper, f64::NAN),
        Err(FdiError::RunLength { found, .. }) if found.is_nan()
    ));
    // Without an allowance the run length grows only with the square of the threshold.
    assert!(matches!(
        CusumRunLength::threshold_for(0.0, Sides::Upper, 1e6),
        Err(FdiError::RunLength { high, .. }) if high > 6e4 && high < 7e4
    ));
    // Beyond the range of doubles.
    let chart = CusumRunLength::new(5.0, 250.0, Sides::Upper).unwrap();
    let (low, found) = (1.0, f64::INFINITY);
    assert_eq!(
        chart.samples(0.0),
        Err(FdiError::RunLength { low, high, found })
    );
    assert_eq!(
        ExceedanceRunLength::limit_for(3, Sides::Both, 2.5),
        Err(FdiError::RunLength {
            low: 3.0,
            high,
            found: 2.5
        })
    );
    assert_eq!(
        mean_delay_bound(Waveform::Step, 1.0, 0.5),
        Err(FdiError::RunLength {
            low: 1.0,
            high,
            found: 0.5
        })
    );
}

proptest! {
    /// A higher threshold, a higher allowance and a smaller shift all alarm later.
    #[test]
    fn prop_run_lengths_are_monotone(
        allowance in 0.0..1.2_f64, threshold in 0.0..8.0_f64, shift in -0.1..2.0_f64,
        more in 0.01..0.3_f64,
    ) {
        let length = cusum(allowance, threshold, Sides::Upper, shift);
        prop_assert!(length >= 1.0);
        prop_assert!(cusum(allowance, threshold + more, Sides::Upper, shift) > length);
        prop_assert!(cusum(allowance + more, threshold, Sides::Upper, shift) > length);
        prop_assert!(cusum(allowance, threshold, Sides::Upper, shift + more) < length);
        // The other side may add nothing, and two reciprocals round.
        let both = cusum(allowance, threshold, Sides::Both, shift);
        prop_assert!(both <= length * (1.0 + 4.0 * f64::EPSILON));
    }

    /// No detector beats the bound: CUSUMs of any allowance, for a step, from their worst start.
    #[test]
    fn prop_no_cusum_beats_the_bound(
        allowance in 0.05..1.0_f64, step in 0.2..3.0_f64, run_length in 50.0..1e6_f64,
    ) {
        let threshold = CusumRunLength::threshold_for(allowance, Sides::Upper, run_length).unwrap();
        let delay = cusum(allowance, threshold, Sides::Upper, step);
        prop_assert!(delay > mean_delay_bound(Waveform::Step, step, run_length).unwrap());
    }
}
