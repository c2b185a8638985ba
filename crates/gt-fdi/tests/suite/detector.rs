//! The online detector: broken samples, time, settling.

use gt_core::{Dataset, OperatingPoint, Signal};
use gt_fdi::design::{ResidualGenerator, ThresholdRule};
use gt_fdi::runtime::{Detector, ExceedanceRun, Persistence, StepError};
use nalgebra::DMatrix;
use proptest::prelude::*;

use crate::fixtures::{TS, bank, bank_of, canonical, limit_on, monic, noise};

const U: [f64; 2] = [10.0, -3.0];
const Y: [f64; 2] = [100.0, 100.0];

/// A detector that has settled at its operating point, and the time of its last sample.
fn settled() -> (Detector, usize, f64) {
    let bank = bank();
    let settle = bank.generators()[0].settle_samples();
    let mut detector = Detector::new(&bank);
    let mut t = 0.0;
    for k in 0..=settle {
        t = k as f64 * TS;
        let settling = k < settle;
        let verdict = detector.step(t, &U, &Y).unwrap();
        assert!(
            verdict
                .channels
                .iter()
                .all(|channel| channel.settling == settling),
            "{k}"
        );
    }
    (detector, settle, t)
}

#[test]
fn alarms_are_inhibited_while_settling() {
    let bank = bank();
    let settle = bank.generators()[0].settle_samples();
    let mut detector = Detector::new(&bank);
    assert_eq!(detector.inputs(), ["u0", "u1"]);
    assert_eq!(detector.outputs(), ["p", "q"]);
    // A bias that is there from the start: reported at once, judged from `settle` on.
    for k in 0..settle + 4 {
        let verdict = detector.step(k as f64 * TS, &U, &[200.0, 200.0]).unwrap();
        let channel = &verdict.channels[0];
        assert!(channel.residual.abs() > 3.0, "{k}: {}", channel.residual);
        let judged = (k + 1).saturating_sub(settle);
        assert_eq!(
            (channel.exceeds, channel.run_length),
            (judged > 0, judged),
            "{k}"
        );
        assert_eq!(
            (channel.alarm, channel.new_alarm),
            (judged >= 2, judged == 2),
            "{k}"
        );
        let first = (judged > 0).then_some(settle as f64 * TS);
        assert_eq!(channel.first_exceedance_s, first);
    }
}

/// Without its output a generator predicts and settles again; the others do not notice. At the
/// operating point the prediction is exact.
#[test]
fn a_missing_output_is_predicted_and_its_generator_settles_again() {
    for missing in [1, 3, 200] {
        let (mut detector, settle, mut t) = settled();
        for bad in [f64::NAN, f64::INFINITY].into_iter().cycle().take(missing) {
            t += TS;
            let verdict = detector.step(t, &U, &[bad, 100.0]).unwrap();
            assert!(verdict.channels[0].residual.is_nan() && verdict.channels[0].settling);
            assert!(verdict.channels[1].residual == 0.0 && !verdict.channels[1].settling);
        }
        for k in 0..=settle {
            t += TS;
            let verdict = detector.step(t, &U, &Y).unwrap();
            let channel = &verdict.channels[0];
            assert_eq!(
                (channel.residual, channel.settling),
                (0.0, k < settle),
                "{k}"
            );
        }
    }
}

/// One sample missing from a healthy record must not raise an alarm. Eight slow poles and an
/// observer at 0.7 make `r = eps / P` strongly coloured, so that the correction left out is an
/// error in the state of many times the limit.
#[test]
fn a_missing_sample_raises_no_false_alarm() {
    let slow = [0.98, 0.96, 0.94, 0.92, 0.9, 0.88, 0.86, 0.84];
    let (markov, direct) = (DMatrix::zeros(8, 2), DMatrix::zeros(1, 2));
    let model = canonical(&slow, markov, direct, "y");
    let point = OperatingPoint::zero(2, 1);
    let generator = ResidualGenerator::observer(model, point, &[0.7; 8]).unwrap();
    let settle = generator.settle_samples();
    // The model's own ARX noise: A(z) y = eps.
    let a = monic(&slow);
    let eps = noise(11, 4000);
    let mut y: Vec<f64> = Vec::new();
    for (t, eps) in eps.iter().enumerate() {
        let past = (1..=8.min(t)).map(|lag| a[8 - lag] * y[t - lag]);
        y.push(eps - past.sum::<f64>());
    }
    let u = DMatrix::zeros(2, y.len());
    let (inputs, outputs) = (Signal::named(&["u0", "u1"]), Signal::named(&["y"]));
    let record = DMatrix::from_row_slice(1, y.len(), &y);
    let healthy = Dataset::new(inputs, outputs, u, record, TS).unwrap();
    let rule = ThresholdRule::Margin {
        factor: 1.2,
        consecutive: 1,
    };
    let test = limit_on(&generator, &[healthy], rule).unwrap();
    let bank = bank_of("coloured", vec![(generator, test)]).unwrap();
    for missing in (settle + 100..3900).step_by(37) {
        let mut detector = Detector::new(&bank);
        for (k, y) in y.iter().enumerate() {
            let y = if k == missing { f64::NAN } else { *y };
            let verdict = detector.step(k as f64 * TS, &[0.0, 0.0], &[y]).unwrap();
            assert!(
                !verdict.channels[0].alarm,
                "sample {missing} missing: alarm at {k}"
            );
        }
    }
}

#[test]
fn prediction_is_that_of_the_model() {
    let bank = bank();
    let model = bank.generators()[0].model().clone();
    let mut detector = Detector::new(&bank);
    let draws = noise(5, 40);
    let mut x = nalgebra::DVector::zeros(2);
    for k in 0..20 {
        let du = nalgebra::DVector::from_column_slice(&draws[2 * k..2 * k + 2]);
        let expected = -(model.c() * &x + model.d() * &du)[0];
        let y = if k == 19 { 100.0 } else { f64::NAN };
        let u = [U[0] + du[0], U[1] + du[1]];
        let verdict = detector.step(k as f64 * TS, &u, &[y, y]).unwrap();
        if k == 19 {
            // Inputs of 10 are rounded to 2e-15.
            assert!((verdict.channels[0].residual - expected).abs() < 1e-13);
        }
        x = model.a() * x + model.b() * du;
    }
}

/// A missing sample ends the run above the limit, and what follows is settling, not an alarm.
#[test]
fn a_missing_output_ends_the_run() {
    let (mut detector, settle, mut t) = settled();
    let mut step = |y: f64| {
        t += TS;
        let channel = detector.step(t, &U, &[y, 100.0]).unwrap().channels[0];
        (channel.run_length, channel.alarm, channel.new_alarm)
    };
    assert_eq!(step(500.0), (1, false, false));
    assert_eq!(step(f64::NAN), (0, false, false));
    for _ in 0..settle {
        assert_eq!(step(500.0), (0, false, false));
    }
    assert_eq!(step(900.0), (1, false, false));
    assert_eq!(step(1500.0), (2, true, true));
    assert_eq!(step(f64::NAN), (0, false, false));
}

#[test]
fn a_missing_input_restarts_its_generators() {
    let (mut detector, settle, mut t) = settled();
    t += TS;
    let verdict = detector
        .step(t, &[10.0, f64::NAN], &[500.0, 500.0])
        .unwrap();
    assert!(
        verdict
            .channels
            .iter()
            .all(|channel| channel.residual.is_nan() && channel.settling)
    );
    for k in 0..=settle {
        t += TS;
        let verdict = detector.step(t, &U, &Y).unwrap();
        for channel in &verdict.channels {
            assert_eq!(
                (channel.residual, channel.settling),
                (0.0, k < settle),
                "{k}"
            );
        }
    }
}

#[test]
fn a_gap_in_time_starts_afresh() {
    let (mut detector, _, t) = settled();
    let verdict = detector.step(t + 1.4 * TS, &U, &[500.0, 500.0]).unwrap();
    assert!(!verdict.gap && verdict.channels[0].run_length == 1);
    let verdict = detector.step(t + 3.0 * TS, &U, &[500.0, 100.0]).unwrap();
    assert!(verdict.gap && verdict.channels.iter().all(|channel| channel.settling));
    // Afresh: the output's deviation is the residual.
    assert_eq!(
        (verdict.channels[0].residual, verdict.channels[1].residual),
        (400.0, 0.0)
    );
}

/// The largest doubles would overflow the state: they are judged, and the next good sample finds
/// the state it would have found without them, here that of the operating point.
#[test]
fn an_absurd_output_is_judged_and_kept_out_of_the_state() {
    let (mut detector, _, mut t) = settled();
    let mut step = |y: f64| {
        t += TS;
        detector.step(t, &U, &[y, 100.0]).unwrap().channels[0]
    };
    let first = step(f64::MAX);
    assert!(
        first.residual == f64::MAX && first.exceeds && !first.alarm,
        "{first:?}"
    );
    let second = step(-f64::MAX);
    assert!(second.new_alarm && !second.settling, "{second:?}");
    let third = step(100.0);
    assert!(third.residual == 0.0 && !third.settling, "{third:?}");
}

/// Inputs that overflow the prediction restart the generators: a verdict, not an infinity.
#[test]
fn overflow_by_inputs_restarts() {
    let (mut detector, _, mut t) = settled();
    let mut step = |u: f64| {
        t += TS;
        detector.step(t, &[u, u], &Y).unwrap().channels[0]
    };
    // D is 0.5, the rows of B sum to 0.2 and 0.4: the residual -0.5e308 is finite, and so is the
    // state; the next residual, from a state and an input of the same sign, is not.
    assert!(step(f64::MAX).residual.is_finite());
    let restarted = (0..20)
        .map(|_| step(f64::MAX))
        .any(|channel| channel.settling);
    assert!(restarted, "1.8e308 must have been reached");
}

#[test]
fn reset_forgets_everything() {
    let (mut detector, _, mut t) = settled();
    for _ in 0..5 {
        t += TS;
        detector.step(t, &[12.0, 1.0], &[500.0, -500.0]).unwrap();
    }
    detector.reset();
    let mut fresh = Detector::new(&bank());
    let draws = noise(3, 400);
    for k in 0..100 {
        let (u, y) = (
            [draws[4 * k], draws[4 * k + 1]],
            [draws[4 * k + 2], draws[4 * k + 3]],
        );
        // An earlier time than before the reset is welcome.
        let time = k as f64 * TS - 50.0;
        // As text, because NaN differs from itself.
        assert_eq!(
            format!("{:?}", detector.step(time, &u, &y).unwrap()),
            format!("{:?}", fresh.step(time, &u, &y).unwrap())
        );
    }
}

/// Refused samples are named, and leave the detector as it was.
#[test]
fn refused_samples_leave_no_trace() {
    let (mut detector, _, t) = settled();
    let mut untouched = detector.clone();
    let later = t + TS;
    let input = StepError::InputCount {
        expected: 2,
        found: 3,
    };
    assert_eq!(detector.step(later, &[1.0; 3], &Y), Err(input));
    let output = StepError::OutputCount {
        expected: 2,
        found: 1,
    };
    assert_eq!(detector.step(later, &U, &[1.0]), Err(output));
    let infinite = StepError::TimeNotFinite {
        found_s: f64::INFINITY,
    };
    assert_eq!(detector.step(f64::INFINITY, &U, &Y), Err(infinite));
    assert!(matches!(
        detector.step(f64::NAN, &U, &Y),
        Err(StepError::TimeNotFinite { .. })
    ));
    for found_s in [t, t - 1.0, t + 0.4 * TS] {
        let error = StepError::TimeNotAdvancing {
            previous_s: t,
            found_s,
            sample_time_s: TS,
        };
        assert_eq!(detector.step(found_s, &U, &[500.0, 500.0]), Err(error));
    }
    let sample = [101.0, 99.0];
    assert_eq!(
        detector.step(later, &U, &sample),
        untouched.step(later, &U, &sample)
    );
}

/// By hand, limit 1, two samples in a row make an alarm and three within the limit end it.
#[test]
fn a_run_knows_its_first_sample_and_its_alarm() {
    let wait = Persistence {
        consecutive: 2,
        release: 3,
    };
    let mut run = ExceedanceRun::default();
    let mut step = |time_s, value| {
        let raised = run.update(time_s, value, 1.0, wait);
        (raised, run.length(), run.alarm(), run.first_exceedance_s())
    };
    assert_eq!(step(1.0, 0.5), (false, 0, false, None));
    assert_eq!(step(2.0, 1.5), (false, 1, false, Some(2.0)));
    assert_eq!(step(3.0, 9.0), (true, 2, true, Some(2.0)));
    assert_eq!(step(4.0, 1.0), (false, 0, true, None));
    assert_eq!(step(5.0, 0.0), (false, 0, true, None));
    // Above again before the third: the same alarm.
    assert_eq!(step(6.0, 2.0), (false, 1, true, Some(6.0)));
    assert_eq!(step(7.0, 2.0), (false, 2, true, Some(6.0)));
    assert_eq!(step(8.0, f64::NAN), (false, 0, true, None));
    assert_eq!(step(9.0, 0.0), (false, 0, true, None));
    assert_eq!(step(10.0, 0.0), (false, 0, false, None));
    assert_eq!(step(11.0, 2.0), (false, 1, false, Some(11.0)));
    assert_eq!(step(12.0, 2.0), (true, 2, true, Some(11.0)));
}

fn any_bits() -> impl Strategy<Value = f64> {
    any::<u64>().prop_map(f64::from_bits)
}

fn two_of_any_bits() -> impl Strategy<Value = [f64; 2]> {
    [any_bits(), any_bits()]
}

proptest! {
    /// Whatever the bits of time, inputs and outputs: no panic, a verdict that is consistent in
    /// itself, and after the storm the detector works as a fresh one does.
    #[test]
    fn prop_no_bits_break_the_detector(
        samples in prop::collection::vec((any_bits(), two_of_any_bits(), two_of_any_bits()), 1..60),
        orderly in any::<bool>(),
    ) {
        let bank = bank();
        let settle = bank.generators()[0].settle_samples();
        let mut detector = Detector::new(&bank);
        let mut last = 0.0;
        for (k, (time, u, y)) in samples.iter().enumerate() {
            let time = if orderly { k as f64 * TS } else { *time };
            if let Ok(verdict) = detector.step(time, u, y) {
                last = time;
                for channel in &verdict.channels {
                    prop_assert!(channel.residual.is_nan() || channel.residual.is_finite());
                    prop_assert_eq!(channel.exceeds, channel.run_length > 0);
                    prop_assert_eq!(channel.exceeds, channel.first_exceedance_s.is_some());
                    prop_assert_eq!(channel.alarm, channel.run_length >= 2);
                    prop_assert_eq!(channel.new_alarm, channel.run_length == 2);
                    prop_assert!(!(channel.settling && channel.exceeds));
                }
            }
        }
        // A missing input restarts the generators, so what follows is a fresh start.
        if orderly {
            detector.step(last + TS, &[f64::NAN; 2], &Y).unwrap();
            for k in 0..=settle {
                let time = last + (k + 2) as f64 * TS;
                let verdict = detector.step(time, &U, &Y).unwrap();
                for channel in &verdict.channels {
                    prop_assert_eq!((channel.residual, channel.settling), (0.0, k < settle));
                }
            }
        }
    }
}
