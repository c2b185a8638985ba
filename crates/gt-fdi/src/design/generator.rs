//! The residual generator: an output observer round its operating point.

use gt_core::{Dataset, DimensionError, OperatingPoint, Signal, StateSpace, stored_matrix};
use nalgebra::{Complex, DMatrix, DVector};
use serde::{Deserialize, Serialize};

use super::channels::{Channels, Stretch, names};
use super::kalman::KalmanFilter;
use super::noise::NoiseCovariance;
use super::observer::check_single_output;
use super::placement::PlacedPoles;
use super::settling::{settling, spectral_radius};
use crate::FdiError;
use crate::runtime::{Fleet, Generator, Matrices, Rows};

/// The share of an initial state error below which a generator has settled.
pub const SETTLE_LEVEL: f64 = 1e-4;
/// The longest settling accepted, in samples: over two hours at 0.08 s, and slower is of no use.
pub const MAX_SETTLE_SAMPLES: usize = 100_000;

/// The largest spectral radius of `A` with which a generator predicts where an output is missing:
/// an integrator that was identified passes. The state of a model that grows faster is worth nothing
/// after a few samples without a correction, and the generator begins anew.
pub const MAX_PREDICTED_RADIUS: f64 = 1.01;

/// How far the gain in a file may be from that of its poles or noise, relative to the largest
/// entry: more than another machine's rounding, less than any other pole.
const GAIN_TOLERANCE: f64 = 1e-6;

/// An output observer (the paper's eq. 22):
/// `r(t) = (y - y0) - C x - D (u - u0)`, `x(t+1) = A x + B (u - u0) + K r`, from `x(0) = 0`.
///
/// It has one output where its poles are placed, and any number where it is a Kalman filter. For
/// one output `r = eps / P(z^-1)`: `eps` is the equation error of the model's ARX form, which
/// does not depend on the poles, and `P = prod_i (1 - p_i z^-1)` that of the placed poles, or
/// of those of a Kalman filter, which is the same structure with another gain.
///
/// Construction and deserialisation both check that the sizes fit and that the generator settles.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(try_from = "Unchecked")]
pub struct ResidualGenerator {
    model: StateSpace,
    gain: DMatrix<f64>,
    point: OperatingPoint,
    poles: PlacedPoles,
    #[serde(skip_serializing_if = "Option::is_none")]
    noise: Option<NoiseCovariance>,
    #[serde(skip)]
    settle_samples: usize,
    #[serde(skip)]
    predicts: bool,
}

/// The fields of a [`ResidualGenerator`] as they come from a file.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Unchecked {
    model: StateSpace,
    #[serde(deserialize_with = "stored_matrix")]
    gain: DMatrix<f64>,
    point: OperatingPoint,
    poles: PlacedPoles,
    #[serde(default)]
    noise: Option<NoiseCovariance>,
}

impl TryFrom<Unchecked> for ResidualGenerator {
    type Error = FdiError;

    fn try_from(raw: Unchecked) -> Result<Self, FdiError> {
        let placed = if raw.noise.is_some() {
            0
        } else {
            check_single_output(&raw.model)?;
            raw.model.nx()
        };
        raw.poles.check(placed)?;
        let read = Self::checked(raw.model, raw.gain, raw.point, raw.poles, raw.noise)?;
        let (design, designed) = match &read.noise {
            Some(noise) => ("noise", innovation_gain(&read.model, noise)?),
            None => ("poles", column(&read.poles.place(&read.model)?)),
        };
        let scale = designed.amax().max(f64::MIN_POSITIVE);
        let difference = (&designed - &read.gain).map(|value| value.abs() / scale);
        if let Some(index) = difference.iter().position(|value| *value > GAIN_TOLERANCE) {
            let (state, output) = difference.vector_to_matrix_index(index);
            return Err(FdiError::Gain {
                output: read.outputs()[output].name.clone(),
                design,
                state,
                expected: designed[index],
                found: read.gain[index],
            });
        }
        Ok(read)
    }
}

impl ResidualGenerator {
    /// The output observer of a model with one output, with the poles of `A - K C` as given.
    ///
    /// # Errors
    /// As [`place`](super::place); besides when the operating point has other sizes than the model, a signal is
    /// named twice, or the observer does not settle within [`MAX_SETTLE_SAMPLES`].
    pub fn observer(
        model: StateSpace,
        point: OperatingPoint,
        poles: &[f64],
    ) -> Result<Self, FdiError> {
        Self::placed(model, point, PlacedPoles::Real(poles.to_vec()))
    }

    /// As [`ResidualGenerator::observer`], of poles that may also be pairs of complex ones.
    ///
    /// # Errors
    /// As [`place_complex`](super::place_complex), else as [`ResidualGenerator::observer`].
    pub fn observer_complex(
        model: StateSpace,
        point: OperatingPoint,
        poles: &[Complex<f64>],
    ) -> Result<Self, FdiError> {
        Self::placed(model, point, PlacedPoles::new(poles))
    }

    fn placed(
        model: StateSpace,
        point: OperatingPoint,
        poles: PlacedPoles,
    ) -> Result<Self, FdiError> {
        let gain = column(&poles.place(&model)?);
        Self::checked(model, gain, point, poles, None)
    }

    /// The steady Kalman filter of a model as an output observer: the gain is
    /// [`KalmanFilter::predictor_gain`], the residuals the innovations in the units of the outputs,
    /// white with the covariance [`KalmanFilter::innovation_covariance`] under the noise.
    ///
    /// # Errors
    /// As [`KalmanFilter::new`] and, but for the poles, [`ResidualGenerator::observer`].
    pub fn kalman(
        model: StateSpace,
        point: OperatingPoint,
        noise: NoiseCovariance,
    ) -> Result<Self, FdiError> {
        let gain = innovation_gain(&model, &noise)?;
        let poles = PlacedPoles::Real(Vec::new());
        Self::checked(model, gain, point, poles, Some(noise))
    }

    fn checked(
        model: StateSpace,
        gain: DMatrix<f64>,
        point: OperatingPoint,
        poles: PlacedPoles,
        noise: Option<NoiseCovariance>,
    ) -> Result<Self, FdiError> {
        DimensionError::check("rows of the gain (states)", model.nx(), gain.nrows())?;
        DimensionError::check("columns of the gain (outputs)", model.ny(), gain.ncols())?;
        DimensionError::check("inputs of the operating point", model.nu(), point.u.len())?;
        DimensionError::check("outputs of the operating point", model.ny(), point.y.len())?;
        let names: Vec<&str> = model
            .outputs()
            .iter()
            .map(|signal| signal.name.as_str())
            .collect();
        let output = names.join(", ");
        let numbers = [
            ("gain", gain.as_slice()),
            ("operating point u", point.u.as_slice()),
            ("operating point y", point.y.as_slice()),
        ];
        for (what, values) in numbers {
            if let Some(&found) = values.iter().find(|value| !value.is_finite()) {
                return Err(FdiError::NotFinite {
                    output,
                    what,
                    found,
                });
            }
        }
        let signals = model.inputs().iter().chain(model.outputs());
        let tags: Vec<&String> = signals.map(|signal| &signal.name).collect();
        super::channels::check_unique("signals of a generator", &tags)?;
        let closed = model.a() - &gain * model.c();
        let Some(settle_samples) = settling(&closed) else {
            return Err(FdiError::DoesNotSettle {
                output,
                level: SETTLE_LEVEL,
                limit: MAX_SETTLE_SAMPLES,
                spectral_radius: spectral_radius(&closed),
            });
        };
        Ok(Self {
            predicts: spectral_radius(model.a()) <= MAX_PREDICTED_RADIUS,
            model,
            gain,
            point,
            poles,
            noise,
            settle_samples,
        })
    }

    /// The model.
    pub fn model(&self) -> &StateSpace {
        &self.model
    }

    /// The gain `K (nx x ny)`.
    pub fn gain(&self) -> &DMatrix<f64> {
        &self.gain
    }

    /// The operating point round which the model holds.
    pub fn point(&self) -> &OperatingPoint {
        &self.point
    }

    /// The poles that were asked for (nx) when all are real, else none, for which see
    /// [`ResidualGenerator::complex_poles`]; none of a Kalman filter, which chooses its own.
    pub fn poles(&self) -> &[f64] {
        self.poles.real()
    }

    /// The poles that were asked for (nx), real ones among them; none of a Kalman filter.
    pub fn complex_poles(&self) -> Vec<Complex<f64>> {
        self.poles.complex()
    }

    /// The noise that the gain is optimal for, of a Kalman filter.
    pub fn noise(&self) -> Option<&NoiseCovariance> {
        self.noise.as_ref()
    }

    /// The input signals (nu).
    pub fn inputs(&self) -> &[Signal] {
        self.model.inputs()
    }

    /// The output signals (ny).
    pub fn outputs(&self) -> &[Signal] {
        self.model.outputs()
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

    /// The residuals (ny x N) of a record that has the generator's inputs and outputs, by name, in
    /// any order and among others, from the initial state 0; the first
    /// [`ResidualGenerator::settle_samples`] of them hold the initial transient.
    ///
    /// A sample without a valid input or output gives NaN, as in the online detector.
    ///
    /// # Errors
    /// [`FdiError::MissingTags`] and [`FdiError::SampleTime`] when the record does not fit.
    pub fn residuals(&self, data: &Dataset) -> Result<DMatrix<f64>, FdiError> {
        let (inputs, outputs) = (names(self.inputs()), names(self.outputs()));
        let mut channels = Channels::of(data, self.sample_time_s(), &inputs, &outputs)?;
        let mut generator = self.runtime((0..inputs.len()).collect());
        let mut residuals = DMatrix::zeros(outputs.len(), data.len());
        let mut left = residuals.as_mut_slice();
        let mut begin = 0;
        while begin < data.len() {
            let Stretch { u, y, len } = channels.stretch(begin);
            let own = left.split_off_mut(..len * outputs.len());
            generator.run(u, y, own.unwrap_or_default());
            begin += len;
        }
        Ok(residuals)
    }

    /// As [`ResidualGenerator::residuals`], of inputs `u (nu x N)` and outputs `y (ny x N)` sample
    /// after sample in the order of the model's signals, which are read where they are.
    ///
    /// # Errors
    /// [`DimensionError`] when `y` is no whole number of samples or `u` has not as many.
    pub fn residuals_of(&self, u: &[f64], y: &[f64]) -> Result<DMatrix<f64>, DimensionError> {
        let (nu, ny) = (self.model.nu(), self.model.ny());
        let samples = y.len() / ny;
        DimensionError::check("numbers in y (outputs x samples)", samples * ny, y.len())?;
        DimensionError::check("numbers in u (inputs x samples)", samples * nu, u.len())?;
        let mut residuals = DMatrix::zeros(ny, samples);
        let (u, y) = (Rows::new(u, nu), Rows::new(y, ny));
        self.runtime((0..nu).collect())
            .run(u, y, residuals.as_mut_slice());
        Ok(residuals)
    }

    /// The generator in flat arrays; `places` says where its inputs stand among inputs and outputs.
    pub(super) fn runtime(&self, places: Vec<usize>) -> Generator {
        Generator::new(self.matrices(&self.point), places)
    }

    /// As [`ResidualGenerator::runtime`], of deviations from the operating point.
    pub(super) fn runtime_of_deviations(&self, places: Vec<usize>) -> Generator {
        let zero = OperatingPoint::zero(self.model.nu(), self.model.ny());
        Generator::new(self.matrices(&zero), places)
    }

    fn matrices(&self, point: &OperatingPoint) -> Matrices {
        let (a, b, c, d) = (
            self.model.a(),
            self.model.b(),
            self.model.c(),
            self.model.d(),
        );
        Matrices {
            a: by_rows(a),
            b: by_rows(b),
            closed_a: by_rows(&(a - &self.gain * c)),
            closed_b: by_rows(&(b - &self.gain * d)),
            gain: by_rows(&self.gain),
            c: by_rows(c),
            d: by_rows(d),
            u0: point.u.as_slice().to_vec(),
            y0: point.y.as_slice().to_vec(),
            predicts: self.predicts,
        }
    }
}

impl Fleet {
    /// `generator` on as many `streams`, all in its initial state. Inputs and outputs are in the
    /// order of [`ResidualGenerator::inputs`] and [`ResidualGenerator::outputs`].
    pub fn new(generator: &ResidualGenerator, streams: usize) -> Self {
        Self::from_matrices(generator.matrices(&generator.point), streams)
    }
}

/// The Kalman filter's gain one step ahead.
fn innovation_gain(model: &StateSpace, noise: &NoiseCovariance) -> Result<DMatrix<f64>, FdiError> {
    let filter = KalmanFilter::new(model.clone(), noise.clone())?;
    Ok(filter.predictor_gain().clone())
}

fn column(gain: &DVector<f64>) -> DMatrix<f64> {
    DMatrix::from_column_slice(gain.len(), 1, gain.as_slice())
}

fn by_rows(matrix: &DMatrix<f64>) -> Vec<f64> {
    matrix.transpose().as_slice().to_vec()
}
