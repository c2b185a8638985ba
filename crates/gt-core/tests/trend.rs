//! Linear trends of records.

#![allow(clippy::unwrap_used, reason = "the helpers of a test may fail it")]
#![allow(clippy::float_cmp, reason = "exact by construction")]

use gt_core::{Dataset, Signal};
use nalgebra::{DMatrix, DVector};
use proptest::prelude::*;

fn record(u: Vec<f64>, y: Vec<f64>) -> Dataset {
    let count = u.len();
    let (u, y) = (
        DMatrix::from_vec(1, count, u),
        DMatrix::from_vec(1, count, y),
    );
    let (inputs, outputs) = (Signal::named(&["u"]), Signal::named(&["y"]));
    let data = Dataset::new(inputs, outputs, u, y, 0.5).unwrap();
    data.starting_at(10.0)
}

#[test]
fn a_line_is_found_and_leaves_its_mean() {
    let line = |a: f64, b: f64| (0..20).map(|k| a + b * 0.5 * f64::from(k)).collect();
    let data = record(line(3.0, -2.0), line(1e6, 0.25));
    let trend = data.trend();
    // Twenty numbers of up to 1e6 with a rounding of 1e-10 each.
    assert!((trend.u_slope_per_s[0] + 2.0).abs() < 1e-12);
    assert!((trend.y_slope_per_s[0] - 0.25).abs() < 1e-9);
    assert_eq!(trend.centre_time_s, 10.0 + 4.75);
    let flat = data.detrended(&trend).unwrap();
    for (flat, mean) in [(flat.u(), 3.0 - 2.0 * 4.75), (flat.y(), 1e6 + 0.25 * 4.75)] {
        assert!(flat.iter().all(|value| (value - mean).abs() < 1e-8));
    }
    assert_eq!(flat.start_time_s(), 10.0);
    // A later part of the record lies on the same line.
    let part = data.rows(12..20).unwrap().detrended(&trend).unwrap();
    assert_eq!(part.y().as_slice(), &flat.y().as_slice()[12..]);
}

#[test]
fn what_is_missing_is_left_out() {
    let mut values: Vec<f64> = (0..10).map(f64::from).collect();
    values[3] = f64::NAN;
    values[7] = f64::INFINITY;
    let data = record(values, vec![f64::NAN; 10]);
    let trend = data.trend();
    assert!((trend.u_slope_per_s[0] - 2.0).abs() < 1e-12);
    assert_eq!(trend.y_slope_per_s[0], 0.0);
    let flat = data.detrended(&trend).unwrap();
    assert!(flat.u()[3].is_nan() && flat.u()[7].is_infinite());
    for count in [0, 1] {
        let short = record(vec![5.0; count], vec![5.0; count]);
        assert_eq!(short.trend().u_slope_per_s[0], 0.0);
        assert_eq!(short.detrended(&short.trend()).unwrap(), short);
    }
}

#[test]
fn a_trend_of_other_channels_is_refused() {
    let data = record(vec![1.0, 2.0], vec![1.0, 2.0]);
    let mut trend = data.trend();
    trend.y_slope_per_s = DVector::zeros(2);
    assert_eq!(
        data.detrended(&trend).unwrap_err().to_string(),
        "output slopes of the trend: expected 1, found 2"
    );
}

proptest! {
    /// What is left is not correlated with time, and the trend comes back.
    #[test]
    fn prop_nothing_of_the_trend_is_left(
        u in proptest::collection::vec(-1e3..1e3f64, 3..40),
    ) {
        let y = u.iter().map(|value| 2.0 - value).collect();
        let data = record(u, y);
        let trend = data.trend();
        let flat = data.detrended(&trend).unwrap();
        // Rounding of values of 1e3 over at least half a second.
        prop_assert!(flat.trend().u_slope_per_s.amax() < 1e-10);
        let back = flat.retrended(&trend).unwrap();
        prop_assert!((back.u() - data.u()).amax() < 1e-9);
        prop_assert!((back.y() - data.y()).amax() < 1e-9);
    }
}
