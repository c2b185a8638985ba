//! Alarm counts and their exact intervals.

use gt_fdi::FdiError;
use gt_fdi::design::{FalseAlarmRate, count_alarms};
use gt_fdi::runtime::Persistence;

/// Exact 95 % limits of a Poisson mean, Garwood (1936), as tabulated to four decimals.
#[test]
fn published_garwood_intervals() {
    for (alarms, low, high) in [
        (0, 0.0, 3.6889),
        (1, 0.0253, 5.5716),
        (2, 0.2422, 7.2247),
        (5, 1.6235, 11.6683),
        (10, 4.7954, 18.3904),
    ] {
        let rate = FalseAlarmRate::from_counts(alarms, 1.0).unwrap();
        // Half a unit of the tables' last digit.
        assert!(
            (rate.per_hour_low - low).abs() <= 0.5e-4,
            "{alarms}: {}",
            rate.per_hour_low
        );
        assert!(
            (rate.per_hour_high - high).abs() <= 0.5e-4,
            "{alarms}: {}",
            rate.per_hour_high
        );
    }
}

/// No event: `exp(-high) = 0.025`, so the upper limit is `ln 40`.
#[test]
fn no_event_has_a_closed_form() {
    let rate = FalseAlarmRate::from_counts(0, 2.0).unwrap();
    assert_eq!((rate.per_hour, rate.per_hour_low), (0.0, 0.0));
    assert!((rate.per_hour_high * 2.0 - 40.0_f64.ln()).abs() < 1e-14);
}

/// The normal limits `k -+ 1.96 sqrt(k)`, shifted by their second-order term, for large counts:
/// low = k - z sqrt(k) + (z^2 - 1) / 3, high = (k + 1) + z sqrt(k + 1) + (z^2 - 1) / 3. The
/// counts stand on both sides of the change of formula for ln k!.
#[test]
fn large_counts_approach_the_normal_limits() {
    let z = 1.959_963_985;
    for alarms in [200, 255, 256, 257, 10_000, 1_000_000] {
        let k = alarms as f64;
        let rate = FalseAlarmRate::from_counts(alarms, 1.0).unwrap();
        let shift = (z * z - 1.0) / 3.0;
        let low = k - z * k.sqrt() + shift;
        let high = k + 1.0 + z * (k + 1.0).sqrt() + shift;
        // The next term of the expansion is below 0.3 / sqrt(k).
        let tolerance = 0.3 / k.sqrt();
        assert!(
            (rate.per_hour_low - low).abs() < tolerance,
            "{alarms} {}",
            rate.per_hour_low - low
        );
        assert!(
            (rate.per_hour_high - high).abs() < tolerance,
            "{alarms} {}",
            rate.per_hour_high - high
        );
    }
}

#[test]
fn rates_are_per_hour() {
    let one = FalseAlarmRate::from_counts(10, 1.0).unwrap();
    let four = FalseAlarmRate::from_counts(10, 4.0).unwrap();
    assert_eq!(four.per_hour, 2.5);
    assert_eq!(four.per_hour_low, one.per_hour_low / 4.0);
    assert_eq!(four.per_hour_high, one.per_hour_high / 4.0);
}

#[test]
fn no_hours_are_refused() {
    for found in [0.0, -1.0, f64::INFINITY] {
        let expected = "a positive finite number of hours";
        let error = FdiError::Option {
            option: "hours",
            expected,
            found,
        };
        assert_eq!(FalseAlarmRate::from_counts(1, found), Err(error));
    }
}

/// By hand: runs above 1 of lengths 1, 3, 2 (cut by a value at the limit, which is not above it),
/// 1 (cut by NaN), 1.
#[test]
fn alarms_are_events_not_samples() {
    let r = [
        0.0,
        2.0,
        0.5,
        -2.0,
        3.0,
        -4.0,
        1.0,
        2.0,
        2.0,
        -1.0,
        5.0,
        f64::NAN,
        5.0,
    ];
    let counts: Vec<usize> = (1..=4)
        .map(|consecutive| count_alarms(&r, 1.0, Persistence::consecutive(consecutive)))
        .collect();
    assert_eq!(counts, [5, 2, 1, 0]);
}
