//! The residual generator: an output observer round its operating point.

use gt_core::{Dataset, DimensionError, OperatingPoint, Signal, StateSpace};
use nalgebra::{DMatrix, DVector};
use serde::{Deserialize, Serialize};

use super::channels::Channels;
use super::observer::{check_poles, check_single_output, place};
use crate::FdiError;
use crate::runtime::{Generator, Matrices, Update};

/// The share of an initial state error below which a generator has settled.
pub const SETTLE_LEVEL: f64 = 1e-4;
/// The longest settling accepted, in samples: over two hours at 0.08 s, and slower is of no use.
pub const MAX_SETTLE_SAMPLES: usize = 100_000;

/// How far the gain in a file may be from that of its poles, relative to the largest entry: more
/// than another machine's rounding, less than any other pole.
const GAIN_TOLERANCE: f64 = 1e-6;

/// An output observer (the paper's eq. 22) for one output:
/// `r(t) = (y - y0) - C x - D (u - u0)`, `x(t+1) = A x + B (u - u0) + K r`, from `x(0) = 0`.
///
/// For one output `r = eps / P(z^-1)`: `eps` is the equation error of the model's ARX form, which
/// does not depend on the poles, and `P = prod_i (1 - p_i z^-1)` that of the placed poles.
///
/// Construction and deserialisation both check that the sizes fit and that the generator settles.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(try_from = "Unchecked")]
pub struct ResidualGenerator {
    model: StateSpace,
    gain: DVector<f64>,
    point: OperatingPoint,
    poles: Vec<f64>,
    #[serde(skip)]
    settle_samples: usize,
}

/// The fields of a [`ResidualGenerator`] as they come from a file.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Unchecked {
    model: StateSpace,
    gain: DVector<f64>,
    point: OperatingPoint,
    poles: Vec<f64>,
}

impl TryFrom<Unchecked> for ResidualGenerator {
    type Error = FdiError;

    fn try_from(raw: Unchecked) -> Result<Self, FdiError> {
        check_single_output(&raw.model)?;
        check_poles(raw.model.nx(), &raw.poles)?;
        let read = Self::checked(raw.model, raw.gain, raw.point, raw.poles)?;
        let placed = place(&read.model, &read.poles)?;
        let scale = placed.amax().max(f64::MIN_POSITIVE);
        let difference = (&placed - &read.gain).map(|value| value.abs() / scale);
        if difference.iter().any(|value| *value > GAIN_TOLERANCE) {
            let state = difference.imax();
            return Err(FdiError::Gain {
                output: read.output().name.clone(),
                state,
                expected: placed[state],
                found: read.gain[state],
            });
        }
        Ok(read)
    }
}

impl ResidualGenerator {
    /// The output observer of a model with one output, with the poles of `A - K C` as given.
    ///
    /// # Errors
    /// As [`place`]; besides when the operating point has other sizes than the model, a signal is
    /// named twice, or the observer does not settle within [`MAX_SETTLE_SAMPLES`].
    pub fn observer(
        model: StateSpace,
        point: OperatingPoint,
        poles: &[f64],
    ) -> Result<Self, FdiError> {
        let gain = place(&model, poles)?;
        Self::checked(model, gain, point, poles.to_vec())
    }

    fn checked(
        model: StateSpace,
        gain: DVector<f64>,
        point: OperatingPoint,
        poles: Vec<f64>,
    ) -> Result<Self, FdiError> {
        DimensionError::check("rows of the gain (states)", model.nx(), gain.len())?;
        DimensionError::check("inputs of the operating point", model.nu(), point.u.len())?;
        DimensionError::check("outputs of the operating point", model.ny(), point.y.len())?;
        let output = &model.outputs()[0].name;
        let numbers = [("gain", &gain), ("operating point u", &point.u)];
        for (what, values) in numbers.into_iter().chain([("operating point y", &point.y)]) {
            if let Some(&found) = values.iter().find(|value| !value.is_finite()) {
                return Err(FdiError::NotFinite {
                    output: output.clone(),
                    what,
                    found,
                });
            }
        }
        let mut tags: Vec<&String> = model.inputs().iter().map(|signal| &signal.name).collect();
        tags.push(output);
        super::channels::check_unique("signals of a generator", &tags)?;
        let closed = model.a() - &gain * model.c();
        let Some(settle_samples) = settling(&closed) else {
            return Err(FdiError::DoesNotSettle {
                output: output.clone(),
                level: SETTLE_LEVEL,
                limit: MAX_SETTLE_SAMPLES,
                spectral_radius: spectral_radius(closed),
            });
        };
        Ok(Self {
            model,
            gain,
            point,
            poles,
            settle_samples,
        })
    }

    /// The model.
    pub fn model(&self) -> &StateSpace {
        &self.model
    }

    /// The gain `K (nx)`.
    pub fn gain(&self) -> &DVector<f64> {
        &self.gain
    }

    /// The operating point round which the model holds.
    pub fn point(&self) -> &OperatingPoint {
        &self.point
    }

    /// The poles that were asked for (nx).
    pub fn poles(&self) -> &[f64] {
        &self.poles
    }

    /// The input signals (nu).
    pub fn inputs(&self) -> &[Signal] {
        self.model.inputs()
    }

    /// The output signal.
    pub fn output(&self) -> &Signal {
        &self.model.outputs()[0]
    }

    /// Sample time in seconds.
    pub fn sample_time_s(&self) -> f64 {
        self.model.sample_time_s()
    }

    /// Samples after which a wrong initial state is forgotten: the smallest `k` such that the free
    /// response `(A - K C)^j x0` of every unit `x0` stays below [`SETTLE_LEVEL`] for all `j >= k`,
    /// that is `||(A - K C)^j||_2 < 1e-4`, computed from the powers themselves.
    pub fn settle_samples(&self) -> usize {
        self.settle_samples
    }

    /// The residuals (N) of a record that has the generator's inputs and its output, by name, in
    /// any order and among others, from the initial state 0; the first
    /// [`ResidualGenerator::settle_samples`] of them hold the initial transient.
    ///
    /// A sample without a valid input or output gives NaN, as in the online detector.
    ///
    /// # Errors
    /// [`FdiError::MissingTags`] and [`FdiError::SampleTime`] when the record does not fit.
    pub fn residual(&self, data: &Dataset) -> Result<DVector<f64>, FdiError> {
        let inputs: Vec<&str> = self
            .inputs()
            .iter()
            .map(|signal| signal.name.as_str())
            .collect();
        let output = [self.output().name.as_str()];
        let mut channels = Channels::of(data, self.sample_time_s(), &inputs, &output)?;
        let mut generator = self.runtime((0..inputs.len()).collect());
        Ok(DVector::from_iterator(
            data.len(),
            (0..data.len()).map(|sample| {
                let (u, y) = channels.at(sample);
                match generator.step(u, y[0]) {
                    Update::Residual(residual) => residual,
                    Update::NoOutput | Update::Restarted => f64::NAN,
                }
            }),
        ))
    }

    /// The generator in flat arrays; `places` says where its inputs stand in the input vector.
    pub(super) fn runtime(&self, places: Vec<usize>) -> Generator {
        let (a, b, c, d) = (
            self.model.a(),
            self.model.b(),
            self.model.c(),
            self.model.d(),
        );
        let matrices = Matrices {
            a: by_rows(a),
            b: by_rows(b),
            closed_a: by_rows(&(a - &self.gain * c)),
            closed_b: by_rows(&(b - &self.gain * d)),
            gain: self.gain.as_slice().to_vec(),
            c: by_rows(c),
            d: by_rows(d),
            u0: self.point.u.as_slice().to_vec(),
            y0: self.point.y[0],
        };
        Generator::new(matrices, places)
    }
}

fn by_rows(matrix: &DMatrix<f64>) -> Vec<f64> {
    matrix.transpose().as_slice().to_vec()
}

/// The smallest `k` with `||closed^j||_2 < SETTLE_LEVEL` for all `j >= k`, or `None` beyond
/// [`MAX_SETTLE_SAMPLES`].
fn settling(closed: &DMatrix<f64>) -> Option<usize> {
    let nx = closed.nrows();
    if nx == 0 {
        return Some(0);
    }
    let mut power = DMatrix::<f64>::identity(nx, nx);
    let mut next = power.clone();
    let mut settled = 0;
    let mut largest = 0.0_f64;
    for k in 0..=MAX_SETTLE_SAMPLES {
        let frobenius = power.norm();
        if !frobenius.is_finite() {
            return None;
        }
        if !spectral_norm_below(&power, frobenius, SETTLE_LEVEL) {
            settled = k + 1;
        }
        largest = largest.max(frobenius);
        // The norm is submultiplicative: from here on, every power is this one times one of the
        // powers seen, and so on, none of them above the level.
        if frobenius * largest < SETTLE_LEVEL {
            return Some(settled);
        }
        power.mul_to(closed, &mut next);
        core::mem::swap(&mut power, &mut next);
    }
    None
}

/// Whether `||matrix||_2 < level`; the Frobenius norm settles most cases without singular values.
fn spectral_norm_below(matrix: &DMatrix<f64>, frobenius: f64, level: f64) -> bool {
    if frobenius < level {
        return true;
    }
    if frobenius >= level * (matrix.nrows() as f64).sqrt() {
        return false;
    }
    let largest = (matrix.transpose() * matrix).symmetric_eigenvalues().max();
    largest.sqrt() < level
}

/// Largest modulus of an eigenvalue; NaN when the iteration does not converge.
fn spectral_radius(matrix: DMatrix<f64>) -> f64 {
    let iterations = 100 * matrix.nrows();
    nalgebra::Schur::try_new(matrix, f64::EPSILON, iterations).map_or(f64::NAN, |schur| {
        schur
            .complex_eigenvalues()
            .iter()
            .map(|value| value.norm())
            .fold(0.0, f64::max)
    })
}
