//! The steady Kalman filter of a model.

use gt_core::{DimensionError, StateSpace};
use nalgebra::{DMatrix, DVector};

use super::gains::{Gains, Process};
use super::innovation::whitened;
use super::noise::NoiseCovariance;
use super::riccati::Riccati;
use crate::FdiError;

/// The steady Kalman filter of `x(t+1) = A x + B u + w`, `y(t) = C x + D u + v`, `S = E[w v']`:
/// `e(t) = y - C x - D u`, `x(t+1|t) = A x + B u + K e`, `x(t|t) = x(t|t-1) + F e`.
///
/// With `P` from the Riccati equation and `L = C P C' + R = cov(e)` the two gains are
/// `K = (A P C' + S) L^-1` and `F = P C' L^-1`; the paper's eq. 27 writes one `K(t)` for both.
/// `S = B Su D'` is not zero for errors in variables with a direct term, and without it the
/// innovations are not white.
///
/// The innovations are white with covariance `L` only under the noise of the design: whiteness
/// sees ratios of variances (all of them times a number give the same `K`), and `e' L^-1 e` their
/// level.
#[derive(Debug, Clone)]
pub struct KalmanFilter {
    model: StateSpace,
    noise: NoiseCovariance,
    riccati: Riccati,
    gains: Gains,
}

/// What a filter made of a record of N samples; a column is a sample.
#[derive(Debug, Clone, PartialEq)]
pub struct FilterRun {
    /// `e(t) = y - C x(t|t-1) - D u` (ny x N), in the units of the outputs.
    pub innovations: DMatrix<f64>,
    /// `W^-1 e` (ny x N) with the lower Cholesky factor `W W' = L`: unit covariance, no unit.
    pub normalised: DMatrix<f64>,
    /// `x(t|t-1)` (nx x N), from the samples before.
    pub predicted: DMatrix<f64>,
    /// `x(t|t)` (nx x N), from the samples before and this one.
    pub filtered: DMatrix<f64>,
}

impl KalmanFilter {
    /// The filter of a model with this noise.
    ///
    /// # Errors
    /// [`FdiError::Dimension`] when the noise has other sizes than the model; as
    /// [`Riccati::solve`].
    pub fn new(model: StateSpace, noise: NoiseCovariance) -> Result<Self, FdiError> {
        noise.check_model(&model)?;
        let process = process(&model, &noise);
        let riccati = Riccati::of(process)?;
        let gains = Gains::of(process, &riccati.p)?;
        Ok(Self {
            model,
            noise,
            riccati,
            gains,
        })
    }

    /// The model.
    pub fn model(&self) -> &StateSpace {
        &self.model
    }

    /// The noise of the design.
    pub fn noise(&self) -> &NoiseCovariance {
        &self.noise
    }

    /// The covariance `P` (nx x nx) of the error of `x(t|t-1)`, with its residual and the spectral
    /// radius of `A - K C`.
    pub fn riccati(&self) -> &Riccati {
        &self.riccati
    }

    /// `K = (A P C' + S) L^-1 (nx x ny)`, which corrects the state one step ahead.
    pub fn predictor_gain(&self) -> &DMatrix<f64> {
        &self.gains.predictor
    }

    /// `F = P C' L^-1 (nx x ny)`, which corrects the state now.
    pub fn filter_gain(&self) -> &DMatrix<f64> {
        &self.gains.filter
    }

    /// `L = C P C' + R (ny x ny)`, the covariance of the innovations.
    pub fn innovation_covariance(&self) -> DMatrix<f64> {
        self.gains.innovation_covariance()
    }

    /// `P - F C P (nx x nx)`, the covariance of the error of `x(t|t)`.
    pub fn filtered_covariance(&self) -> DMatrix<f64> {
        let p = &self.riccati.p;
        p - &self.gains.filter * self.model.c() * p
    }

    /// The innovation `e` (ny) whitened: `W^-1 e` with the lower Cholesky factor `W W' = L`.
    ///
    /// # Errors
    /// [`DimensionError`] for another number of entries than outputs.
    pub fn normalise(&self, innovation: &DVector<f64>) -> Result<DVector<f64>, DimensionError> {
        DimensionError::check("rows of the innovation", self.model.ny(), innovation.len())?;
        Ok(whitened(&self.gains.innovation, innovation))
    }

    /// `L^-1 M` for `M (ny x columns)`.
    pub(super) fn by_innovation_covariance(&self, matrix: &DMatrix<f64>) -> DMatrix<f64> {
        self.gains.innovation.solve(matrix)
    }

    /// Filters the measured inputs `u (nu x N)` and outputs `y (ny x N)`, in deviations from the
    /// model's operating point, from the state `x0 = x(0|-1)` (nx). A wrong `x0` is forgotten at
    /// the rate of [`Riccati::spectral_radius`]; what is not finite in the record stays in the
    /// state from there on.
    ///
    /// # Errors
    /// [`DimensionError`] when a size disagrees.
    pub fn run(
        &self,
        x0: &DVector<f64>,
        u: &DMatrix<f64>,
        y: &DMatrix<f64>,
    ) -> Result<FilterRun, DimensionError> {
        let (model, len) = (&self.model, u.ncols());
        DimensionError::check("rows of x0 (states)", model.nx(), x0.len())?;
        DimensionError::check("rows of u (inputs)", model.nu(), u.nrows())?;
        DimensionError::check("rows of y (outputs)", model.ny(), y.nrows())?;
        DimensionError::check("columns of y (samples)", len, y.ncols())?;
        let mut run = FilterRun {
            innovations: DMatrix::zeros(model.ny(), len),
            normalised: DMatrix::zeros(model.ny(), len),
            predicted: DMatrix::zeros(model.nx(), len),
            filtered: DMatrix::zeros(model.nx(), len),
        };
        let mut x = x0.clone();
        for (sample, (u, y)) in u.column_iter().zip(y.column_iter()).enumerate() {
            let e = y - model.c() * &x - model.d() * u;
            let normalised = whitened(&self.gains.innovation, &e);
            run.normalised.set_column(sample, &normalised);
            run.predicted.set_column(sample, &x);
            let filtered = &x + &self.gains.filter * &e;
            run.filtered.set_column(sample, &filtered);
            x = model.a() * x + model.b() * u + &self.gains.predictor * &e;
            run.innovations.set_column(sample, &e);
        }
        Ok(run)
    }
}

/// The matrices of a model and its noise.
pub(super) fn process<'a>(model: &'a StateSpace, noise: &'a NoiseCovariance) -> Process<'a> {
    Process {
        a: model.a(),
        c: model.c(),
        q: noise.q(),
        r: noise.r(),
        s: noise.s(),
    }
}
