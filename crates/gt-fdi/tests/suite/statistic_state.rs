//! States of statistics: saved and resumed, pushed to their limits, refused.

use gt_fdi::runtime::{
    Cusum, Glr, GrowingChiSquare, GrowingVariance, Growth, LARGEST_SAMPLE, MAX_WINDOW,
    MovingAverage, RunSum, ShiryaevRoberts, Sides, Sprt, Statistic, StatisticError, Waveform,
    Whiteness, WindowedChiSquare, WindowedVariance,
};
use proptest::prelude::*;
use serde::Serialize;
use serde::de::DeserializeOwned;

use crate::fixtures::noise;
use crate::statistics::{Event, events};

const GROWTH: Growth = Growth {
    shortest: 5,
    longest: 40,
};

proptest! {
    /// Saved as JSON at any time, a statistic goes on bit for bit.
    #[test]
    fn prop_saved_statistics_resume_bit_for_bit(events in events(200), cut in 0..200_usize) {
        let both = Sides::Both;
        resumes(&Cusum::new(0.5, 5.0, both).unwrap(), &events, cut);
        resumes(&MovingAverage::new(13, 1.0, both).unwrap(), &events, cut);
        resumes(&WindowedChiSquare::new(13, 40.0).unwrap(), &events, cut);
        resumes(&Glr::new(Waveform::Ramp, (1e-3, 0.1), 37, 9.0, both).unwrap(), &events, cut);
        resumes(&Glr::new(Waveform::Step, (0.1, 3.0), 37, 9.0, both).unwrap(), &events, cut);
        resumes(&Sprt::new(0.1, -50.0, 50.0).unwrap(), &events, cut);
        resumes(&ShiryaevRoberts::new(0.7, 8.0, both).unwrap(), &events, cut);
        resumes(&WindowedVariance::new(13, 3.0, both).unwrap(), &events, cut);
        resumes(&GrowingChiSquare::new(GROWTH, 3.0, both).unwrap(), &events, cut);
        resumes(&GrowingVariance::new(GROWTH, 3.0, both).unwrap(), &events, cut);
        resumes(&RunSum::new(0.9, [0, 2, 4, 8], 7.0, both).unwrap(), &events, cut);
        resumes(&Whiteness::new(17, 5, 20.0).unwrap(), &events, cut);
    }
}

fn resumes<S>(fresh: &S, events: &[Event], cut: usize)
where
    S: Statistic + Clone + PartialEq + std::fmt::Debug + Serialize + DeserializeOwned,
{
    let mut through = fresh.clone();
    let mut resumed = fresh.clone();
    for (index, event) in events.iter().enumerate() {
        if index == cut.min(events.len() / 2) {
            let text = serde_json::to_string(&resumed).unwrap();
            resumed = serde_json::from_str(&text).unwrap();
            assert_eq!(resumed, through);
        }
        match *event {
            Event::Reset => {
                through.reset();
                resumed.reset();
            }
            Event::Sample(r) => {
                let values = [through.step(r), resumed.step(r)].map(|d| d.value.to_bits());
                assert_eq!(values[0], values[1]);
            }
        }
    }
    assert_eq!(resumed, through);
    // A reset leaves nothing behind that could show later.
    through.reset();
    let mut fresh = fresh.clone();
    for r in noise(3, 100) {
        assert_eq!(through.step(r), fresh.step(r));
    }
}

/// The largest doubles neither overflow nor poison what follows.
#[test]
fn huge_samples_are_survived() {
    let both = Sides::Both;
    let mut cusum = Cusum::new(0.5, 5.0, both).unwrap();
    let mut average = MovingAverage::new(100, 5.0, both).unwrap();
    let mut chi_square = WindowedChiSquare::new(100, 5.0).unwrap();
    let mut glr = Glr::new(Waveform::Ramp, (1e-4, f64::MAX), 4096, 11.0, both).unwrap();
    let mut sprt = Sprt::new(1e-3, -1.0, 1e300).unwrap();
    let mut procedure = ShiryaevRoberts::new(f64::MAX, 1.0, both).unwrap();
    let mut variance = WindowedVariance::new(100, 5.0, both).unwrap();
    let forever = Growth {
        shortest: 2,
        longest: u64::MAX,
    };
    let mut growing = GrowingChiSquare::new(forever, 5.0, both).unwrap();
    let mut growing_variance = GrowingVariance::new(forever, 5.0, both).unwrap();
    let mut whiteness = Whiteness::new(100, 20, 5.0).unwrap();
    let mut run_sum = RunSum::new(f64::MIN_POSITIVE, [u32::MAX; 4], 5.0, both).unwrap();
    for k in 0..20_000 {
        let r = [f64::MAX, f64::MAX, -f64::MAX, 1.0][k % 4];
        let values = [
            cusum.step(r).value,
            average.step(r).value,
            chi_square.step(r).value,
            glr.step(r).value,
            sprt.step(r).value,
            procedure.step(r).value,
            variance.step(r).value,
            growing.step(r).value,
            growing_variance.step(r).value,
            whiteness.step(r).value,
            run_sum.step(r).value,
        ];
        assert!(values.iter().all(|v| v.is_finite()), "{k}: {values:?}");
    }
    for _ in 0..200 {
        average.step(0.25);
        chi_square.step(0.5);
    }
    assert_eq!((average.value(), chi_square.value()), (0.25, 25.0));
    for k in 0..200 {
        let r = [1.0, -1.0][k % 2];
        variance.step(r);
        whiteness.step(r);
    }
    // 100 / 99, and correlations of (100 - k) / 100 with alternating signs: 100 x 102 x
    // sum_k (100 - k) / 100^2 over 20 lags.
    assert!((variance.variance().unwrap() - 100.0 / 99.0).abs() < 1e-14);
    assert!((whiteness.value() - 1.02 * 1790.0).abs() < 1e-9);
}

#[test]
fn what_is_out_of_range_is_refused() {
    use StatisticError as E;
    let both = Sides::Both;
    for found in [0.0, -1.0, f64::INFINITY] {
        let expected = Some(E::Threshold { found });
        assert_eq!(Cusum::new(0.5, found, both).err(), expected);
        assert_eq!(MovingAverage::new(5, found, both).err(), expected);
        assert_eq!(WindowedChiSquare::new(5, found).err(), expected);
        let glr = Glr::new(Waveform::Step, (0.1, 1.0), 5, found, both);
        assert_eq!(glr.err(), expected);
    }
    for found in [-0.1, f64::INFINITY] {
        let expected = Some(E::Allowance { found });
        assert_eq!(Cusum::new(found, 5.0, both).err(), expected);
    }
    for found in [0, MAX_WINDOW + 1] {
        let longest = MAX_WINDOW;
        let expected = Some(E::Window { longest, found });
        assert_eq!(MovingAverage::new(found, 1.0, both).err(), expected);
        assert_eq!(WindowedChiSquare::new(found, 1.0).err(), expected);
        let glr = Glr::new(Waveform::Step, (0.1, 1.0), found, 9.0, both);
        assert_eq!(glr.err(), expected);
    }
    for (smallest, largest) in [(0.0, 1.0), (2.0, 1.0), (1.0, f64::INFINITY), (-2.0, -1.0)] {
        let glr = Glr::new(Waveform::Ramp, (smallest, largest), 5, 9.0, both);
        assert_eq!(glr.err(), Some(E::Sizes { smallest, largest }));
    }
    for found in [0.0, f64::INFINITY] {
        assert_eq!(Sprt::new(found, -1.0, 1.0).err(), Some(E::Shift { found }));
    }
    for (accept, reject) in [(0.0, 1.0), (-1.0, 0.0), (f64::NEG_INFINITY, 1.0)] {
        let expected = Some(E::Bounds { accept, reject });
        assert_eq!(Sprt::new(1.0, accept, reject).err(), expected);
    }
    assert!(matches!(
        Cusum::new(f64::NAN, 5.0, both),
        Err(E::Allowance { found }) if found.is_nan()
    ));
}

/// Saved, with `from` replaced by `to`, the statistic is refused, and it is said `why`.
fn refused<S: Serialize + DeserializeOwned>(statistic: &S, from: &str, to: &str, why: &str) {
    let text = serde_json::to_string(statistic).unwrap();
    assert!(text.contains(from), "{text}");
    let broken = text.replacen(from, to, 1);
    let error = serde_json::from_str::<S>(&broken)
        .err()
        .unwrap()
        .to_string();
    assert!(error.contains(why), "{error}");
}

/// States that no statistic can have are refused, with the reason.
#[test]
fn broken_states_are_refused() {
    let both = Sides::Both;
    let cusum = Cusum::new(0.5, 5.0, both).unwrap();
    refused(
        &cusum,
        r#""value":0.0"#,
        r#""value":-1.0"#,
        "state, sum: expected a number from 0",
    );
    refused(
        &cusum,
        r#""threshold":5.0"#,
        r#""threshold":0.0"#,
        "threshold: expected a positive",
    );
    refused(&cusum, r#""sides""#, r#""side""#, "unknown field `side`");
    let (from, to) = (r#""age":0"#, r#""age":3"#);
    refused(
        &cusum,
        from,
        to,
        "state, age: expected a number from 0 to 0, found 3",
    );
    let (from, to) = (r#""value":0.0"#, r#""value":2.0"#);
    refused(&cusum, from, to, "state, age: expected a number from 1 to");
    let falling = Cusum::new(0.5, 5.0, Sides::Lower).unwrap();
    refused(
        &falling,
        from,
        to,
        "state, sum: expected a number from 0 to 0, found 2",
    );
    let average = MovingAverage::new(3, 1.0, both).unwrap();
    refused(
        &average,
        r#""filled":0"#,
        r#""filled":3"#,
        "filled: expected a number from 0 to 2",
    );
    refused(
        &average,
        r#""block":[0.0,"#,
        r#""block":["#,
        "rest: expected 2 numbers, found 3",
    );
    refused(
        &average,
        r#""rest":[0.0"#,
        r#""rest":[1e300"#,
        "state, value: expected",
    );
    let chi_square = WindowedChiSquare::new(3, 1.0).unwrap();
    refused(
        &chi_square,
        r#""rest":[0.0"#,
        r#""rest":[-1.0"#,
        "state, square: expected",
    );
    let glr = Glr::new(Waveform::Ramp, (0.1, 1.0), 2, 9.0, both).unwrap();
    refused(
        &glr,
        "[]",
        "[0,0,0,0,0]",
        "samples: expected 4 numbers, found 5",
    );
    refused(&glr, "[]", "[1e101]", "state, sample: expected");
    refused(
        &glr,
        r#""longest":2"#,
        r#""longest":0"#,
        "window: expected 1 to 65536",
    );
    let sprt = Sprt::new(1.0, -1.0, 1.0).unwrap();
    refused(&sprt, r#""shift":1.0"#, r#""shift":0.0"#, "shift: expected");
    assert_eq!(LARGEST_SAMPLE, 1e100);
}

/// The same for procedures, run sums, growing windows, variances and correlations.
#[test]
fn broken_states_of_further_statistics_are_refused() {
    let both = Sides::Both;
    let procedure = ShiryaevRoberts::new(1.0, 5.0, Sides::Upper).unwrap();
    let (from, to) = (r#""lower":0.0"#, r#""lower":0.5"#);
    refused(&procedure, from, to, "value: expected a number from 0 to 0");
    let to = r#""lower":-0.5"#;
    refused(&procedure, from, to, "state, value: expected");
    let variance = WindowedVariance::new(2, 3.0, both).unwrap();
    refused(
        &variance,
        "[]",
        "[0,0,0,0]",
        "samples: expected 3 numbers, found 4",
    );
    refused(&variance, "[]", "[-1e101]", "state, sample: expected");
    let energy = GrowingChiSquare::new(GROWTH, 3.0, both).unwrap();
    let (from, to) = (r#""count":0"#, r#""count":41"#);
    refused(
        &energy,
        from,
        to,
        "count: expected a number from 0 to 40, found 41",
    );
    let (from, to) = (r#""sum":0.0"#, r#""sum":1.0"#);
    refused(&energy, from, to, "sum: expected a number from 0 to 0");
    let (from, to) = (r#""shortest":5"#, r#""shortest":50"#);
    refused(&energy, from, to, "expected 1 <= shortest <= longest");
    let variance = GrowingVariance::new(GROWTH, 3.0, both).unwrap();
    let (from, to) = (r#""mean":0.0"#, r#""mean":1.0"#);
    refused(&variance, from, to, "mean: expected a number from 0 to 0");
    let (from, to) = (r#""squares":0.0"#, r#""squares":-1.0"#);
    refused(&variance, from, to, "squares: expected a number from 0");
    let sum = RunSum::new(1.0, [0, 2, 4, 8], 7.0, both).unwrap();
    let (from, to) = (r#""upper":0,"lower":0"#, r#""upper":2,"lower":2"#);
    refused(
        &sum,
        from,
        to,
        "sum: expected a number from 0 to 0, found 2",
    );
    refused(&sum, "[0,2,4,8]", "[0,2,4]", "invalid length 3");
    refused(&sum, "[0,2,4,8]", "[0,4,2,8]", "option `scores`: expected");
    let whiteness = Whiteness::new(2, 1, 9.0).unwrap();
    refused(
        &whiteness,
        "[]",
        "[0,0,0]",
        "samples: expected 2 numbers, found 3",
    );
    refused(&whiteness, "[]", "[1e7]", "state, sample: expected");
    let (from, to) = (r#""lags":1"#, r#""lags":2"#);
    refused(&whiteness, from, to, "lags: expected 1 to 1, found 2");
}
