//! Thresholds from healthy residuals.

use gt_fdi::FdiError;
use gt_fdi::design::{Calibration, ThresholdRule, calibrate, count_alarms};
use gt_fdi::runtime::Persistence;
use proptest::prelude::*;

use crate::fixtures::{TS, noise};

fn exceedance(share: f64, consecutive: usize) -> ThresholdRule {
    ThresholdRule::Exceedance { share, consecutive }
}

fn margin(factor: f64, consecutive: usize) -> ThresholdRule {
    ThresholdRule::Margin {
        factor,
        consecutive,
    }
}

fn mean_time(hours: f64, consecutive: usize) -> ThresholdRule {
    ThresholdRule::MeanTimeBetweenFalseAlarms { hours, consecutive }
}

fn share_above(residual: &[f64], limit: f64) -> f64 {
    residual.iter().filter(|r| r.abs() > limit).count() as f64 / residual.len() as f64
}

#[test]
fn exceedance_is_the_smallest_limit_by_hand() {
    let residual: Vec<f64> = (1..=100)
        .map(f64::from)
        .map(|r| if r > 50.0 { -r } else { r })
        .collect();
    for (share, limit) in [(0.01, 99.0), (0.05, 95.0), (0.29, 71.0), (0.055, 95.0)] {
        let calibration = calibrate(&[&residual], TS, exceedance(share, 1)).unwrap();
        assert_eq!(calibration.threshold.limit, limit, "{share}");
    }
}

/// On white noise of unit variance a limit set for a share holds on fresh noise: 1e5 samples at
/// 1 % have a standard deviation of 0.03 %; the limit's own error adds as much. Five of those.
#[test]
fn exceedance_holds_on_fresh_white_noise() {
    let (training, fresh) = (noise(1, 100_000), noise(2, 100_000));
    let calibration = calibrate(&[&training], TS, exceedance(0.01, 1)).unwrap();
    let tolerance = 5.0 * (2.0 * 0.01 * 0.99 / 1e5_f64).sqrt();
    let share = share_above(&fresh, calibration.threshold.limit);
    assert!((share - 0.01).abs() < tolerance, "{share}");
    let cross = calibration.cross_validated_exceedance_share;
    assert!((cross - 0.01).abs() < tolerance, "{cross}");
    // The two-sided 1 % point of the normal distribution, 2.5758, within the same error divided
    // by its density there, 2 x 0.01446.
    assert!((calibration.threshold.limit - 2.5758).abs() < tolerance / 0.0289);
}

#[test]
fn margin_multiplies_the_healthy_maximum() {
    let records = [&[0.5, -2.0, 1.0][..], &[0.1, 1.5, 0.2, 0.3]];
    let calibration = calibrate(&records, 3600.0, margin(1.25, 1)).unwrap();
    assert_eq!(calibration.threshold.limit, 2.5);
    assert_eq!(
        (
            calibration.false_alarms.alarms,
            calibration.false_alarms.hours
        ),
        (0, 7.0)
    );
    // Judged by each other: 1.25 x 1.5 = 1.875 lets -2 through in the first, 2.5 nothing.
    assert_eq!(calibration.cross_validated.alarms, 1);
    assert!((calibration.cross_validated_exceedance_share - 1.0 / 7.0).abs() < 1e-15);
}

/// In the sample a limit at the maximum never alarms; on the block that holds the maximum, a limit
/// set on the other four does.
#[test]
fn a_single_record_is_cross_validated_in_five_blocks() {
    let mut residual = vec![1.0; 50];
    residual[23] = 4.0;
    let Calibration {
        false_alarms,
        cross_validated,
        cross_validated_exceedance_share,
        ..
    } = calibrate(&[&residual], 36.0, margin(1.0, 1)).unwrap();
    assert_eq!(false_alarms.alarms, 0);
    assert_eq!(cross_validated.alarms, 1);
    assert_eq!(cross_validated.hours, 0.5);
    assert_eq!(cross_validated_exceedance_share, 0.02);
}

/// A record unlike the others is what cross-validation finds and the sample itself hides.
#[test]
fn cross_validation_shows_a_record_that_is_unlike_the_others() {
    let calm: Vec<Vec<f64>> = (0..3).map(|seed| noise(seed, 5000)).collect();
    let rough: Vec<f64> = noise(9, 5000).iter().map(|r| 3.0 * r).collect();
    let mut records: Vec<&[f64]> = calm.iter().map(Vec::as_slice).collect();
    records.push(&rough);
    let calibration = calibrate(&records, TS, exceedance(0.01, 1)).unwrap();
    let in_sample: usize = records
        .iter()
        .map(|r| {
            r.iter()
                .filter(|r| r.abs() > calibration.threshold.limit)
                .count()
        })
        .sum();
    assert_eq!(in_sample, 200);
    // The calm records' 1 % point is 2.58, 0.86 standard deviations of the rough one: 39 % of its
    // samples, a quarter of all, are above, within 5 standard deviations of 0.7 % / 4 and the
    // error of the limit.
    let share = calibration.cross_validated_exceedance_share;
    assert!((share - 0.39 / 4.0).abs() < 0.01, "{share}");
    // Events, not samples: 0.39 x 0.61 x 5000 runs against at most 200.
    assert!(calibration.cross_validated.alarms > 4 * calibration.false_alarms.alarms);
}

/// By hand, an hour a sample, 2 h between alarms: a limit of 3 leaves one event (5) and 11 clear
/// hours, 2 two events (5 and 3) and 10, 1 three events and 9: each leaves 2 h for each event.
/// Just below 1, the ones join in: runs 1 5 1, 1 3 1, 1 2 1 and 3 clear hours for three events.
#[test]
fn mean_time_is_found_by_hand() {
    let residual = [0.0, 1.0, 5.0, 1.0, 0.0, 1.0, -3.0, 1.0, 0.0, 1.0, 2.0, 1.0];
    let calibration = calibrate(&[&residual], 3600.0, mean_time(2.0, 1)).unwrap();
    assert_eq!(calibration.threshold.limit, 1.0);
    assert_eq!(calibration.false_alarms.alarms, 3);
    // 4 h between alarms: at 2 there are two events and 10 clear hours, at 1 three and 9.
    let calibration = calibrate(&[&residual], 3600.0, mean_time(4.0, 1)).unwrap();
    assert_eq!(
        (calibration.threshold.limit, calibration.false_alarms.alarms),
        (2.0, 2)
    );
    // Two samples in a row are needed: at 1 no run is that long.
    let calibration = calibrate(&[&residual], 3600.0, mean_time(4.0, 2)).unwrap();
    assert_eq!(
        (calibration.threshold.limit, calibration.false_alarms.alarms),
        (1.0, 0)
    );
}

/// Counting events alone, a slow residual would allow a limit of 0: one alarm that never ends.
#[test]
fn mean_time_does_not_hide_in_an_endless_alarm() {
    let residual: Vec<f64> = (0..100).map(f64::from).collect();
    let calibration = calibrate(&[&residual], 3600.0, mean_time(30.0, 1)).unwrap();
    // One event needs 30 clear samples: 0 to 29 are clear when the limit is 29.
    assert_eq!(calibration.threshold.limit, 29.0);
}

#[test]
fn too_little_healthy_running_is_an_error_that_says_how_much() {
    let residual = noise(1, 2000);
    let error = calibrate(
        &[&residual[..999], &residual[..1000]],
        36.0,
        mean_time(10.0, 1),
    );
    let expected = FdiError::HealthyHours {
        asked_hours: 10.0,
        needed_hours: 30.0,
        found_hours: 19.99,
    };
    assert_eq!(error, Err(expected));
    // Exactly three times is enough.
    assert!(calibrate(&[&residual], 36.0, mean_time(20.0 / 3.0, 1)).is_ok());

    let error = calibrate(&[&residual[..99]], TS, exceedance(0.01, 1));
    assert_eq!(
        error,
        Err(FdiError::HealthyTotal {
            share: 0.01,
            needed: 100,
            found: 99
        })
    );
    assert!(calibrate(&[&residual[..100]], TS, exceedance(0.01, 1)).is_ok());

    let error = calibrate(&[&residual[..29]], TS, margin(1.0, 6));
    assert_eq!(
        error,
        Err(FdiError::HealthySamples {
            record: 0,
            needed: 30,
            found: 29
        })
    );
    let error = calibrate(&[&residual, &residual[..5]], TS, margin(1.0, 6));
    assert_eq!(
        error,
        Err(FdiError::HealthySamples {
            record: 1,
            needed: 6,
            found: 5
        })
    );
    assert_eq!(
        calibrate(&[], TS, margin(1.0, 1)),
        Err(FdiError::NoHealthyData)
    );
}

#[test]
fn residuals_that_are_not_finite_are_named() {
    let bad = [1.0, 2.0, f64::INFINITY];
    let error = calibrate(&[&[1.0, 2.0], &bad], TS, margin(1.0, 1));
    let what = "healthy residual 1".to_owned();
    assert_eq!(
        error,
        Err(FdiError::NotFiniteResidual {
            what,
            sample: 2,
            found: f64::INFINITY
        })
    );
    // Finite residuals whose margin overflows have no limit.
    let error = calibrate(&[&[f64::MAX; 5]], TS, margin(2.0, 1));
    assert_eq!(
        error,
        Err(FdiError::Limit {
            found: f64::INFINITY
        })
    );
}

#[test]
fn rule_parameters_out_of_range_are_named() {
    let residual = noise(1, 100);
    let error = |rule| match calibrate(&[&residual], TS, rule) {
        Err(FdiError::Option { option, found, .. }) => (option, found),
        other => panic!("{other:?}"),
    };
    assert_eq!(error(exceedance(0.0, 1)), ("share", 0.0));
    assert_eq!(error(exceedance(1.0, 1)), ("share", 1.0));
    assert_eq!(error(margin(0.0, 1)), ("factor", 0.0));
    assert_eq!(error(margin(f64::INFINITY, 1)), ("factor", f64::INFINITY));
    assert_eq!(error(mean_time(-1.0, 1)), ("hours", -1.0));
    for rule in [exceedance(0.5, 0), margin(1.0, 0), mean_time(1e-9, 0)] {
        assert_eq!(error(rule), ("consecutive", 0.0));
    }
    assert!(error(margin(f64::NAN, 1)).1.is_nan());
}

#[test]
fn rules_have_a_stable_file_format() {
    let rule: ThresholdRule = serde_json::from_str(
        r#"{"kind": "mean_time_between_false_alarms", "hours": 24, "consecutive": 3}"#,
    )
    .unwrap();
    assert_eq!(rule, mean_time(24.0, 3));
    let json = serde_json::to_string(&exceedance(0.01, 2)).unwrap();
    assert_eq!(
        json,
        r#"{"kind":"exceedance","share":0.01,"consecutive":2}"#
    );
    let unknown = r#"{"kind": "margin", "factor": 2, "consecutive": 1, "colour": 3}"#;
    assert!(serde_json::from_str::<ThresholdRule>(unknown).is_err());
}

proptest! {
    /// The one-pass search agrees with trying every value as the limit, from the top down, and
    /// counting; small integers make many ties.
    #[test]
    fn prop_mean_time_is_the_last_limit_that_holds(
        records in prop::collection::vec(prop::collection::vec(-6_i32..7, 12..40), 2..5),
        consecutive in 1_usize..5,
        hours in 1.0_f64..6.0,
    ) {
        let records: Vec<Vec<f64>> =
            records.into_iter().map(|r| r.into_iter().map(f64::from).collect()).collect();
        let slices: Vec<&[f64]> = records.iter().map(Vec::as_slice).collect();
        let holds = |limit: f64| {
            let alarms: usize = slices.iter().map(|r| count_alarms(r, limit, Persistence::consecutive(consecutive))).sum();
            let mut clear = 0_usize;
            for record in &slices {
                let mut run = 0_usize;
                for r in *record {
                    run = if r.abs() > limit { run + 1 } else { 0 };
                    clear += usize::from(run < consecutive);
                }
            }
            alarms as f64 * hours <= clear as f64
        };
        let mut values: Vec<f64> = slices.concat().iter().map(|r| r.abs()).collect();
        values.sort_by(|left, right| right.total_cmp(left));
        values.dedup();
        let expected = *values.iter().take_while(|limit| holds(**limit)).last().unwrap();
        let found = calibrate(&slices, 3600.0, mean_time(hours, consecutive)).unwrap();
        prop_assert_eq!(found.threshold.limit, expected);
        // And so no more events than the whole time holds.
        let rate = found.false_alarms;
        prop_assert!(rate.alarms as f64 * hours <= rate.hours);
    }
}
