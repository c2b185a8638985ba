//! Small plants with a fault, whose healthy equation error is white.

use gt_core::{Dataset, OperatingPoint, Signal, StateSpace};
use gt_fdi::design::RecordPair;
use nalgebra::DMatrix;

use crate::fixtures::{TS, canonical, monic, noise};

/// What the fault of a toy does.
#[derive(Clone, Copy)]
pub enum Fault {
    /// Adds a constant to the output's sensor.
    Bias(f64),
    /// Adds a ramp to the output's sensor, which reaches this at the end.
    Ramp(f64),
    /// Adds this to the last coefficient of the plant's denominator.
    Component(f64),
}

/// A plant `A(z^-1) y = z^-1 u + e` and its model.
pub struct Toy {
    pub model: StateSpace,
    /// Coefficients of A, that of `z^-l` at index `l`.
    a: Vec<f64>,
    fault: Fault,
}

/// A healthy and a faulty record.
pub struct Records {
    healthy: Dataset,
    faulty: Dataset,
}

impl Records {
    pub fn pair(&self) -> RecordPair<'_> {
        RecordPair {
            healthy: &self.healthy,
            faulty: &self.faulty,
        }
    }
}

impl Toy {
    pub fn new(poles: &[f64], fault: Fault) -> Self {
        let a: Vec<f64> = monic(poles).into_iter().rev().collect();
        // C A^k B are the first samples of the response to an impulse.
        let nx = poles.len();
        let mut response = vec![0.0; nx];
        for k in 0..nx {
            let past: f64 = (1..=k).map(|l| a[l] * response[k - l]).sum();
            response[k] = f64::from(u8::from(k == 0)) - past;
        }
        let markov = DMatrix::from_column_slice(nx, 1, &response);
        Self {
            model: canonical(poles, markov, DMatrix::zeros(1, 1), "y"),
            a,
            fault,
        }
    }

    pub fn point() -> OperatingPoint {
        OperatingPoint::zero(1, 1)
    }

    /// Records of `len` samples from rest: `u` is noise through a lag, `e` white with a standard
    /// deviation of 0.1, the same in both records.
    pub fn records(&self, seed: u64, len: usize) -> Records {
        let (draws, e) = (noise(2 * seed, len), noise(2 * seed + 1, len));
        let mut u = vec![0.0; len];
        for t in 1..len {
            u[t] = 0.9 * u[t - 1] + draws[t];
        }
        let mut faulty_a = self.a.clone();
        if let (Fault::Component(change), Some(last)) = (self.fault, faulty_a.last_mut()) {
            *last += change;
        }
        let run = |a: &[f64]| {
            let mut y: Vec<f64> = Vec::with_capacity(len);
            for t in 0..len {
                let past: f64 = (1..a.len().min(t + 1)).map(|l| a[l] * y[t - l]).sum();
                let input = if t > 0 { u[t - 1] } else { 0.0 };
                y.push(input + 0.1 * e[t] - past);
            }
            y
        };
        let mut faulty = run(&faulty_a);
        for (t, value) in faulty.iter_mut().enumerate() {
            *value += match self.fault {
                Fault::Bias(size) => size,
                Fault::Ramp(end) => end * t as f64 / len as f64,
                Fault::Component(_) => 0.0,
            };
        }
        let data = |y: Vec<f64>| {
            let (u, y) = (
                DMatrix::from_row_slice(1, len, &u),
                DMatrix::from_vec(1, len, y),
            );
            Dataset::new(Signal::named(&["u0"]), Signal::named(&["y"]), u, y, TS).expect("a record")
        };
        Records {
            healthy: data(run(&self.a)),
            faulty: data(faulty),
        }
    }
}

/// A record with the same channels and other values.
pub fn changed(data: &Dataset, change: impl Fn(&mut DMatrix<f64>, &mut DMatrix<f64>)) -> Dataset {
    let (mut u, mut y) = (data.u().clone(), data.y().clone());
    change(&mut u, &mut y);
    let (inputs, outputs) = (data.inputs().to_vec(), data.outputs().to_vec());
    Dataset::new(inputs, outputs, u, y, data.sample_time_s()).expect("a record")
}
