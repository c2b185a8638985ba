//! The run sum and its run length.

use gt_fdi::FdiError;
use gt_fdi::design::{ExceedanceRunLength, MAX_RUN_SUM_THRESHOLD, RunSumRunLength};
use gt_fdi::runtime::{RunSum, Sides, Statistic, StatisticError};
use nalgebra::{DMatrix, DVector};
use proptest::prelude::*;
use statrs::distribution::{ContinuousCDF, Normal};

use crate::statistics::{SIDES, check_against_batch, events};

proptest! {
    /// From the newest sample back to where the run began.
    #[test]
    fn prop_run_sum_is_its_batch_definition(
        events in events(200), width in 0.2..2.0_f64, side in 0..3_usize,
        mut scores in prop::array::uniform4(0..9_u32),
    ) {
        scores.sort_unstable();
        scores[3] += 1;
        let sides = SIDES[side];
        let mut statistic = RunSum::new(width, scores, 7.0, sides).unwrap();
        check_against_batch(&mut statistic, &events, |_, decision, samples| {
            let sign = samples.iter().rev().find(|&&r| r != 0.0).map_or(0.0, |r| r.signum());
            let counts = match sides {
                Sides::Upper => sign > 0.0,
                Sides::Lower => sign < 0.0,
                Sides::Both => true,
            };
            let run = samples.iter().rev().take_while(|&&r| r * sign >= 0.0);
            let score = |r: &f64| scores[(1..4).filter(|&zone| r.abs() >= f64::from(zone) * width).count()];
            let sum: u32 = run.filter(|&&r| r != 0.0).map(score).sum();
            assert_eq!(decision.value, if counts { f64::from(sum) } else { 0.0 });
        });
    }
}

/// The zone control chart on a short record.
#[test]
fn scores_by_hand() {
    let mut sum = RunSum::new(1.0, RunSum::ZONE_SCORES, 7.0, Sides::Both).unwrap();
    for (r, expected) in [
        (0.4, 0.0),
        (1.3, 2.0),
        (2.0, 6.0),
        (0.0, 6.0),
        (0.1, 6.0),
        (-0.2, 0.0),
        (-1.0, 2.0),
        (-2.9, 6.0),
        (-1.5, 8.0),
        (3.0, 8.0),
        (0.5, 8.0),
        (-3.5, 8.0),
        (1.5, 2.0),
    ] {
        let decision = sum.step(r);
        assert_eq!(decision.value, expected, "{r}");
        assert_eq!(decision.alarm, expected >= 8.0);
    }
    assert_eq!((sum.upper(), sum.lower()), (2, 0));
}

/// Other ways to the run length: zones in which only the outermost scores are a plain limit, and in
/// which the score is 1 everywhere beyond zero, a row of samples; both in closed form.
#[test]
fn run_lengths_of_degenerate_scores_have_closed_forms() {
    for sides in SIDES {
        for shift in [0.0, 0.7, -1.2] {
            let sum = RunSumRunLength::new(0.8, [0, 0, 0, 5], 4, sides).unwrap();
            let limit = ExceedanceRunLength::new(2.4, 1, sides).unwrap();
            let ratio = sum.samples(shift).unwrap() / limit.samples(shift).unwrap();
            assert!((ratio - 1.0).abs() < 1e-11, "{ratio}");
        }
        // Six in a row on one side of zero, whatever the zones.
        let sum = RunSumRunLength::new(0.8, [1; 4], 5, sides).unwrap();
        // p^-1 + ... + p^-6 = 126 with p = 1/2; on either side, one less of them.
        let expected = if sides == Sides::Both { 63.0 } else { 126.0 };
        let found = sum.samples(0.0).unwrap();
        assert!((found / expected - 1.0).abs() < 1e-11, "{found}");
    }
}

/// The zone control chart, whose sums are even, as a chain of seven states that is written down and
/// solved by LU: the sums 6, 4, 2 below zero, none, and 2, 4, 6 above.
#[test]
fn the_zone_chart_by_another_chain() {
    let normal = Normal::new(0.0, 1.0).unwrap();
    for (shift, rounded) in [(0.0, 95.05), (0.5, 26.00), (1.0, 8.19), (2.0, 2.86)] {
        // Zones from the outermost below to the outermost above.
        let limits = [-3.0, -2.0, -1.0, 0.0, 1.0, 2.0, 3.0].map(|z: f64| normal.cdf(z - shift));
        let p = |zone: usize| {
            let below = if zone == 0 { 0.0 } else { limits[zone - 1] };
            limits.get(zone).copied().unwrap_or(1.0) - below
        };
        let q = DMatrix::from_fn(7, 7, |from, to| {
            let [from, to] = [from, to].map(|state| [-3, -2, -1, 0, 1, 2, 3][state]);
            let up = |before: i32| match to - before {
                0 => p(4),
                1 => p(5),
                2 => p(6),
                _ => 0.0,
            };
            let down = |before: i32| match before - to {
                0 => p(3),
                1 => p(2),
                2 => p(1),
                _ => 0.0,
            };
            let rises = if to >= 0 { up(from.max(0)) } else { 0.0 };
            let falls = if to <= 0 { down(from.min(0)) } else { 0.0 };
            rises + falls
        });
        let times = (DMatrix::identity(7, 7) - q)
            .lu()
            .solve(&DVector::from_element(7, 1.0))
            .unwrap();
        let chart = RunSumRunLength::new(1.0, RunSum::ZONE_SCORES, 7, Sides::Both).unwrap();
        let found = chart.samples(shift).unwrap();
        assert!(
            (found / times[3] - 1.0).abs() < 1e-11,
            "{found} {}",
            times[3]
        );
        assert!((found - rounded).abs() < 0.005, "{found}");
    }
}

#[test]
fn widths_have_the_run_length_they_were_found_for() {
    for run_length in [100.0, 5000.0, 1.08e6] {
        for sides in SIDES {
            let scores = RunSum::ZONE_SCORES;
            let width = RunSumRunLength::width_for(scores, 7, sides, run_length).unwrap();
            let chart = RunSumRunLength::new(width, scores, 7, sides).unwrap();
            let found = chart.samples(0.0).unwrap();
            assert!((found / run_length - 1.0).abs() < 1e-9, "{found}");
        }
    }
    // At least eight samples in a row on one side, as 2^-8 x 2 is the chance of that.
    let error = RunSumRunLength::width_for([1, 2, 4, 8], 7, Sides::Both, 300.0).err();
    let Some(FdiError::RunLength { low, high, found }) = error else {
        panic!("{error:?}");
    };
    // No zones at all: the first sample alarms; nothing beyond the first: 2^8 - 1.
    assert!((low - 1.0).abs() < 1e-5 && (high - 255.0).abs() < 1e-9 && found == 300.0);
}

#[test]
fn bad_zones_are_refused() {
    let scores = RunSum::ZONE_SCORES;
    let error = |option, expected, found| {
        Some(StatisticError::Option {
            option,
            expected,
            found,
        })
    };
    for found in [0.0, f64::INFINITY] {
        let made = RunSum::new(found, scores, 7.0, Sides::Both);
        assert_eq!(
            made.err(),
            error("width", "a positive finite number", found)
        );
    }
    let made = RunSum::new(1.0, [0, 2, 1, 8], 7.0, Sides::Both);
    let expected = "a score not below that of the zone inside";
    assert_eq!(made.err(), error("scores", expected, 1.0));
    let made = RunSum::new(1.0, [0; 4], 7.0, Sides::Both);
    let expected = "a score above 0 in the outermost zone";
    assert_eq!(made.err(), error("scores", expected, 0.0));
    let made = RunSum::new(1.0, scores, 0.0, Sides::Both);
    let found = 0.0;
    assert_eq!(made.err(), Some(StatisticError::Threshold { found }));
    for threshold in [0, MAX_RUN_SUM_THRESHOLD + 1] {
        let made = RunSumRunLength::new(1.0, scores, threshold, Sides::Both);
        let expected = FdiError::Option {
            option: "threshold",
            expected: "a whole number from 1 to 250",
            found: f64::from(threshold),
        };
        assert_eq!(made.err(), Some(expected));
    }
    let made = RunSumRunLength::new(-1.0, scores, 7, Sides::Both);
    let expected = error("width", "a positive finite number", -1.0);
    assert_eq!(made.err(), expected.map(FdiError::Statistic));
    let chart = RunSumRunLength::new(1.0, scores, 7, Sides::Both).unwrap();
    let (option, expected, found) = ("shift", "a finite number", f64::INFINITY);
    let expected = FdiError::Option {
        option,
        expected,
        found,
    };
    assert_eq!(chart.samples(f64::INFINITY).err(), Some(expected));
}
