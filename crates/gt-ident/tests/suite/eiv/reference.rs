//! Systems with random binary inputs whose least-squares bias is listed by an independent
//! implementation (`eiv_reference.json` in the folder that `GTFDI_REFERENCE_DATA` names).

use gt_core::{Dataset, Signal};
use gt_ident::eiv::{Eiv, EivLags};
use nalgebra::DMatrix;
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use rand_distr::StandardNormal;
use serde_json::Value;

use super::monte_carlo::{found, is_stable};

const RUNS: u64 = 200;
const SAMPLES: usize = 1023;

/// Inputs of +-1, noise of a tenth of the variance of each signal.
fn record(a: &[f64], b: &[f64], index: u64) -> Dataset {
    const SETTLE: usize = 200;
    let mut rng = ChaCha8Rng::seed_from_u64(61);
    rng.set_stream(index);
    let total = SAMPLES + SETTLE;
    let u: Vec<f64> = (0..total)
        .map(|_| if rng.random() { 1.0 } else { -1.0 })
        .collect();
    // For a white input of variance 1 the variance of the output is the sum of its squared
    // impulse response.
    let simulate = |u: &[f64]| {
        let mut y = vec![0.0; u.len()];
        for t in 0..u.len() {
            for (k, a) in a.iter().enumerate().take(t) {
                y[t] -= a * y[t - 1 - k];
            }
            for (k, b) in b.iter().enumerate().take(t) {
                y[t] += b * u[t - 1 - k];
            }
        }
        y
    };
    let mut impulse = vec![0.0; 400];
    impulse[0] = 1.0;
    let variance: f64 = simulate(&impulse).iter().map(|h| h * h).sum();
    let y = simulate(&u);
    let mut noisy = |values: &[f64], variance: f64| -> Vec<f64> {
        let values = values[SETTLE..].iter();
        values
            .map(|value| value + variance.sqrt() * rng.sample::<f64, _>(StandardNormal))
            .collect()
    };
    let (y, u) = (noisy(&y, 0.1 * variance), noisy(&u, 0.1));
    Dataset::new(
        vec![Signal::new("u", "")],
        vec![Signal::new("y", "")],
        DMatrix::from_row_slice(1, SAMPLES, &u),
        DMatrix::from_row_slice(1, SAMPLES, &y),
        1.0,
    )
    .unwrap()
}

#[test]
fn published_systems_are_found_without_the_bias_of_least_squares() {
    let test = "published_systems_are_found_without_the_bias_of_least_squares";
    let Some(folder) = std::env::var_os("GTFDI_REFERENCE_DATA") else {
        println!("skipped: {test}: GTFDI_REFERENCE_DATA is not set");
        return;
    };
    let path = std::path::PathBuf::from(folder).join("eiv_reference.json");
    let reference: Value = serde_json::from_str(&std::fs::read_to_string(path).unwrap()).unwrap();
    let numbers = |value: &Value| -> Vec<f64> {
        let values = value.as_array().unwrap().iter();
        values.map(|value| value.as_f64().unwrap()).collect()
    };
    for case in ["first_order", "second_order"] {
        let system = &reference[case];
        let (a, b) = (numbers(&system["a"]), numbers(&system["b"]));
        let truth = [a.clone(), b.clone()].concat();
        let lags = EivLags::new(a.len(), vec![1]).unwrap();
        let mut mean = vec![0.0; truth.len()];
        let mut square = mean.clone();
        for index in 0..RUNS {
            let fit = Eiv::new(vec![lags.clone()])
                .fit(&record(&a, &b, index))
                .unwrap();
            assert!(is_stable(fit.rows[0].a()));
            for (parameter, value) in found(&fit)[..truth.len()].iter().enumerate() {
                let error = value - truth[parameter];
                mean[parameter] += error / RUNS as f64;
                square[parameter] += error * error / RUNS as f64;
            }
        }
        let least_squares = numbers(&system["ls_mean"]);
        let listed = numbers(&system["frisch_std"]);
        for (parameter, truth) in truth.iter().enumerate() {
            let biased = (least_squares[parameter] - truth).abs();
            let (bias, deviation) = (mean[parameter].abs(), square[parameter].sqrt());
            println!(
                "{case} {parameter}: bias {bias:.5} (least squares {biased:.5}), {deviation:.5}"
            );
            assert!(
                bias < biased / 20.0,
                "{case} {parameter}: {bias} of {biased}"
            );
            // A moment estimator is no better than maximum likelihood; a deviation over 200 runs
            // is good to a twentieth, both are measured, four of the difference.
            assert!(
                deviation < 1.3 * listed[parameter],
                "{case} {parameter}: {deviation}"
            );
        }
    }
}
