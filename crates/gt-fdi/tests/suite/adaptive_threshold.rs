//! A limit that follows the inputs, against its sum and the bound that it stands for.

use gt_fdi::runtime::{AdaptiveThreshold, StatisticError};
use proptest::prelude::*;

use crate::fixtures::noise;

/// Two inputs and a residual, some of them missing.
fn samples(len: usize) -> impl Strategy<Value = Vec<([f64; 2], f64)>> {
    let number = || {
        prop_oneof![
            30 => -10.0..10.0_f64,
            1 => Just(f64::NAN),
            1 => Just(f64::INFINITY),
        ]
    };
    prop::collection::vec(([number(), number()], number()), 1..len)
}

proptest! {
    /// `limit = base + sum_i q^i sum_j g_j |change of u_j i samples ago|` over the valid samples.
    #[test]
    fn prop_the_limit_is_its_batch_definition(
        samples in samples(100), base in 0.1..5.0_f64, gains in prop::array::uniform2(0.0..3.0_f64),
        time_constant in 0.2..50.0_f64,
    ) {
        let mut threshold = AdaptiveThreshold::new(base, &gains, time_constant).unwrap();
        let mut valid: Vec<[f64; 2]> = Vec::new();
        let mut value = 0.0;
        for (u, r) in samples {
            let decision = threshold.step(&u, r).unwrap();
            let missing = !(r.is_finite() && u[0].is_finite() && u[1].is_finite());
            assert_eq!(decision.missing, missing);
            if !missing {
                valid.push(u);
                let mut limit = base;
                for (ago, pair) in valid.windows(2).rev().enumerate() {
                    let weight = (-(ago as f64) / time_constant).exp();
                    for j in 0..2 {
                        limit += weight * gains[j] * (pair[1][j] - pair[0][j]).abs();
                    }
                }
                let found = threshold.limit();
                assert!((found - limit).abs() < 1e-11 * limit, "{found} {limit}");
                value = r.abs() / found;
            }
            assert_eq!(decision.value, value);
            assert_eq!(decision.value, threshold.value());
            assert_eq!(decision.alarm, value > 1.0);
        }
    }

    /// What the limit is for: a model whose gain and time constant are both wrong makes a residual
    /// that stays within the allowance of its step response, whatever the inputs do.
    #[test]
    fn prop_model_errors_stay_within_the_limit(
        u in prop::collection::vec(-5.0..5.0_f64, 2..200),
        gain_error in -0.5..0.5_f64, pole in 0.0..0.95_f64,
    ) {
        // The residual of a unit step: `gain_error pole^k`, a high pass of what is modelled wrong.
        let time_constant = -1.0 / pole.max(0.1).ln();
        let gains = [gain_error.abs()];
        let mut threshold = AdaptiveThreshold::new(1e-9, &gains, time_constant).unwrap();
        let mut residual = 0.0;
        let mut before = u[0];
        for u in u {
            residual = pole * residual + gain_error * (u - before);
            before = u;
            let decision = threshold.step(&[u], residual).unwrap();
            prop_assert!(!decision.alarm, "{}", decision.value);
        }
    }
}

#[test]
fn limits_by_hand() {
    // q = 1/2.
    let time_constant = 1.0 / 2.0_f64.ln();
    let mut threshold = AdaptiveThreshold::new(2.0, &[1.0, 0.5], time_constant).unwrap();
    assert_eq!(threshold.limit(), 2.0);
    let mut limit = |u: [f64; 2], r| {
        let decision = threshold.step(&u, r).unwrap();
        (threshold.limit(), decision.value, decision.alarm)
    };
    let near = |found: (f64, f64, bool), expected: (f64, f64, bool)| {
        assert!((found.0 - expected.0).abs() < 1e-14, "{found:?}");
        assert!((found.1 - expected.1).abs() < 1e-14, "{found:?}");
        assert_eq!(found.2, expected.2);
    };
    near(limit([10.0, 7.0], 3.0), (2.0, 1.5, true));
    near(limit([14.0, 7.0], 3.0), (6.0, 0.5, false));
    near(limit([14.0, 3.0], -3.0), (6.0, 0.5, false));
    // Missing: nothing changes. The change over the gap counts when it is seen.
    near(limit([14.0, f64::NAN], 9.0), (6.0, 0.5, false));
    near(limit([20.0, 3.0], f64::NAN), (6.0, 0.5, false));
    near(limit([15.0, 3.0], 5.0), (5.0, 1.0, false));
    near(limit([15.0, 3.0], 5.25), (3.5, 1.5, true));
    threshold.reset();
    assert_eq!((threshold.limit(), threshold.value()), (2.0, 0.0));
    // At rest again, wherever the inputs are.
    threshold.step(&[-50.0, 80.0], 1.0).unwrap();
    assert_eq!(threshold.limit(), 2.0);
    // Without inputs it is a fixed limit.
    let mut fixed = AdaptiveThreshold::new(2.0, &[], 5.0).unwrap();
    assert_eq!(fixed.step(&[], 3.0).unwrap().value, 1.5);
}

/// The largest doubles neither overflow nor stay.
#[test]
fn huge_inputs_are_survived() {
    let mut threshold = AdaptiveThreshold::new(1e-300, &[f64::MAX, 1.0], 2.0).unwrap();
    for k in 0..100 {
        let u = [f64::MAX, -f64::MAX, 0.0][k % 3];
        let value = threshold.step(&[u, -u], f64::MAX).unwrap().value;
        assert!(value.is_finite() && threshold.limit().is_finite());
    }
    for _ in 0..3000 {
        threshold.step(&[0.0, 0.0], 0.0).unwrap();
    }
    assert_eq!(threshold.limit(), 1e-300);
}

#[test]
fn saved_limits_resume_bit_for_bit() {
    let changes = noise(21, 400);
    let mut through = AdaptiveThreshold::new(1.5, &[0.3, 0.7], 7.0).unwrap();
    let mut resumed = through.clone();
    for (k, pair) in changes.chunks(2).enumerate() {
        if k % 17 == 0 {
            let text = serde_json::to_string(&resumed).unwrap();
            resumed = serde_json::from_str(&text).unwrap();
            assert_eq!(resumed, through);
        }
        if k == 100 {
            through.reset();
            resumed.reset();
        }
        let u = [pair[0], if k % 31 == 30 { f64::NAN } else { pair[1] }];
        let (found, expected) = (resumed.step(&u, pair[0]), through.step(&u, pair[0]));
        assert_eq!(found, expected);
        assert_eq!(resumed.limit().to_bits(), through.limit().to_bits());
    }
    assert_eq!(resumed, through);
}

#[test]
fn bad_limits_and_states_are_refused() {
    let error = |option, expected, found| {
        Some(StatisticError::Option {
            option,
            expected,
            found,
        })
    };
    let positive = "a positive finite number";
    for found in [0.0, -1.0, f64::INFINITY] {
        let made = AdaptiveThreshold::new(found, &[1.0], 5.0);
        assert_eq!(made.err(), error("base", positive, found));
        let made = AdaptiveThreshold::new(1.0, &[1.0], found);
        assert_eq!(made.err(), error("time_constant", positive, found));
    }
    for found in [-1.0, f64::INFINITY] {
        let made = AdaptiveThreshold::new(1.0, &[0.0, found], 5.0);
        assert_eq!(
            made.err(),
            error("gains", "finite numbers not below 0", found)
        );
    }
    let mut threshold = AdaptiveThreshold::new(1.0, &[1.0, 2.0], 5.0).unwrap();
    let (expected, found) = (2, 1);
    let error = StatisticError::Inputs { expected, found };
    let before = threshold.clone();
    assert_eq!(threshold.step(&[1.0], 3.0), Err(error));
    assert_eq!(threshold, before);

    threshold.step(&[3.0, 4.0], 0.5).unwrap();
    let text = serde_json::to_string(&threshold).unwrap();
    for (from, to, why) in [
        (r#""base":1.0"#, r#""base":0.0"#, "option `base`: expected"),
        (
            r#""inputs":[3.0,4.0]"#,
            r#""inputs":[3.0]"#,
            "inputs: expected 2 numbers, found 1",
        ),
        (
            r#""inputs":[3.0,4.0]"#,
            r#""inputs":null"#,
            "value: expected a number from 0 to 0",
        ),
        (
            r#""allowance":0.0"#,
            r#""allowance":-1.0"#,
            "allowance: expected a number from 0",
        ),
        (
            r#""value":0.5"#,
            r#""value":-0.5"#,
            "state, value: expected",
        ),
        (r#""gains""#, r#""gain""#, "unknown field `gain`"),
    ] {
        assert!(text.contains(from), "{text}");
        let broken = text.replacen(from, to, 1);
        let error = serde_json::from_str::<AdaptiveThreshold>(&broken);
        let error = error.err().unwrap().to_string();
        assert!(error.contains(why), "{error}");
    }
}
