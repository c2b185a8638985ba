//! Detectors that are saved and resumed, and statistics fed with anything.

use gt_core::{Dataset, Signal};
use gt_fdi::design::{Bank, ResidualGenerator, ResidualTest, StatisticKind, ThresholdRule};
use gt_fdi::runtime::{Detector, DetectorState, ResumeError, Waveform};
use nalgebra::DMatrix;
use proptest::prelude::*;

use crate::fixtures::{TS, bank, noise, plain_generator};

fn healthy(seed: u64) -> Dataset {
    const LEN: usize = 3000;
    let u = DMatrix::from_fn(2, LEN, |row, k| {
        [10.0, -3.0][row] + noise(seed + row as u64, LEN)[k]
    });
    let y = DMatrix::from_fn(2, LEN, |row, k| {
        100.0 + noise(seed + 2 + row as u64, LEN)[k]
    });
    let (inputs, outputs) = (Signal::named(&["u0", "u1"]), Signal::named(&["p", "q"]));
    Dataset::new(inputs, outputs, u, y, TS).unwrap()
}

/// Every statistic on two outputs, and a joint one.
fn all_statistics() -> Bank {
    let generators: Vec<ResidualGenerator> = ["p", "q"].map(plain_generator).to_vec();
    let kinds = [
        ("modulus", StatisticKind::Modulus, 0..1),
        ("cusum", StatisticKind::Cusum { allowance: 0.5 }, 0..1),
        (
            "glr",
            StatisticKind::Glr {
                waveform: Waveform::Ramp,
                smallest: 0.001,
                largest: 0.1,
                longest: 64,
            },
            1..2,
        ),
        ("average", StatisticKind::MovingAverage { window: 20 }, 1..2),
        ("squares", StatisticKind::ChiSquare { window: 10 }, 0..2),
        (
            "roberts",
            StatisticKind::ShiryaevRoberts { shift: 1.0 },
            0..1,
        ),
        ("variance", StatisticKind::Variance { window: 30 }, 0..1),
        (
            "whiteness",
            StatisticKind::Whiteness {
                window: 100,
                lags: 4,
            },
            1..2,
        ),
    ];
    let records = [healthy(1), healthy(50)];
    let tests = kinds.map(|(name, kind, own)| {
        let group: Vec<&ResidualGenerator> = generators[own].iter().collect();
        let rule = ThresholdRule::Exceedance {
            share: 0.05,
            consecutive: 2,
        };
        ResidualTest::calibrate(name, &group, &records, kind, rule).unwrap()
    });
    Bank::new("all", generators, tests.to_vec()).unwrap()
}

fn step(detector: &mut Detector, k: usize) -> String {
    let draws = noise(k as u64, 4);
    let bias = if k % 300 > 200 { 4.0 } else { 0.0 };
    let y = [
        100.0 + draws[0] + bias,
        if k.is_multiple_of(117) {
            f64::NAN
        } else {
            100.0 + draws[1]
        },
    ];
    let u = [10.0 + draws[2], -3.0 + draws[3]];
    format!("{:?}", detector.step(k as f64 * TS, &u, &y).unwrap())
}

/// Saved at any sample, through JSON, the rest is the same to the last bit (text of doubles is
/// exact).
#[test]
fn a_resumed_detector_goes_on_bit_for_bit() {
    let bank = all_statistics();
    for stop in [0, 1, 37, 117, 118, 250, 600] {
        let mut detector = Detector::new(&bank);
        for k in 0..stop {
            step(&mut detector, k);
        }
        let json = serde_json::to_string(&detector.state()).unwrap();
        let state: DetectorState = serde_json::from_str(&json).unwrap();
        let mut resumed = Detector::new(&bank);
        // It has seen other samples before.
        for k in 1000..1100 {
            step(&mut resumed, k);
        }
        resumed.resume(&state).unwrap();
        for k in stop..stop + 400 {
            assert_eq!(step(&mut detector, k), step(&mut resumed, k), "{stop} {k}");
        }
    }
}

#[test]
fn a_state_of_another_bank_is_refused() {
    let mut detector = Detector::new(&all_statistics());
    let other = Detector::new(&bank()).state();
    let untouched = detector.state();
    assert_eq!(detector.resume(&other), Err(ResumeError::Bank));
    // The same tests with one limit that differs in its last bit are another bank.
    let mut json = serde_json::to_value(all_statistics()).unwrap();
    let limit = json["tests"][1]["threshold"]["limit"].as_f64().unwrap();
    json["tests"][1]["threshold"]["limit"] = limit.next_up().into();
    let near: Bank = serde_json::from_value(json).unwrap();
    let near = Detector::new(&near).state();
    assert_eq!(detector.resume(&near), Err(ResumeError::Bank));
    let json = serde_json::to_value(&untouched).unwrap();
    let mut refused = |pointer: &str, value: serde_json::Value| {
        let mut changed = json.clone();
        *changed.pointer_mut(pointer).unwrap() = value;
        let state: DetectorState = serde_json::from_value(changed).unwrap();
        detector.resume(&state).unwrap_err()
    };
    assert_eq!(
        refused("/generators/1", serde_json::json!([0.0])),
        ResumeError::Generator { index: 1 }
    );
    assert_eq!(
        refused("/channels/0/settling_left", serde_json::json!(1_000_000)),
        ResumeError::Test { index: 0 }
    );
    assert_eq!(
        refused("/channels/1/past", serde_json::json!(vec![0.0; 77])),
        ResumeError::Test { index: 1 }
    );
    let cusum = json["channels"][1]["evaluator"].clone();
    assert_eq!(
        refused("/channels/2/evaluator", cusum),
        ResumeError::Test { index: 2 }
    );
    let first = |pointer: &str| untouched_json(&untouched, pointer);
    let allowance = serde_json::json!(0.25);
    assert_eq!(
        refused("/channels/1/evaluator/allowance", allowance),
        ResumeError::Test { index: 1 }
    );
    assert!(first("/channels/1/evaluator/allowance") == 0.5);
    assert_eq!(
        refused("/generators", serde_json::json!([[0.0]])),
        ResumeError::Count {
            what: "generators",
            expected: 2,
            found: 1
        }
    );
    assert_eq!(detector.state(), untouched);
}

fn untouched_json(state: &DetectorState, pointer: &str) -> f64 {
    let json = serde_json::to_value(state).unwrap();
    json.pointer(pointer).unwrap().as_f64().unwrap()
}

proptest! {
    /// Any bits, in any order: the detector refuses or answers, and does not panic.
    #[test]
    fn prop_no_bits_make_statistics_panic(
        samples in proptest::collection::vec(any::<[u64; 5]>(), 1..200),
    ) {
        let mut detector = Detector::new(&all_statistics_once());
        for (k, bits) in samples.iter().enumerate() {
            let [t, a, b, c, d] = bits.map(f64::from_bits);
            let time = if t.is_nan() { k as f64 * TS } else { t };
            if let Ok(verdict) = detector.step(time, &[a, b], &[c, d]) {
                for channel in &verdict.channels {
                    prop_assert!(!channel.exceeds || channel.statistic > 0.0);
                }
            }
            let verdict = detector.step(1e9 + k as f64 * TS, &[a, b], &[c, d]);
            prop_assert!(verdict.is_ok() || k > 0 || t > 1e8);
        }
        detector.reset();
        for k in 0..400_u32 {
            let verdict = detector.step(f64::from(k) * TS, &[10.0, -3.0], &[100.0, 100.0]).unwrap();
            if k == 399 {
                prop_assert!(verdict.channels.iter().all(|channel| !channel.settling));
            }
        }
    }
}

/// The bank, made once.
fn all_statistics_once() -> Bank {
    static BANK: std::sync::OnceLock<Bank> = std::sync::OnceLock::new();
    BANK.get_or_init(all_statistics).clone()
}
