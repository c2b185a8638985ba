//! Errors-in-variables systems that are known exactly: their spectra, records and bounds.

#![allow(
    clippy::unwrap_used,
    clippy::expect_used,
    reason = "the systems are constants or checked by the caller"
)]

use gt_core::{Dataset, Signal};
use gt_ident::IdentError;
use gt_ident::eiv::{EivLags, EivRow, Likelihood, Spectrum};
use nalgebra::{Complex, DMatrix, DVector};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use rand_distr::StandardNormal;

/// An input `u* = num(q^-1) / den(q^-1) e`, `e` white of variance 1; both start with 1.
#[derive(Debug, Clone)]
pub struct Arma {
    pub num: Vec<f64>,
    pub den: Vec<f64>,
}

impl Arma {
    pub fn new(num: &[f64], den: &[f64]) -> Self {
        let (num, den) = (num.to_vec(), den.to_vec());
        Self { num, den }
    }
}

/// Rows with shared inputs, and the variances of the white noise on outputs, then inputs.
#[derive(Debug, Clone)]
pub struct System {
    pub rows: Vec<EivRow>,
    pub inputs: Vec<Arma>,
    pub noise: Vec<f64>,
}

pub fn row(a: &[f64], b: &[&[f64]]) -> EivRow {
    let nk = b.iter().map(|b| a.len() + 1 - b.len()).collect();
    let theta: Vec<f64> = a
        .iter()
        .chain(b.iter().copied().flatten())
        .copied()
        .collect();
    EivRow::new(EivLags::new(a.len(), nk).unwrap(), DVector::from_vec(theta)).unwrap()
}

/// `sum_k c_k exp(-j w k)`.
pub fn response(coefficients: &[f64], w: f64) -> Complex<f64> {
    let terms = coefficients.iter().enumerate();
    terms
        .map(|(k, c)| Complex::from_polar(1.0, -w * k as f64) * *c)
        .sum()
}

impl System {
    /// With noise of the given signal-to-noise ratio in dB on every channel.
    pub fn new(rows: Vec<EivRow>, inputs: Vec<Arma>, snr_db: f64) -> Self {
        Self::on_grid(rows, inputs, snr_db, 8192)
    }

    /// The same from variances summed over so many frequencies.
    pub fn on_grid(rows: Vec<EivRow>, inputs: Vec<Arma>, snr_db: f64, grid: usize) -> Self {
        let count = rows.len() + inputs.len();
        let noise = vec![0.0; count];
        let mut system = Self {
            rows,
            inputs,
            noise,
        };
        for k in 0..grid {
            let w = std::f64::consts::PI * (k as f64 + 0.5) / grid as f64;
            let signal = system.signal(w);
            for (channel, noise) in system.noise.iter_mut().enumerate() {
                let level = 10_f64.powf(-snr_db / 10.0) / grid as f64;
                *noise += signal[(channel, channel)].re * level;
            }
        }
        system
    }

    pub fn lags(&self) -> Vec<EivLags> {
        self.rows.iter().map(|row| row.lags().clone()).collect()
    }

    /// Coefficients, then variances.
    pub fn point(&self) -> Vec<f64> {
        let theta = self.rows.iter().flat_map(|row| row.theta().iter());
        theta.chain(&self.noise).copied().collect()
    }

    pub fn channels(&self) -> usize {
        self.noise.len()
    }

    /// The transfer function of an output from an input.
    fn gain(&self, output: usize, input: usize, w: f64) -> Complex<f64> {
        let row = &self.rows[output];
        let mut a = vec![1.0];
        a.extend(row.a());
        let mut b = vec![0.0; row.lags().nk()[input]];
        b.extend(row.b(input));
        response(&b, w) / response(&a, w)
    }

    /// The spectrum of the noise-free channels.
    fn signal(&self, w: f64) -> DMatrix<Complex<f64>> {
        let (m, r) = (self.rows.len(), self.inputs.len());
        let h = DMatrix::from_fn(m + r, r, |channel, input| match channel.checked_sub(m) {
            None => self.gain(channel, input, w),
            Some(own) if own == input => Complex::from(1.0),
            Some(_) => Complex::from(0.0),
        });
        let inputs = self.inputs.iter().map(|arma| {
            let value = response(&arma.num, w) / response(&arma.den, w);
            Complex::from(value.norm_sqr())
        });
        let inputs = DMatrix::from_diagonal(&DVector::from_iterator(r, inputs));
        &h * inputs * h.adjoint()
    }

    /// The spectral matrix of the measured channels at `w`.
    pub fn measured(&self, w: f64) -> DMatrix<Complex<f64>> {
        let mut matrix = self.signal(w);
        for (channel, noise) in self.noise.iter().enumerate() {
            matrix[(channel, channel)] += noise;
        }
        matrix
    }

    /// The exact spectrum of the measured channels.
    pub fn spectrum(&self, frequencies: usize) -> Result<Spectrum, IdentError> {
        Spectrum::from_fn(self.channels(), frequencies, |w| self.measured(w))
    }

    /// Deviations of the semiparametric bound over so many samples.
    pub fn bound(&self, samples: usize) -> Vec<f64> {
        let spectrum = self.spectrum(2048).unwrap();
        let likelihood = Likelihood::new(&self.lags(), &spectrum).unwrap();
        let information = likelihood.information(&self.point()).unwrap() * samples as f64;
        let covariance = information.cholesky().expect("identifiable").inverse();
        covariance.diagonal().iter().map(|v| v.sqrt()).collect()
    }

    /// A record; run `index` of a seed.
    pub fn record(&self, samples: usize, seed: u64, index: u64) -> Dataset {
        const SETTLE: usize = 600;
        let mut rng = ChaCha8Rng::seed_from_u64(seed);
        rng.set_stream(index);
        let mut normal = || -> f64 { rng.sample(StandardNormal) };
        let (m, r, total) = (self.rows.len(), self.inputs.len(), samples + SETTLE);
        let mut u = DMatrix::zeros(r, total);
        for (input, arma) in self.inputs.iter().enumerate() {
            let e: Vec<f64> = (0..total).map(|_| normal()).collect();
            for t in 0..total {
                let moved = arma.num.iter().take(t + 1).enumerate();
                let past = arma.den.iter().take(t + 1).enumerate().skip(1);
                let value = moved.map(|(k, c)| c * e[t - k]).sum::<f64>()
                    - past.map(|(k, c)| c * u[(input, t - k)]).sum::<f64>();
                u[(input, t)] = value;
            }
        }
        let mut y = DMatrix::zeros(m, total);
        for (output, row) in self.rows.iter().enumerate() {
            for t in row.lags().order()..total {
                let mut value = 0.0;
                for (k, a) in row.a().iter().enumerate() {
                    value -= a * y[(output, t - 1 - k)];
                }
                for input in 0..r {
                    let nk = row.lags().nk()[input];
                    for (k, b) in row.b(input).iter().enumerate() {
                        value += b * u[(input, t - nk - k)];
                    }
                }
                y[(output, t)] = value;
            }
        }
        let mut cut = |matrix: &DMatrix<f64>, noise: &[f64]| {
            let mut cut = matrix.columns(SETTLE, samples).into_owned();
            for (mut row, variance) in cut.row_iter_mut().zip(noise) {
                for value in row.iter_mut() {
                    *value += variance.sqrt() * normal();
                }
            }
            cut
        };
        let (y, u) = (cut(&y, &self.noise[..m]), cut(&u, &self.noise[m..]));
        let names = |prefix: &str, count: usize| -> Vec<Signal> {
            (1..=count)
                .map(|index| Signal::new(format!("{prefix}{index}"), ""))
                .collect()
        };
        Dataset::new(names("u", r), names("y", m), u, y, 1.0).unwrap()
    }
}

/// Two poles of radius 0.84, a coloured input.
pub fn s1(snr_db: f64) -> System {
    System::new(
        vec![row(&[-1.5, 0.7], &[&[1.0, 0.5]])],
        vec![Arma::new(&[1.0, 0.7], &[1.0, -0.5])],
        snr_db,
    )
}

/// Slow poles, 0.95 and 0.8, and a slow input: what a turbine looks like.
pub fn s2(snr_db: f64) -> System {
    System::new(
        vec![row(&[-1.75, 0.76], &[&[0.05, 0.03]])],
        vec![Arma::new(&[1.0], &[1.0, -0.9])],
        snr_db,
    )
}

fn two_inputs() -> Vec<Arma> {
    vec![
        Arma::new(&[1.0], &[1.0, -0.7]),
        Arma::new(&[1.0, 0.5], &[1.0, 0.3]),
    ]
}

/// Two inputs, one of them nearly white.
pub fn m1(snr_db: f64) -> System {
    System::new(
        vec![row(&[-1.2, 0.5], &[&[1.0, 0.5], &[-0.6, 0.8]])],
        two_inputs(),
        snr_db,
    )
}

/// Four outputs of order 2 that share two inputs.
pub fn four_outputs(snr_db: f64) -> System {
    System::new(
        vec![
            row(&[-1.2, 0.5], &[&[1.0, 0.5], &[-0.6, 0.8]]),
            row(&[-1.5, 0.7], &[&[0.5, 0.3], &[0.4, 0.2]]),
            row(&[-0.9, 0.3], &[&[0.8, -0.4], &[0.5, 0.6]]),
            row(&[-1.3, 0.42], &[&[0.3, 0.2], &[-0.5, 0.3]]),
        ],
        two_inputs(),
        snr_db,
    )
}
