//! Simulated run lengths against exact ones.

use gt_fdi::FdiError;
use gt_fdi::design::{
    CusumRunLength, ExceedanceRunLength, MIN_ALARMS, SimulatedRuns, mean_delay_bound,
};
use gt_fdi::runtime::{Cusum, Glr, MovingAverage, Sides, Statistic, Waveform, WindowedChiSquare};
use rand::RngExt;
use rand_distr::StandardNormal;
use statrs::distribution::{ChiSquared, ContinuousCDF};

use crate::fixtures::rng;

/// Normal residuals, one generator a path.
pub fn white(seed: u64) -> impl FnMut(usize) -> Box<dyn FnMut() -> f64> {
    move |path| {
        let mut rng = rng(seed + path as u64);
        Box::new(move || rng.sample(StandardNormal))
    }
}

/// The exact run length lies within the 99 % interval of the simulated one, for both sides and
/// one, with every path run to its alarm and with nine in ten cut before.
#[test]
fn simulated_cusums_have_the_exact_run_length() {
    for (allowance, threshold, sides) in [
        (0.5, 2.5, Sides::Both),
        (0.5, 3.0, Sides::Upper),
        (0.25, 4.0, Sides::Both),
    ] {
        let chart = CusumRunLength::new(allowance, threshold, sides).unwrap();
        let exact = chart.samples(0.0).unwrap();
        assert!((30.0..200.0).contains(&exact), "{exact}");
        let mut cusum = Cusum::new(allowance, threshold, sides).unwrap();
        let runs = SimulatedRuns::run(&mut cusum, 4000, 3000, white(1_000_000)).unwrap();
        let found = runs.run_length(threshold).unwrap();
        // 3000 samples are 15 mean run lengths: practically every path alarms.
        assert!(found.alarms >= 3999, "{found:?}");
        assert!(
            found.low < exact && exact < found.high,
            "{exact}: {found:?}"
        );
        // The interval is narrow enough to tell: 2.58 / sqrt(4000) = 4.1 %.
        assert!(found.high / found.low < 1.09);
        // Another threshold, as near as a tenth, is told apart.
        let near = CusumRunLength::new(allowance, threshold + 0.1, sides).unwrap();
        assert!(near.samples(0.0).unwrap() > found.high, "{found:?}");
    }
}

/// Paths made one by one are those made together.
#[test]
fn paths_of_several_runs_are_joined() {
    let mut cusum = Cusum::new(0.5, 2.5, Sides::Both).unwrap();
    let whole = SimulatedRuns::run(&mut cusum, 5, 100, white(7_000_000)).unwrap();
    let mut noise = white(7_000_000);
    let mut joined = SimulatedRuns::run(&mut cusum, 1, 100, |_| noise(0)).unwrap();
    for path in 1..5 {
        let own = SimulatedRuns::run(&mut cusum, 1, 100, |_| noise(path)).unwrap();
        joined.extend(own).unwrap();
    }
    assert_eq!(joined, whole);
    let short = SimulatedRuns::run(&mut cusum, 1, 99, |_| noise(0)).unwrap();
    let error = joined.extend(short).unwrap_err();
    assert_eq!((error.expected, error.found), (100, 99));
    assert_eq!(joined, whole);
}

/// Independent samples have a constant hazard, so that cutting paths short does no harm.
#[test]
fn paths_cut_short_count_in_full() {
    let limit = 2.5;
    let mut single = MovingAverage::new(1, limit, Sides::Both).unwrap();
    let runs = SimulatedRuns::run(&mut single, 50_000, 20, white(8_000_000)).unwrap();
    let found = runs.run_length(limit).unwrap();
    let rule = ExceedanceRunLength::new(limit, 1, Sides::Both).unwrap();
    let exact = rule.samples(0.0).unwrap();
    assert!(found.alarms < 12_500, "{found:?}");
    assert!(
        found.low < exact && exact < found.high,
        "{exact}: {found:?}"
    );
}

/// A window of one is a limit on the square, whose tail is known.
#[test]
fn a_chi_square_window_of_one_has_a_closed_form() {
    let law = ChiSquared::new(1.0).unwrap();
    let threshold = law.inverse_cdf(0.99);
    let mut statistic = WindowedChiSquare::new(1, threshold).unwrap();
    let runs = SimulatedRuns::run(&mut statistic, 4000, 1500, white(9_000_000)).unwrap();
    let found = runs.run_length(threshold).unwrap();
    assert!(found.low < 100.0 && 100.0 < found.high, "{found:?}");
}

/// A threshold calibrated on some paths has the run length asked for on others, counted alarm by
/// alarm: within the two 99 % intervals together.
#[test]
fn calibrated_thresholds_of_ratios_hold_on_fresh_paths() {
    let asked = 300.0;
    for (waveform, sizes) in [
        (Waveform::Ramp, (1e-3, 1e-1)),
        (Waveform::Step, (0.25, 2.0)),
    ] {
        let mut glr = Glr::new(waveform, sizes, 64, 1.0, Sides::Both).unwrap();
        let calibration = SimulatedRuns::run(&mut glr, 2000, 4000, white(20_000_000))
            .unwrap()
            .threshold_for(asked)
            .unwrap();
        // The estimate jumps by one path in the alarms of 2000.
        assert!(
            (calibration.samples / asked - 1.0).abs() < 5e-3,
            "{calibration:?}"
        );
        let mut glr = Glr::new(waveform, sizes, 64, calibration.threshold, Sides::Both).unwrap();
        let (mut total, mut alarms) = (0_usize, 0_usize);
        let mut noise = white(30_000_000);
        for path in 0..2000 {
            let mut residual = noise(path);
            glr.reset();
            total += 1;
            while !glr.step(residual()).alarm {
                total += 1;
            }
            alarms += 1;
        }
        let fresh = total as f64 / alarms as f64;
        // ln of the ratio of two means of 2000: 2.58 x sqrt(2 / 2000) = 8.1 %.
        let half_width = (calibration.high / calibration.samples).ln() * 2.0_f64.sqrt();
        assert!(half_width < 0.085);
        assert!(
            (fresh / asked).ln().abs() < half_width,
            "{fresh}: {calibration:?}"
        );
    }
}

/// By hand: two kinds of path, thresholds between and at their records.
#[test]
fn run_lengths_are_counted_from_the_records() {
    let paths = |path: usize| {
        let samples = if path.is_multiple_of(2) {
            [1.0, 0.5, 3.0, 2.0]
        } else {
            [0.5, 2.0, 1.0, 0.0]
        };
        let mut samples = samples.into_iter();
        move || samples.next().unwrap()
    };
    let mut single = MovingAverage::new(1, 1.0, Sides::Upper).unwrap();
    let runs = SimulatedRuns::run(&mut single, 40, 4, paths).unwrap();
    let at = |threshold| runs.run_length(threshold).map(|r| (r.samples, r.alarms));
    assert_eq!(at(0.75), Ok((1.5, 40)));
    assert_eq!(at(1.0), Ok((2.5, 40)));
    // The odd paths are cut at 4 samples.
    assert_eq!(at(2.0), Ok((7.0, 20)));
    let (needed, found) = (MIN_ALARMS, 0);
    assert_eq!(at(3.0), Err(FdiError::TooFewAlarms { needed, found }));
    assert_eq!(runs.threshold_for(2.0).map(|r| r.threshold), Ok(1.0));
    assert_eq!(runs.threshold_for(7.0).map(|r| r.threshold), Ok(2.0));
    assert_eq!(
        runs.threshold_for(7.5),
        Err(FdiError::TooFewAlarms { needed, found })
    );
    let error = |option| {
        let (expected, found) = ("at least 1", 0.0);
        Some(FdiError::Option {
            option,
            expected,
            found,
        })
    };
    let none = SimulatedRuns::run(&mut single, 0, 4, paths);
    assert_eq!(none.err(), error("paths"));
    let none = SimulatedRuns::run(&mut single, 4, 0, paths);
    assert_eq!(none.err(), error("samples"));
}

/// The specification's table of mean delays in samples to the alarm on a ramp of 1e-3 standard
/// deviations a sample: ratios with declared ranges of slopes and the thresholds given there, after
/// a healthy start that fills the windows.
#[test]
fn regress_delays_of_ramp_ratios() {
    const PATHS: usize = 600;
    let slope = 1e-3;
    for (sizes, threshold, expected) in [((1e-4, 1e-3), 8.94, 361.0), ((1e-4, 1e-1), 11.81, 391.0)]
    {
        let mut glr = Glr::new(Waveform::Ramp, sizes, 4096, threshold, Sides::Upper).unwrap();
        let mut noise = white(40_000_000);
        let mut delays = Vec::new();
        for path in 0..PATHS {
            let mut residual = noise(path);
            glr.reset();
            let false_alarm = (0..5000).any(|_| glr.step(residual()).alarm);
            if !false_alarm {
                let mut delay = 1.0;
                while !glr.step(residual() + slope * delay).alarm {
                    delay += 1.0;
                }
                delays.push(delay);
            }
        }
        // At most 1 in 100 paths: 5000 samples of the 1.08e6 between false alarms.
        assert!(delays.len() > PATHS * 98 / 100, "{}", delays.len());
        let count = delays.len() as f64;
        let mean = delays.iter().sum::<f64>() / count;
        let variance = delays.iter().map(|d| (d - mean) * (d - mean)).sum::<f64>() / count;
        // Standard errors of both: here, and the table's 0.7 %.
        let error = (variance / count + (7e-3 * expected) * (7e-3 * expected)).sqrt();
        assert!(error < 0.011 * expected, "{error}");
        assert!((mean - expected).abs() < 2.58 * error, "{mean} {error}");
        // No detector is faster than the bound at that mean time between false alarms.
        assert!(mean > mean_delay_bound(Waveform::Ramp, slope, 1.08e6).unwrap());
    }
}
