//! Statistics of all samples since the window began.

use gt_fdi::runtime::{
    GrowingChiSquare, GrowingVariance, Growth, Sides, Statistic, StatisticError,
};
use proptest::prelude::*;
use statrs::distribution::{ContinuousCDF, Normal};

use crate::fixtures::noise;
use crate::statistics::{SIDES, assert_near, check_against_batch, events, folded, last};
use crate::windowed_variance::{score, squared_deviations};

/// The samples of the window that the newest belongs to.
fn window(samples: &[f64], longest: u64) -> &[f64] {
    let longest = usize::try_from(longest).unwrap_or(usize::MAX);
    let Some(others) = samples.len().checked_sub(1) else {
        return samples;
    };
    last(samples, others % longest + 1)
}

proptest! {
    #[test]
    fn prop_growing_statistics_are_their_batch_definitions(
        events in events(300), shortest in 2..40_u64, more in 0..60_u64, forever: bool,
        side in 0..3_usize,
    ) {
        let longest = if forever { u64::MAX } else { shortest + more };
        let (growth, sides) = (Growth { shortest, longest }, SIDES[side]);
        let mut energy = GrowingChiSquare::new(growth, 3.0, sides).unwrap();
        check_against_batch(&mut energy, &events, |statistic, decision, samples| {
            let samples = window(samples, longest);
            assert_eq!(statistic.count(), samples.len() as u64);
            let sum = samples.iter().map(|r| r * r).sum();
            assert_near(statistic.sum(), sum, sum);
            let n = samples.len() as f64;
            let value = folded(sides, score(statistic.sum(), n));
            let expected = if samples.len() as u64 >= shortest { value } else { 0.0 };
            assert_near(decision.value, expected, expected.abs());
        });
        let mut variance = GrowingVariance::new(growth, 3.0, sides).unwrap();
        check_against_batch(&mut variance, &events, |statistic, decision, samples| {
            let samples = window(samples, longest);
            let degrees = samples.len() as f64 - 1.0;
            assert_eq!(statistic.count(), samples.len() as u64);
            let moduli = samples.iter().map(|r| r.abs()).sum();
            assert_near(statistic.mean() * (degrees + 1.0), samples.iter().sum(), moduli);
            let squares = statistic.variance().map_or(0.0, |v| v * degrees);
            let energy = samples.iter().map(|r| r * r).sum();
            assert_near(squares, squared_deviations(samples), energy);
            let value = folded(sides, score(squares, degrees));
            let expected = if samples.len() as u64 >= shortest { value } else { 0.0 };
            assert_near(decision.value, expected, expected.abs());
        });
    }
}

/// A sum of 8 over 1 degree: v = 2 / 9, (2 - 1 + v) / sqrt(v) = 11 / 9 x 3 / sqrt(2).
#[test]
fn scores_by_hand() {
    let growth = Growth {
        shortest: 1,
        longest: 2,
    };
    let mut energy = GrowingChiSquare::new(growth, 1.0, Sides::Upper).unwrap();
    let expected = 11.0 / 3.0 / 2.0_f64.sqrt();
    let value = energy.step(8.0_f64.sqrt()).value;
    assert!((value - expected).abs() < 1e-14, "{value}");
    // 2 degrees with the mean square 8 again, then a new window: v = 1 / 9, 10 / 9 x 3.
    let value = energy.step(8.0_f64.sqrt()).value;
    assert!((value - 10.0 / 3.0).abs() < 1e-14, "{value}");
    assert_eq!(
        (energy.step(0.0).value, energy.count()),
        (-7.0 / 9.0 / (2.0_f64 / 9.0).sqrt(), 1)
    );
    let growth = Growth {
        shortest: 2,
        longest: u64::MAX,
    };
    let mut variance = GrowingVariance::new(growth, 1.0, Sides::Both).unwrap();
    assert_eq!(variance.step(5.0).value, 0.0);
    assert_eq!(variance.variance(), None);
    // 5 and 9: the variance 8 with 1 degree.
    let value = variance.step(9.0).value;
    assert!((value - expected).abs() < 1e-14, "{value}");
}

/// The threshold means the same at any length: at 20 samples and at 2000, the share of healthy
/// windows above it is that of a normal variable, within four standard errors and the 5 % to which
/// the cube root is normal this far out.
#[test]
fn the_threshold_means_the_same_at_any_length() {
    const WINDOWS: usize = 4000;
    let normal = Normal::new(0.0, 1.0).unwrap();
    for (length, threshold) in [(20, 1.0), (20, 2.0), (2000, 1.0), (2000, 2.0)] {
        let growth = Growth {
            shortest: length as u64,
            longest: length as u64,
        };
        let samples = noise(91 + length as u64, WINDOWS * length);
        for sides in [Sides::Upper, Sides::Lower] {
            let mut energy = GrowingChiSquare::new(growth, threshold, sides).unwrap();
            let mut variance = GrowingVariance::new(growth, threshold, sides).unwrap();
            let (mut energies, mut variances) = (0, 0);
            for &r in &samples {
                energies += usize::from(energy.step(r).alarm);
                variances += usize::from(variance.step(r).alarm);
            }
            let share = normal.sf(threshold);
            let error = (share / WINDOWS as f64).sqrt();
            for found in [energies, variances] {
                let found = found as f64 / WINDOWS as f64;
                assert!(
                    (found - share).abs() < 4.0 * error + 0.05 * share,
                    "{length} {threshold}: {found} {share}"
                );
            }
        }
    }
}

/// Up to 100 times the shortest length, the chance of a false alarm at three standard deviations is
/// many times that at one length, and grows with the logarithm of the length.
#[test]
fn looks_at_growing_lengths_add_up() {
    const PATHS: usize = 1000;
    let growth = Growth {
        shortest: 20,
        longest: u64::MAX,
    };
    let mut energy = GrowingChiSquare::new(growth, 2.5, Sides::Upper).unwrap();
    let (mut first, mut second) = (0_usize, 0_usize);
    for samples in noise(99, PATHS * 2000).chunks(2000) {
        energy.reset();
        match samples.iter().position(|&r| energy.step(r).alarm) {
            Some(at) if at < 200 => first += 1,
            Some(_) => second += 1,
            None => {}
        }
    }
    let [first, second] = [first, second].map(|count| count as f64 / PATHS as f64);
    let once = 0.00621;
    assert!(
        first > 4.0 * once && second > 2.0 * once,
        "{first} {second}"
    );
    // A decade each; the standard error of either is 0.006.
    assert!((first - second).abs() < 0.025, "{first} {second}");
}

#[test]
fn bad_growths_are_refused() {
    for (least, shortest, longest) in [(1, 0, 5), (1, 6, 5), (2, 1, 5), (2, 3, 2)] {
        let growth = Growth { shortest, longest };
        let expected = Some(StatisticError::Growth {
            least,
            shortest,
            longest,
        });
        let found = if least == 1 {
            GrowingChiSquare::new(growth, 3.0, Sides::Both).err()
        } else {
            GrowingVariance::new(growth, 3.0, Sides::Both).err()
        };
        assert_eq!(found, expected);
    }
    let growth = Growth {
        shortest: 2,
        longest: 3,
    };
    let found = -1.0;
    let expected = Some(StatisticError::Threshold { found });
    let made = GrowingChiSquare::new(growth, found, Sides::Both);
    assert_eq!(made.err(), expected);
    let made = GrowingVariance::new(growth, found, Sides::Both);
    assert_eq!(made.err(), expected);
}
