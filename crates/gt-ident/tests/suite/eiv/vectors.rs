//! The shared vectors `tests/vectors/eiv_*.json`: exact covariances, bounds and a record each.

use std::path::PathBuf;

use gt_core::{Dataset, Signal};
use gt_ident::eiv::Eiv;
use nalgebra::DMatrix;
use serde_json::Value;

use super::system::{System, m1, s1};

/// Relative; both sums over frequencies converge geometrically.
const BOUND_TOLERANCE: f64 = 1e-8;
/// In bounds: the same likelihood was minimised by another optimiser to another tolerance.
const ESTIMATE_TOLERANCE: f64 = 1e-3;

fn vector(name: &str) -> Value {
    let path = PathBuf::from(env!("CARGO_MANIFEST_DIR"))
        .join("../../tests/vectors")
        .join(name);
    serde_json::from_str(&std::fs::read_to_string(path).unwrap()).unwrap()
}

fn numbers(value: &Value) -> Vec<f64> {
    let values = value.as_array().unwrap().iter();
    values.map(|value| value.as_f64().unwrap()).collect()
}

fn record(vector: &Value, inputs: usize) -> Dataset {
    let y = numbers(&vector["data"]["y"]);
    // A list a sample.
    let samples = vector["data"]["u"].as_array().unwrap().iter();
    let u: Vec<f64> = samples.flat_map(numbers).collect();
    let signals = |names: &[&str]| names.iter().map(|name| Signal::new(*name, "")).collect();
    Dataset::new(
        signals(&["u1", "u2"][..inputs]),
        signals(&["y"]),
        DMatrix::from_column_slice(inputs, y.len(), &u),
        DMatrix::from_row_slice(1, y.len(), &y),
        1.0,
    )
    .unwrap()
}

fn compare(name: &str, system: &System, fitted: &str, order: usize) {
    let vector = vector(name);
    for (found, listed) in system.noise.iter().zip(numbers(&vector["sigma2"])) {
        assert!(
            (found - listed).abs() < 1e-9 * listed,
            "noise {found} {listed}"
        );
    }
    // The variances of the channels and the covariance at lag 1 are the mean of the spectrum and
    // of its product with exp(j w).
    let grid: usize = 4096;
    for (lag, listed) in vector["exact_R"]
        .as_array()
        .unwrap()
        .iter()
        .enumerate()
        .take(3)
    {
        let mut sum = DMatrix::zeros(system.channels(), system.channels());
        for k in 0..grid {
            let w = std::f64::consts::PI * (k as f64 + 0.5) / grid as f64;
            let turn = nalgebra::Complex::from_polar(1.0 / grid as f64, w * lag as f64);
            sum += system.measured(w).map(|value| (value * turn).re);
        }
        for (i, row) in listed.as_array().unwrap().iter().enumerate() {
            for (j, listed) in numbers(row).into_iter().enumerate() {
                let error = (sum[(i, j)] - listed).abs();
                assert!(error < 1e-9 * sum[(0, 0)], "R({lag}) {i} {j}: {error:e}");
            }
        }
    }
    let mut worst: f64 = 0.0;
    for (found, listed) in system
        .bound(500)
        .iter()
        .zip(numbers(&vector["crlb_std_semi_N500"]))
    {
        worst = worst.max((found / listed - 1.0).abs());
    }
    assert!(worst < BOUND_TOLERANCE, "{name}: bound {worst:e}");

    let data = record(&vector, system.inputs.len());
    let fit = Eiv::new(system.lags())
        .autoregression_order(order)
        .fit(&data)
        .unwrap();
    let noise = fit.output_noise.iter().chain(&fit.input_noise);
    let found: Vec<f64> = fit.rows[0]
        .theta()
        .iter()
        .copied()
        .chain(noise.map(|noise| noise.value))
        .collect();
    let listed = numbers(&vector["results"][fitted]);
    println!("{name}: bound {worst:.1e}, found {found:.5?}, listed {listed:.5?}");
    let criterion = &vector["results"][fitted.replace("_K256", "_cost")];
    let error = (fit.criterion - criterion.as_f64().unwrap()).abs();
    assert!(error < 1e-8, "{name}: f off by {error:e}");
    let bound = system.bound(500);
    for ((found, listed), bound) in found.iter().zip(&listed).zip(&bound) {
        let error = (found - listed).abs();
        assert!(
            error < ESTIMATE_TOLERANCE * bound,
            "{found} {listed} {bound}"
        );
    }
}

#[test]
fn published_vector_of_one_input() {
    compare("eiv_S1_snr20.json", &s1(20.0), "PWML_p30_K256", 30);
}

#[test]
fn published_vector_of_two_inputs() {
    compare("eiv_M1_snr10.json", &m1(10.0), "PWML_p30_K256", 30);
}
