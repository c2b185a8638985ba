//! Test vectors and simulated errors-in-variables records.

use gt_core::Dataset;
use gt_ident::eiv::EivLags;
use nalgebra::{DMatrix, DVector};
use rand::RngExt;
use rand_chacha::ChaCha8Rng;
use rand_distr::StandardNormal;
use serde_json::Value;

use crate::common::{generator, signals};

const S1: &str = include_str!("../../../../../tests/vectors/eiv_S1_snr20.json");
const M1: &str = include_str!("../../../../../tests/vectors/eiv_M1_snr10.json");

/// Samples before the record: the slowest pole of any system here is below 0.95.
const BURN_IN: usize = 400;

/// A system of known parameters with the exact covariances of its channels.
pub struct Vector {
    json: Value,
}

impl Vector {
    pub fn s1() -> Self {
        Self::parse(S1)
    }

    pub fn m1() -> Self {
        Self::parse(M1)
    }

    fn parse(text: &str) -> Self {
        let json = serde_json::from_str(text).unwrap();
        Self { json }
    }

    pub fn numbers(&self, key: &str) -> Vec<f64> {
        list(&self.json[key])
    }

    /// A reference estimate on the 500 samples: the relation and then the variances.
    pub fn result(&self, key: &str) -> Vec<f64> {
        list(&self.json["results"][key])
    }

    pub fn sigma(&self) -> DMatrix<f64> {
        self.matrix("exact_Sigma_n")
    }

    pub fn matrix(&self, key: &str) -> DMatrix<f64> {
        matrix(&self.json[key])
    }

    pub fn autocovariance(&self) -> Vec<DMatrix<f64>> {
        let list = self.json["exact_R"].as_array().unwrap();
        list.iter().map(matrix).collect()
    }

    pub fn lags(&self) -> EivLags {
        let inputs = self.json["B"].as_array().unwrap().len();
        EivLags::new(self.numbers("a").len(), vec![1; inputs]).unwrap()
    }

    /// The 500 samples.
    pub fn record(&self) -> Dataset {
        let y = list(&self.json["data"]["y"]);
        let u = matrix(&self.json["data"]["u"]).transpose();
        dataset(u, DMatrix::from_row_slice(1, y.len(), &y))
    }

    /// A record of the system with inputs and noise of its own.
    pub fn simulate(&self, seed: u64, samples: usize) -> Dataset {
        let mut rng = generator(seed);
        let total = samples + BURN_IN;
        let filters = self.json["input_arma"].as_array().unwrap();
        let mut u = DMatrix::zeros(filters.len(), total);
        for (input, filter) in filters.iter().enumerate() {
            let white = normal(&mut rng, total);
            let coloured = arma(&list(&filter["num"]), &list(&filter["den"]), &white);
            u.set_row(input, &coloured.transpose());
        }
        let b: Vec<Vec<f64>> = self.json["B"]
            .as_array()
            .unwrap()
            .iter()
            .map(list)
            .collect();
        let y = respond(&self.numbers("a"), &b, &u);
        noisy(&mut rng, &u, &y, &self.numbers("sigma2"))
    }
}

fn list(value: &Value) -> Vec<f64> {
    let numbers = value.as_array().unwrap().iter();
    numbers.map(|number| number.as_f64().unwrap()).collect()
}

fn matrix(value: &Value) -> DMatrix<f64> {
    let rows: Vec<Vec<f64>> = value.as_array().unwrap().iter().map(list).collect();
    DMatrix::from_fn(rows.len(), rows[0].len(), |i, j| rows[i][j])
}

fn normal(rng: &mut ChaCha8Rng, count: usize) -> DVector<f64> {
    DVector::from_fn(count, |_, _| rng.sample(StandardNormal))
}

pub fn dataset(u: DMatrix<f64>, y: DMatrix<f64>) -> Dataset {
    let (inputs, outputs) = (signals("u", u.nrows()), signals("y", y.nrows()));
    Dataset::new(inputs, outputs, u, y, 1.0).unwrap()
}

/// `num / den` on a white sequence, polynomials in `q^-1` with `den[0] = 1`.
fn arma(num: &[f64], den: &[f64], white: &DVector<f64>) -> DVector<f64> {
    let mut out = DVector::<f64>::zeros(white.len());
    for t in 0..white.len() {
        let driven = num.iter().enumerate().filter(|(k, _)| *k <= t);
        let mut value: f64 = driven.map(|(k, b)| b * white[t - k]).sum();
        for (k, a) in den.iter().enumerate().skip(1).filter(|(k, _)| *k <= t) {
            value -= a * out[t - k];
        }
        out[t] = value;
    }
    out
}

/// `y(t) + sum_k a_k y(t-k) = sum_j sum_k b_jk u_j(t-k)`, input lags from 1, as a `1 x N` row.
pub fn respond(a: &[f64], b: &[Vec<f64>], u: &DMatrix<f64>) -> DMatrix<f64> {
    let mut y = DMatrix::<f64>::zeros(1, u.ncols());
    for t in 0..u.ncols() {
        let mut value = 0.0;
        for (k, a) in a.iter().enumerate().filter(|(k, _)| *k < t) {
            value -= a * y[t - 1 - k];
        }
        for (input, b) in b.iter().enumerate() {
            for (k, b) in b.iter().enumerate().filter(|(k, _)| *k < t) {
                value += b * u[(input, t - 1 - k)];
            }
        }
        y[t] = value;
    }
    y
}

/// The record after the burn-in with white noise of the given variances, the outputs' first.
pub fn noisy(
    rng: &mut ChaCha8Rng,
    u: &DMatrix<f64>,
    y: &DMatrix<f64>,
    variances: &[f64],
) -> Dataset {
    let samples = u.ncols() - BURN_IN;
    let mut add = |matrix: &DMatrix<f64>, variances: &[f64]| {
        let mut kept = matrix.columns(BURN_IN, samples).into_owned();
        for (mut row, variance) in kept.row_iter_mut().zip(variances) {
            row += normal(rng, samples).transpose() * variance.sqrt();
        }
        kept
    };
    let y_noisy = add(y, &variances[..y.nrows()]);
    let u_noisy = add(u, &variances[y.nrows()..]);
    dataset(u_noisy, y_noisy)
}

/// The number of samples to simulate for a record of `samples`.
pub fn with_burn_in(samples: usize) -> usize {
    samples + BURN_IN
}
