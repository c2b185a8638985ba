//! The mean time between false alarms of every statistic: asked for, set, and counted on fresh
//! residuals.
//!
//! What is counted is the mean of [`PATHS`] run lengths with its 99 % interval, from their own
//! spread. Where the threshold comes from a simulation, the 99 % interval of that is added in
//! squares, so that the interval is of the ratio of the two. Each count has residuals of its own;
//! seeds are fixed, as of forty intervals of 99 % one is missed every third time.

use gt_fdi::design::{
    CusumRunLength, ExceedanceRunLength, RunSumRunLength, ShiryaevRobertsRunLength,
    SimulatedRunLength, SimulatedRuns,
};
use gt_fdi::runtime::{
    AdaptiveThreshold, Cusum, ExceedanceRun, Glr, GrowingChiSquare, GrowingVariance, Growth,
    Modulus, MovingAverage, Persistence, RunSum, ShiryaevRoberts, Sides, Sprt, SprtDecision,
    Statistic, Waveform, Whiteness, WindowedChiSquare, WindowedVariance,
};

use crate::simulation::white;
use crate::statistics::SIDES;

/// Run lengths counted: of about the standard deviation of their mean, so that the interval is
/// 2.58 / sqrt(2000) = 5.8 % to either side.
const PATHS: usize = 2000;
/// Paths for a threshold, and the length of each in mean times between false alarms.
const CALIBRATION: (usize, usize) = (4000, 5);
const SEEDS: (u64, u64) = (500_000_000, 700_000_000);
/// 99.5 % quantile of the standard normal distribution.
const QUANTILE: f64 = 2.5758;
/// No interval is wider than this share of the mean to either side, so that it can tell.
const WIDEST: f64 = 0.08;

/// Mean of the run lengths of a statistic that is reset before each, and half the 99 % interval.
fn count<S: Statistic>(what: &str, mut statistic: S) -> (f64, f64) {
    let bits = |seed: u64, byte| seed.wrapping_mul(0x0100_0000_01b3) ^ u64::from(byte);
    let threshold = statistic.threshold().to_bits().to_le_bytes();
    let seed = what.bytes().chain(threshold).fold(SEEDS.1, bits);
    // Room for the paths.
    let mut noise = white(seed >> 1);
    let lengths: Vec<f64> = (0..PATHS)
        .map(|path| {
            statistic.reset();
            let mut residual = noise(path);
            let mut length = 1.0;
            while !statistic.step(residual()).alarm {
                length += 1.0;
            }
            length
        })
        .collect();
    let mean = lengths.iter().sum::<f64>() / PATHS as f64;
    let squares: f64 = lengths.iter().map(|l| (l - mean) * (l - mean)).sum();
    (mean, QUANTILE * squares.sqrt() / PATHS as f64)
}

/// The time asked for lies within the interval counted, widened by `more` of the mean.
fn assert_counted<S: Statistic>(what: &str, statistic: S, asked: f64, more: f64) {
    let (mean, half) = count(what, statistic);
    let half = half.hypot(more * mean);
    assert!(half < WIDEST * mean, "{what}: {half} of {mean}");
    assert!(
        (mean - asked).abs() < half,
        "{what}: asked {asked}, counted {mean} +- {half}"
    );
}

/// The threshold for the time asked for, by simulation, and half its interval over the mean.
fn calibrate<S: Statistic>(mut statistic: S, asked: f64) -> (f64, f64) {
    let (paths, times) = CALIBRATION;
    #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)] // hundreds
    let samples = times * asked as usize;
    let runs = SimulatedRuns::run(&mut statistic, paths, samples, white(SEEDS.0)).unwrap();
    let SimulatedRunLength {
        threshold,
        samples,
        high,
        ..
    } = runs.threshold_for(asked).unwrap();
    (threshold, (high / samples).ln())
}

/// Calibrates what `made` gives for a threshold, and counts.
fn assert_calibrated<S: Statistic>(what: &str, asked: f64, made: impl Fn(f64) -> S) {
    let (threshold, more) = calibrate(made(1.0), asked);
    let found = made(threshold);
    assert_eq!(found.threshold(), threshold);
    assert_counted(what, found, asked, more);
}

#[test]
fn limits_and_rows() {
    /// Samples in a row beyond a limit.
    struct Row {
        run: ExceedanceRun,
        limit: f64,
        consecutive: usize,
    }
    impl Statistic for Row {
        fn take(&mut self, r: f64) {
            let wait = Persistence::consecutive(self.consecutive);
            self.run.update(0.0, r.abs(), self.limit, wait);
        }
        fn reset(&mut self) {
            self.run.clear();
        }
        fn value(&self) -> f64 {
            self.run.length() as f64
        }
        fn threshold(&self) -> f64 {
            self.consecutive as f64 - 0.5
        }
    }
    let both = Sides::Both;
    for consecutive in [1, 2, 5] {
        let limit = ExceedanceRunLength::limit_for(consecutive, both, 1000.0).unwrap();
        let row = Row {
            run: ExceedanceRun::default(),
            limit,
            consecutive,
        };
        assert_counted("row", row, 1000.0, 0.0);
    }
    for sides in SIDES {
        let limit = ExceedanceRunLength::limit_for(1, sides, 800.0).unwrap();
        let single = MovingAverage::new(1, limit, sides).unwrap();
        assert_counted("limit", single, 800.0, 0.0);
    }
    let limit = ExceedanceRunLength::limit_for(1, both, 600.0).unwrap();
    assert_counted("modulus", Modulus::new(limit), 600.0, 0.0);
}

#[test]
fn cusums() {
    for sides in SIDES {
        for (allowance, asked) in [(0.25, 500.0), (0.5, 1000.0)] {
            let threshold = CusumRunLength::threshold_for(allowance, sides, asked).unwrap();
            let cusum = Cusum::new(allowance, threshold, sides).unwrap();
            assert_counted("CUSUM", cusum, asked, 0.0);
        }
    }
}

#[test]
fn run_sums() {
    let scores = RunSum::ZONE_SCORES;
    for (sides, asked) in SIDES.into_iter().zip([500.0, 500.0, 1000.0]) {
        let width = RunSumRunLength::width_for(scores, 7, sides, asked).unwrap();
        let sum = RunSum::new(width, scores, 7.0, sides).unwrap();
        assert_counted("run sum", sum, asked, 0.0);
    }
    // The zone control chart as it is: 95.05 samples.
    let chart = RunSum::new(1.0, scores, 7.0, Sides::Both).unwrap();
    assert_counted("zone chart", chart, 95.05, 0.0);
}

/// Both sides have nearly the time of one at the same threshold: within 2 %, beside the interval.
#[test]
fn shiryaev_roberts_procedures() {
    for (shift, sides) in [
        (0.5, Sides::Upper),
        (0.5, Sides::Both),
        (1.0, Sides::Both),
        (2.0, Sides::Lower),
    ] {
        let made = |threshold| ShiryaevRoberts::new(shift, threshold, sides).unwrap();
        let asked = 500.0;
        let threshold = ShiryaevRobertsRunLength::threshold_for(shift, asked).unwrap();
        let more = if sides == Sides::Both { 0.02 } else { 0.0 };
        assert_counted("Shiryaev-Roberts", made(threshold), asked, more);
        // The safe threshold is safe, and no more so than it says.
        let (mean, half) = count(
            "safe",
            made(ShiryaevRoberts::safe_threshold(asked).unwrap()),
        );
        assert!(mean - half > asked, "{shift}: {mean} +- {half}");
        // The mean overshoot for small shifts; at the largest of these it is off by 0.02.
        let excess = (mean / asked).ln() - 0.583 * shift;
        assert!(
            excess.abs() < half / mean + 0.02,
            "{shift}: {mean} +- {half}"
        );
    }
    // By simulation as well.
    assert_calibrated("Shiryaev-Roberts of both sides", 500.0, |threshold| {
        ShiryaevRoberts::new(1.0, threshold, Sides::Both).unwrap()
    });
}

/// Wald's test that begins anew when it has decided for healthy.
#[test]
fn repeated_sprts() {
    struct Repeated(Sprt);
    impl Statistic for Repeated {
        fn take(&mut self, r: f64) {
            if self.0.decision() == SprtDecision::Healthy {
                self.0.reset();
            }
            self.0.step(r);
        }
        fn reset(&mut self) {
            self.0.reset();
        }
        fn value(&self) -> f64 {
            self.0.value()
        }
        fn threshold(&self) -> f64 {
            self.0.threshold()
        }
    }
    for (shift, accept) in [(1.0, -2.0), (-0.5, -1.0)] {
        let made = |reject| Repeated(Sprt::new(shift, accept, reject).unwrap());
        let (threshold, more) = calibrate(made(1e300), 500.0);
        assert_counted("SPRT", made(threshold), 500.0, more);
    }
}

#[test]
fn moving_averages() {
    for (window, sides) in [(5, Sides::Both), (25, Sides::Upper)] {
        assert_calibrated("moving average", 500.0, |threshold| {
            MovingAverage::new(window, threshold, sides).unwrap()
        });
    }
}

#[test]
fn windowed_chi_squares() {
    for window in [5, 25] {
        assert_calibrated("windowed chi-square", 500.0, |threshold| {
            WindowedChiSquare::new(window, threshold).unwrap()
        });
    }
}

#[test]
fn windowed_variances() {
    for (window, sides) in [(10, Sides::Upper), (25, Sides::Lower), (25, Sides::Both)] {
        assert_calibrated("windowed variance", 500.0, |threshold| {
            WindowedVariance::new(window, threshold, sides).unwrap()
        });
    }
}

#[test]
fn growing_windows() {
    let growth = Growth {
        shortest: 10,
        longest: 100,
    };
    for sides in SIDES {
        assert_calibrated("growing chi-square", 500.0, |threshold| {
            GrowingChiSquare::new(growth, threshold, sides).unwrap()
        });
        assert_calibrated("growing variance", 500.0, |threshold| {
            GrowingVariance::new(growth, threshold, sides).unwrap()
        });
    }
}

#[test]
fn ratios() {
    for (waveform, sizes, sides) in [
        (Waveform::Step, (0.25, 2.0), Sides::Both),
        (Waveform::Ramp, (1e-3, 1e-1), Sides::Both),
        (Waveform::Ramp, (1e-3, 1e-1), Sides::Lower),
    ] {
        assert_calibrated("GLR", 500.0, |threshold| {
            Glr::new(waveform, sizes, 64, threshold, sides).unwrap()
        });
    }
}

#[test]
fn whiteness() {
    for (window, lags) in [(25, 1), (50, 5)] {
        assert_calibrated("whiteness", 500.0, |threshold| {
            Whiteness::new(window, lags, threshold).unwrap()
        });
    }
}

/// Beside an input that steps up and down, to which a model that is a little wrong answers: with the
/// same inputs a fixed limit at the same level at rest alarms far more often.
#[test]
fn adaptive_thresholds() {
    /// The residual's answer to a unit step of the input, and its pole.
    const ANSWER: (f64, f64) = (0.5, 0.8);
    struct Beside {
        adaptive: AdaptiveThreshold,
        sample: usize,
        answer: f64,
        input: f64,
    }
    impl Statistic for Beside {
        fn take(&mut self, r: f64) {
            let input = if self.sample % 60 < 30 { 0.0 } else { 2.0 };
            let change = if self.sample == 0 {
                0.0
            } else {
                input - self.input
            };
            self.answer = ANSWER.1 * self.answer + ANSWER.0 * change;
            self.input = input;
            self.sample += 1;
            self.adaptive.step(&[input], r + self.answer).unwrap();
        }
        fn reset(&mut self) {
            self.adaptive.reset();
            (self.sample, self.answer) = (0, 0.0);
        }
        fn value(&self) -> f64 {
            self.adaptive.value()
        }
        fn threshold(&self) -> f64 {
            1.0
        }
    }
    let beside = |base: f64, gain: f64| Beside {
        adaptive: AdaptiveThreshold::new(base, &[gain], -1.0 / ANSWER.1.ln()).unwrap(),
        sample: 0,
        answer: 0.0,
        input: 0.0,
    };
    // The value is a ratio: what is calibrated is the factor on the base and on the gain.
    let (factor, more) = calibrate(beside(3.0, ANSWER.0), 500.0);
    let found = beside(3.0 * factor, ANSWER.0 * factor);
    assert_counted("adaptive threshold", found, 500.0, more);
    let (fixed, _) = count("fixed", beside(3.0 * factor, 0.0));
    assert!(fixed < 350.0, "{fixed}");
}

/// Beside inputs at rest, the base alone sets the time, as a fixed limit does.
#[test]
fn adaptive_thresholds_at_rest() {
    struct Still(AdaptiveThreshold);
    impl Statistic for Still {
        fn take(&mut self, r: f64) {
            self.0.step(&[7.0], r).unwrap();
        }
        fn reset(&mut self) {
            self.0.reset();
        }
        fn value(&self) -> f64 {
            self.0.value()
        }
        fn threshold(&self) -> f64 {
            1.0
        }
    }
    let base = ExceedanceRunLength::limit_for(1, Sides::Both, 500.0).unwrap();
    let still = Still(AdaptiveThreshold::new(base, &[1.0], 9.0).unwrap());
    assert_counted("adaptive threshold at rest", still, 500.0, 0.0);
}
