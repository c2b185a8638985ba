//! The Kalman filter from a stated start, before it is steady.

use gt_core::{DimensionError, StateSpace};
use nalgebra::{DMatrix, DVector};

use super::gains::Gains;
use super::innovation::Innovation;
use super::kalman::process;
use super::noise::{NoiseCovariance, check_covariance, symmetrised};
use crate::FdiError;

/// A Kalman filter that steps its covariance `P(t)` too (the paper's eq. 27, with the gains of the
/// state now and one step ahead kept apart).
///
/// The start is stated: the state `x(0|-1)` and the covariance `P(0)` of its error, for example the
/// covariance of the state, or large numbers on the diagonal when nothing is known.
#[derive(Debug, Clone)]
pub struct TimeVaryingKalman {
    model: StateSpace,
    noise: NoiseCovariance,
    state: DVector<f64>,
    covariance: DMatrix<f64>,
    gains: Gains,
}

impl TimeVaryingKalman {
    /// A filter before its first sample: `x0 = x(0|-1)` (nx) and the covariance `p0` (nx x nx) of
    /// its error.
    ///
    /// # Errors
    /// [`FdiError::Dimension`] when a size disagrees; `p0` is checked as a covariance;
    /// [`FilterError::SingularInnovation`](super::FilterError::SingularInnovation) when
    /// `C P(0) C' + R` is not positive definite.
    pub fn new(
        model: StateSpace,
        noise: NoiseCovariance,
        x0: DVector<f64>,
        p0: &DMatrix<f64>,
    ) -> Result<Self, FdiError> {
        noise.check_model(&model)?;
        DimensionError::check("rows of x0 (states)", model.nx(), x0.len())?;
        DimensionError::check("rows of P(0) (states)", model.nx(), p0.nrows())?;
        check_covariance("P(0)", p0)?;
        let covariance = symmetrised(p0);
        let gains = Gains::of(process(&model, &noise), &covariance)?;
        Ok(Self {
            model,
            noise,
            state: x0,
            covariance,
            gains,
        })
    }

    /// `x(t|t-1)` (nx) of the sample that comes next.
    pub fn state(&self) -> &DVector<f64> {
        &self.state
    }

    /// `P(t)` (nx x nx), the covariance of that state's error.
    pub fn covariance(&self) -> &DMatrix<f64> {
        &self.covariance
    }

    /// `K(t) = (A P C' + S) L^-1 (nx x ny)` of the sample that comes next.
    pub fn predictor_gain(&self) -> &DMatrix<f64> {
        &self.gains.predictor
    }

    /// `F(t) = P C' L^-1 (nx x ny)` of the sample that comes next.
    pub fn filter_gain(&self) -> &DMatrix<f64> {
        &self.gains.filter
    }

    /// Takes the measured inputs `u` (nu) and outputs `y` (ny) of one sample, in deviations from
    /// the model's operating point.
    ///
    /// # Errors
    /// [`FdiError::Dimension`] when a size disagrees;
    /// [`FilterError::SingularInnovation`](super::FilterError::SingularInnovation) when the next
    /// `C P C' + R` is not positive definite. Either leaves the filter as it was.
    pub fn step(&mut self, u: &DVector<f64>, y: &DVector<f64>) -> Result<Innovation, FdiError> {
        let model = &self.model;
        DimensionError::check("rows of u (inputs)", model.nu(), u.len())?;
        DimensionError::check("rows of y (outputs)", model.ny(), y.len())?;
        let process = process(model, &self.noise);
        let covariance = self.gains.next(process, &self.covariance);
        let gains = Gains::of(process, &covariance)?;
        let e = y - model.c() * &self.state - model.d() * u;
        let state = model.a() * &self.state + model.b() * u + &self.gains.predictor * &e;
        let innovation = Innovation::new(e, &self.gains.innovation);
        self.state = state;
        self.covariance = covariance;
        self.gains = gains;
        Ok(innovation)
    }
}
