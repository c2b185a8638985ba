//! The steady Kalman filter of a model whose inputs are measured with noise too.

use gt_core::{DimensionError, StateSpace};
use nalgebra::{DMatrix, DVector};

use super::kalman::{FilterRun, KalmanFilter};
use super::noise::NoiseCovariance;
use crate::FdiError;

/// The optimal filter of an errors-in-variables model: [`KalmanFilter`] with the noise of
/// [`NoiseCovariance::errors_in_variables`], and what it says of the channels without noise.
///
/// `u = u* + u~` and `y = y* + y~` with white noise of the covariances `Su` (nu x nu) and `Sy`
/// (ny x ny), both diagonal. Channels are estimated without a model of `u*`, which may be anything.
#[derive(Debug, Clone)]
pub struct EivKalman {
    filter: KalmanFilter,
    input_noise: DMatrix<f64>,
    output_noise: DMatrix<f64>,
}

impl EivKalman {
    /// The filter for noise of the variances `input` (nu) and `output` (ny), in squared units of
    /// the channels.
    ///
    /// # Errors
    /// As [`NoiseCovariance::errors_in_variables`] and [`KalmanFilter::new`].
    pub fn new(model: StateSpace, input: &[f64], output: &[f64]) -> Result<Self, FdiError> {
        let noise = NoiseCovariance::errors_in_variables(&model, input, output)?;
        let diagonal = |list| DMatrix::from_diagonal(&DVector::from_column_slice(list));
        Ok(Self {
            filter: KalmanFilter::new(model, noise)?,
            input_noise: diagonal(input),
            output_noise: diagonal(output),
        })
    }

    /// The filter of the state.
    pub fn filter(&self) -> &KalmanFilter {
        &self.filter
    }

    /// `y*(t|t) = y - Sy L^-1 e` (ny x N) from the measured outputs `y` (ny x N) and a run on them.
    ///
    /// # Errors
    /// [`DimensionError`] when the run is of another record.
    pub fn outputs(
        &self,
        y: &DMatrix<f64>,
        run: &FilterRun,
    ) -> Result<DMatrix<f64>, DimensionError> {
        DimensionError::check("rows of y (outputs)", self.filter.model().ny(), y.nrows())?;
        check_run(y.ncols(), y.nrows(), run)?;
        let weighted = self.filter.by_innovation_covariance(&run.innovations);
        Ok(y - &self.output_noise * weighted)
    }

    /// The covariance of the error of `y*(t|t)`: `Sy - Sy L^-1 Sy` (ny x ny).
    pub fn output_error_covariance(&self) -> DMatrix<f64> {
        let sy = &self.output_noise;
        sy - sy * self.filter.by_innovation_covariance(sy)
    }

    /// `u*(t|t) = u + Su D' L^-1 e` (nu x N) from the measured inputs `u` (nu x N) and a run on
    /// them; without a direct term the inputs as measured.
    ///
    /// # Errors
    /// [`DimensionError`] when the run is of another record.
    pub fn inputs(
        &self,
        u: &DMatrix<f64>,
        run: &FilterRun,
    ) -> Result<DMatrix<f64>, DimensionError> {
        let model = self.filter.model();
        DimensionError::check("rows of u (inputs)", model.nu(), u.nrows())?;
        check_run(u.ncols(), model.ny(), run)?;
        Ok(u + self.share(model.d()) * &run.innovations)
    }

    /// The covariance of the error of `u*(t|t)`: `Su - Su D' L^-1 D Su` (nu x nu).
    pub fn input_error_covariance(&self) -> DMatrix<f64> {
        let d = self.filter.model().d();
        &self.input_noise - self.share(d) * d * &self.input_noise
    }

    /// `u*(t|t+1) = u*(t|t) + Su W' L^-1 e(t+1)`, `W = C (B - K D)`, (nu x N): one sample later an
    /// input has acted on an output even without a direct term. The last column is `u*(t|t)`.
    ///
    /// # Errors
    /// [`DimensionError`] when the run is of another record.
    pub fn smoothed_inputs(
        &self,
        u: &DMatrix<f64>,
        run: &FilterRun,
    ) -> Result<DMatrix<f64>, DimensionError> {
        let mut inputs = self.inputs(u, run)?;
        if let Some(others) = u.ncols().checked_sub(1) {
            let later = self.share(&self.one_step_response()) * run.innovations.columns(1, others);
            let mut earlier = inputs.columns_mut(0, others);
            earlier += later;
        }
        Ok(inputs)
    }

    /// The covariance of the error of `u*(t|t+1)`:
    /// `Su - Su D' L^-1 D Su - Su W' L^-1 W Su` (nu x nu).
    pub fn smoothed_input_error_covariance(&self) -> DMatrix<f64> {
        let w = self.one_step_response();
        self.input_error_covariance() - self.share(&w) * w * &self.input_noise
    }

    /// `W = C (B - K D)` (ny x nu): what an input's error does to the next innovation.
    fn one_step_response(&self) -> DMatrix<f64> {
        let model = self.filter.model();
        model.c() * (model.b() - self.filter.predictor_gain() * model.d())
    }

    /// `Su M' L^-1` (nu x ny) for `M (ny x nu)`.
    fn share(&self, matrix: &DMatrix<f64>) -> DMatrix<f64> {
        let weighted = self.filter.by_innovation_covariance(matrix);
        &self.input_noise * weighted.transpose()
    }
}

fn check_run(samples: usize, outputs: usize, run: &FilterRun) -> Result<(), DimensionError> {
    let (rows, columns) = run.innovations.shape();
    DimensionError::check("rows of the innovations (outputs)", outputs, rows)?;
    DimensionError::check("columns of the innovations (samples)", samples, columns)
}
