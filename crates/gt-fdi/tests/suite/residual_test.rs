//! Tests on residuals: what they compute, and whether they keep the rate that they promise.

use gt_core::{Dataset, OperatingPoint, Signal, StateSpace};
use gt_fdi::FdiError;
use gt_fdi::design::{
    Bank, MeanTime, ResidualGenerator, ResidualTest, StatisticKind, ThresholdRule,
};
use gt_fdi::runtime::Waveform;
use nalgebra::{DMatrix, DVector};

use crate::fixtures::noise;

/// An hour a sample, so that hours count samples.
const HOUR_S: f64 = 3600.0;

/// A generator without states for each tag: the residuals are the outputs themselves.
fn outputs_themselves(tags: &[&str]) -> ResidualGenerator {
    let ny = tags.len();
    let model = StateSpace::new(
        [
            DMatrix::zeros(0, 0),
            DMatrix::zeros(0, 0),
            DMatrix::zeros(ny, 0),
            DMatrix::zeros(ny, 0),
        ],
        HOUR_S,
        vec![],
        Signal::named(tags),
    )
    .unwrap();
    let ones = vec![1.0; ny];
    let noise = gt_fdi::NoiseCovariance::errors_in_variables(&model, &[], &ones).unwrap();
    ResidualGenerator::kalman(model, OperatingPoint::zero(0, ny), noise).unwrap()
}

fn record(tags: &[&str], y: DMatrix<f64>) -> Dataset {
    Dataset::new(
        vec![],
        Signal::named(tags),
        DMatrix::zeros(0, y.ncols()),
        y,
        HOUR_S,
    )
    .unwrap()
}

/// White, or a first-order colour of pole 0.8.
fn residual(seed: u64, len: usize, coloured: bool) -> Dataset {
    let mut values = noise(seed, len);
    if coloured {
        for t in 1..len {
            values[t] += 0.8 * values[t - 1];
        }
    }
    record(&["r"], DMatrix::from_row_slice(1, len, &values))
}

fn mean_time(hours: f64) -> ThresholdRule {
    ThresholdRule::MeanTimeBetweenFalseAlarms {
        hours,
        consecutive: 1,
    }
}

const KINDS: [StatisticKind; 8] = [
    StatisticKind::Cusum { allowance: 0.5 },
    StatisticKind::Cusum { allowance: 0.25 },
    StatisticKind::Glr {
        waveform: Waveform::Ramp,
        smallest: 0.01,
        largest: 0.1,
        longest: 64,
    },
    StatisticKind::MovingAverage { window: 20 },
    StatisticKind::ChiSquare { window: 10 },
    StatisticKind::ShiryaevRoberts { shift: 1.0 },
    StatisticKind::Variance { window: 30 },
    StatisticKind::Whiteness {
        window: 100,
        lags: 4,
    },
];

/// Asked for one alarm in 2000 samples on 60 000 healthy ones, then counted on 200 000 fresh ones:
/// within three standard deviations of the count and of the promise together, whether the
/// residual is white or not.
#[test]
fn the_rate_that_was_asked_for_is_kept() {
    const ASKED: f64 = 2000.0;
    for coloured in [false, true] {
        let generator = outputs_themselves(&["r"]);
        let healthy = [residual(1, 30_000, coloured), residual(2, 30_000, coloured)];
        let fresh = residual(3, 200_000, coloured);
        for kind in KINDS {
            let test =
                ResidualTest::calibrate("r", &[&generator], &healthy, kind, mean_time(ASKED));
            let test = test.unwrap();
            let promise = test.false_alarms.mean_time.unwrap();
            assert!(promise.supported(), "{kind:?}: {promise:?}");
            let bank = Bank::new("one", vec![generator.clone()], vec![test]).unwrap();
            let run = bank.run(&fresh).unwrap();
            let counted = run.alarms.len() as f64;
            let expected = fresh.len() as f64 / ASKED;
            // The interval of the promise has 1.96 standard deviations on either side.
            let of_promise = (promise.hours_high.unwrap() / promise.hours.unwrap()).ln() / 1.96;
            let deviation = (1.0 / expected + of_promise * of_promise).sqrt();
            // An alarm that lasts takes time in which none can begin: up to a quarter here.
            let off = (counted / expected).ln();
            assert!(
                off < 3.0 * deviation && off > -3.0 * deviation - 0.3,
                "{kind:?}, coloured {coloured}: {counted} of {expected}, promise {promise:?}"
            );
        }
    }
}

/// Without whitening, the same cumulative sum on the coloured residual would alarm all the time.
#[test]
fn colour_is_what_makes_false_alarms() {
    let generator = outputs_themselves(&["r"]);
    let kind = StatisticKind::Cusum { allowance: 0.5 };
    let white = [residual(1, 30_000, false), residual(2, 30_000, false)];
    let test =
        ResidualTest::calibrate("r", &[&generator], &white, kind, mean_time(2000.0)).unwrap();
    let bank = Bank::new("one", vec![generator], vec![test]).unwrap();
    let alarms = bank.run(&residual(3, 20_000, true)).unwrap().alarms.len();
    assert!(alarms > 100, "{alarms} where 10 were asked for");
}

/// The joint statistic is the root of `e' L^-1 e`, here with `L` by hand.
#[test]
fn several_residuals_become_their_normalised_norm() {
    const LEN: usize = 4000;
    let (a, b) = (noise(11, LEN), noise(12, LEN));
    let y = DMatrix::from_fn(2, LEN, |row, t| match row {
        0 => 5.0 + 2.0 * a[t],
        _ => 100.0 * (0.6 * a[t] + 0.8 * b[t]),
    });
    let data = record(&["p", "q"], y.clone());
    let generator = outputs_themselves(&["p", "q"]);
    let rule = ThresholdRule::Exceedance {
        share: 0.01,
        consecutive: 2,
    };
    let healthy = std::slice::from_ref(&data);
    let kind = StatisticKind::Modulus;
    let test = ResidualTest::calibrate("both", &[&generator], healthy, kind, rule).unwrap();
    assert_eq!(test.outputs, ["p", "q"]);
    let limit = test.threshold.limit;
    // Chi-square with two degrees of freedom: 1 % lie above -2 ln 0.01 = 9.21; 40 of 4000 do, so
    // that the limit's square is known to about 2 / sqrt(40) = 0.3; four of that.
    assert!((limit * limit - 9.21).abs() < 1.3, "{limit}");
    let bank = Bank::new("joint", vec![generator], vec![test]).unwrap();
    let run = bank.run(&data).unwrap();
    let mean = DVector::from_vec(vec![y.row(0).mean(), y.row(1).mean()]);
    let mut centred = y.clone();
    for mut column in centred.column_iter_mut() {
        column -= &mean;
    }
    let mut covariance = &centred * centred.transpose() / LEN as f64;
    covariance[(0, 1)] *= 1.0 - 1e-3;
    covariance[(1, 0)] *= 1.0 - 1e-3;
    let inverse = covariance.try_inverse().unwrap();
    for t in (0..LEN).step_by(97) {
        let e = centred.column(t);
        let expected = (e.transpose() * &inverse * e)[0].sqrt();
        let found = run.statistics[(0, t)];
        assert!((found - expected).abs() < 1e-11 * (1.0 + expected), "{t}");
    }
    assert_eq!(run.residuals.row(1), y.row(1));
}

/// A step of the residual is found with its onset and its size in the output's unit.
#[test]
fn a_deviation_is_told_in_the_outputs_unit() {
    let generator = outputs_themselves(&["r"]);
    let healthy = [residual(1, 30_000, true), residual(2, 30_000, true)];
    let kind = StatisticKind::Glr {
        waveform: Waveform::Step,
        smallest: 0.1,
        largest: 5.0,
        longest: 512,
    };
    let rule = mean_time(5000.0);
    let test = ResidualTest::calibrate("r", &[&generator], &healthy, kind, rule).unwrap();
    let bank = Bank::new("one", vec![generator], vec![test]).unwrap();
    let mut faulty = residual(4, 3000, true);
    let mut y = faulty.y().clone();
    // The residual's deviation is 1 / sqrt(1 - 0.64) = 1.7; whitened, 3 becomes 3 x 0.2 = 0.6.
    y.columns_mut(2000, 1000).add_scalar_mut(3.0);
    faulty = record(&["r"], y);
    let run = bank.run(&faulty).unwrap();
    let alarm = run
        .alarms
        .iter()
        .find(|alarm| alarm.time_s >= 2000.0 * HOUR_S);
    let alarm = alarm.expect("an alarm");
    let onset = alarm.onset_s.unwrap() / HOUR_S;
    // Windows grow by the square root of two.
    let age = alarm.time_s / HOUR_S - 2000.0;
    assert!((onset - 2000.0).abs() < 2.0 * age + 20.0, "{onset} {age}");
    let deviation = alarm.deviation.unwrap();
    // The mean of `age` whitened samples, 0.2 of the unit each; an alarm picks a high one.
    let error = 4.0 / age.sqrt() / 0.2;
    assert!((deviation - 3.0).abs() < error, "{deviation} {error}");
}

/// However long a step stands, and however far beyond the ceiling of the sum, its size is told: 40
/// standard deviations, within four of the mean of so many samples.
#[test]
fn a_cumulative_sum_knows_a_large_step_for_as_long_as_it_lasts() {
    let generator = outputs_themselves(&["r"]);
    let healthy = [residual(1, 3000, false), residual(2, 3000, false)];
    let kind = StatisticKind::Cusum { allowance: 0.5 };
    let test = ResidualTest::calibrate("r", &[&generator], &healthy, kind, mean_time(1000.0));
    let bank = Bank::new("one", vec![generator], vec![test.unwrap()]).unwrap();
    let mut detector = gt_fdi::Detector::new(&bank);
    let draws = noise(9, 1200);
    for (t, draw) in draws.iter().enumerate() {
        let y = draw + if t >= 200 { 40.0 } else { 0.0 };
        let verdict = detector.step(t as f64 * HOUR_S, &[], &[y]).unwrap();
        if t >= 200 {
            let channel = &verdict.channels[0];
            let found = channel.deviation.unwrap();
            // The sum may have begun before the step, by some samples that count as part of it.
            let age = channel.onset_age.unwrap() as f64;
            let faulty = (t - 199) as f64;
            let expected = 40.0 * faulty / age;
            let tolerance = 4.0 / faulty.sqrt() + 0.05 * expected + 3.0 * (age - faulty) / age;
            assert!(
                (found - expected).abs() < tolerance,
                "{t}: {found} {expected}"
            );
        }
    }
}

/// A fifth of 500 samples is no window of 125 and what comes after: refused, not set to zero.
#[test]
fn records_shorter_than_a_window_are_refused() {
    let generator = outputs_themselves(&["r"]);
    let rule = ThresholdRule::Exceedance {
        share: 0.01,
        consecutive: 1,
    };
    for kind in [
        StatisticKind::MovingAverage { window: 125 },
        StatisticKind::ChiSquare { window: 125 },
        StatisticKind::Variance { window: 125 },
        StatisticKind::Whiteness {
            window: 125,
            lags: 4,
        },
    ] {
        let healthy = [residual(1, 500, false)];
        let error = ResidualTest::calibrate("r", &[&generator], &healthy, kind, rule);
        let short = FdiError::ShortFold {
            needed: 126,
            found: 100,
        };
        assert_eq!(error, Err(short), "{kind:?}");
    }
    // An allowance that no healthy sample exceeds leaves a sum of zero, which limits nothing.
    let kind = StatisticKind::Cusum { allowance: 6.0 };
    let healthy = [residual(1, 5000, false)];
    let error = ResidualTest::calibrate("r", &[&generator], &healthy, kind, rule);
    assert_eq!(
        error.unwrap_err().to_string(),
        "threshold: expected a positive finite number, found 0"
    );
    let rule = ThresholdRule::MeanTimeBetweenFalseAlarms {
        hours: 100.0,
        consecutive: 6,
    };
    let kind = StatisticKind::Cusum { allowance: 0.5 };
    let error = ResidualTest::calibrate("r", &[&generator], &healthy, kind, rule);
    assert!(
        error
            .unwrap_err()
            .to_string()
            .starts_with("option `consecutive`: expected 1 where")
    );
}

#[test]
fn a_promise_needs_healthy_running() {
    let generator = outputs_themselves(&["r"]);
    let kind = StatisticKind::Cusum { allowance: 0.5 };
    let promise = |len: usize, asked: f64| -> MeanTime {
        let healthy = [residual(1, len / 2, false), residual(2, len / 2, false)];
        let test = ResidualTest::calibrate("r", &[&generator], &healthy, kind, mean_time(asked));
        test.unwrap().false_alarms.mean_time.unwrap()
    };
    let short = promise(400, 1e6);
    assert!(!short.supported(), "{short:?}");
    assert_eq!(
        (short.hours, short.peaks, short.asked_hours),
        (None, 0, 1e6)
    );
    assert!(short.healthy_hours_needed > 400.0);
    let middle = promise(4000, 1e6);
    assert!(!middle.supported() && middle.hours.is_some(), "{middle:?}");
    #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)] // some thousands
    let needed = middle.healthy_hours_needed as usize;
    // Twice as much as it asks for is enough, to the spread of the estimate itself.
    let enough = promise(2 * needed, 1e6);
    assert!(enough.supported(), "{middle:?} {enough:?}");
    let (low, high) = (enough.hours_low.unwrap(), enough.hours_high.unwrap());
    assert!(low < enough.hours.unwrap() && enough.hours.unwrap() < high);
}

#[test]
fn the_limit_for_white_residuals_is_the_least() {
    let generator = outputs_themselves(&["r"]);
    let kind = StatisticKind::Cusum { allowance: 0.5 };
    let healthy = [residual(1, 300, false), residual(2, 300, false)];
    let rule = mean_time(465.0);
    let test = ResidualTest::calibrate("r", &[&generator], &healthy, kind, rule).unwrap();
    // Lucas and Crosier: two-sided, allowance 0.5, limit 5: 465 samples.
    assert!(test.threshold.limit > 4.99, "{}", test.threshold.limit);
}

#[test]
fn a_models_own_record_counts_more() {
    let generator = outputs_themselves(&["r"]);
    let healthy = [residual(1, 500, false), residual(2, 500, false)];
    let rule = ThresholdRule::Margin {
        factor: 1.5,
        consecutive: 1,
    };
    let with = |factors: [f64; 2]| {
        let optimism = DMatrix::from_row_slice(1, 2, &factors);
        let kind = StatisticKind::Modulus;
        ResidualTest::calibrate_in_sample("r", &[&generator], &healthy, &optimism, kind, rule)
    };
    let limit = |factors| with(factors).unwrap().threshold.limit;
    let plain = ResidualTest::calibrate("r", &[&generator], &healthy, StatisticKind::Modulus, rule);
    assert_eq!(limit([1.0, 1.0]), plain.unwrap().threshold.limit);
    let both = limit([1.1, 1.1]) / limit([1.0, 1.0]);
    assert!((both - 1.1).abs() < 1e-15, "{both}");
    assert_eq!(
        with([1.0, 0.9]),
        Err(FdiError::Option {
            option: "optimism",
            expected: "a finite factor not below 1",
            found: 0.9
        })
    );
    let optimism = DMatrix::from_element(2, 2, 1.0);
    let kind = StatisticKind::Modulus;
    let error =
        ResidualTest::calibrate_in_sample("r", &[&generator], &healthy, &optimism, kind, rule);
    assert_eq!(
        error.unwrap_err().to_string(),
        "rows of the optimism: expected 1, found 2"
    );
}

#[test]
fn statistics_out_of_range_are_refused() {
    let generator = outputs_themselves(&["r"]);
    let healthy = [residual(1, 500, false)];
    let refused = |kind: StatisticKind| {
        let test = ResidualTest::calibrate("r", &[&generator], &healthy, kind, mean_time(10.0));
        test.unwrap_err().to_string()
    };
    assert_eq!(
        refused(StatisticKind::MovingAverage { window: 0 }),
        "window: expected 1 to 65536 samples, found 0"
    );
    assert_eq!(
        refused(StatisticKind::Cusum { allowance: -1.0 }),
        "allowance: expected a finite number not below 0, found -1"
    );
    let two = outputs_themselves(&["p", "q"]);
    let y = DMatrix::from_vec(2, 500, noise(5, 1000));
    let pair = [record(&["p", "q"], y)];
    let kind = StatisticKind::Cusum { allowance: 0.5 };
    let error = ResidualTest::calibrate("both", &[&two], &pair, kind, mean_time(10.0));
    assert_eq!(error, Err(FdiError::SignedStatistic { found: 2 }));
    let error = ResidualTest::calibrate("r", &[], &healthy, StatisticKind::Modulus, mean_time(1.0));
    assert!(matches!(error, Err(FdiError::EmptyBank { .. })));
}
