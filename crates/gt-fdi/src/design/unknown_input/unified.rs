//! The unified solution: the normalised residual generator.

use gt_core::{OperatingPoint, Signal, StateSpace};
use nalgebra::{DMatrix, SymmetricEigen};

use super::super::generator::ResidualGenerator;
use super::super::kalman::KalmanFilter;
use super::super::noise::NoiseCovariance;
use super::error::UnknownInputError;
use super::fault_model::{FaultModel, UnknownInput, numbered};
use super::frequency_gain::FrequencyBand;
use super::linear_residual::LinearResidual;
use super::robustness::Robustness;
use crate::FdiError;

/// The smallest eigenvalue of the correlations of `R_e` with which residuals are normalised: below
/// it some combination of outputs feels the disturbances by rounding only.
pub const MIN_REACH: f64 = 1e-10;

/// Iterations per eigenvalue after which a symmetric eigenvalue problem is given up.
const EIGEN_ITERATIONS: usize = 100;

/// The residual generator that bounded disturbances of unknown spectrum disturb least in proportion
/// to what it shows of faults: `r = V (y - C x - D u)`, `x(t+1) = A x + B u + L (y - C x - D u)`
/// with `X = A X A' + E E' - L R_e L'`, `R_e = C X C' + F F'`, `L = (A X C' + E F') R_e^-1` and
/// `V R_e V' = I`: the Kalman filter of the covariances `E E'`, `F F'`, `E F'`, normalised.
///
/// Its response to disturbances is co-inner, `N_d(e^jw) N_d(e^jw)* = I`, and any other residual
/// generator is a stable system `Q` after it, so that at every frequency each singular value of the
/// response to faults, relative to the H-infinity norm of that to disturbances, is the largest that
/// can be had: one filter maximises `H_inf / H_inf`, `H_- / H_inf` and `H_-` over any band over
/// `H_inf` (S. X. Ding, *Model-based fault diagnosis techniques*, 2nd edition, Springer 2013, who
/// calls it the unified solution; for sampled systems J. Control Science and Engineering 2008,
/// 829459).
#[derive(Debug, Clone)]
pub struct UnifiedFilter {
    model: FaultModel,
    filter: KalmanFilter,
    /// The inverse of the lower Cholesky factor of `R_e`.
    post_filter: DMatrix<f64>,
}

impl UnifiedFilter {
    /// The filter of a model with disturbances.
    ///
    /// # Errors
    /// [`UnknownInputError::NoDisturbance`]; [`UnknownInputError::UntouchedOutputs`] or
    /// [`crate::design::FilterError::SingularInnovation`] when some combination of outputs feels no
    /// disturbance (fewer disturbances than outputs, for example, which decoupling is for);
    /// [`crate::design::FilterError::NoSteadySolution`] for a pair `(A, C)` that is not detectable
    /// or a zero from disturbances to outputs on the unit circle.
    pub fn new(model: FaultModel) -> Result<Self, FdiError> {
        let UnknownInput { state, output } = model.disturbance();
        let entries = || state.iter().chain(output.iter());
        if entries().all(|value| *value == 0.0) {
            return Err(UnknownInputError::NoDisturbance.into());
        }
        let noise = NoiseCovariance::new(
            &(state * state.transpose()),
            &(output * output.transpose()),
            &(state * output.transpose()),
        )?;
        let filter = KalmanFilter::new(model.model().clone(), noise)?;
        let covariance = filter.innovation_covariance();
        check_reach(&covariance)?;
        let untouched = |found| UnknownInputError::UntouchedOutputs {
            found,
            limit: MIN_REACH,
        };
        let ny = model.model().ny();
        let post_filter = covariance
            .cholesky()
            .and_then(|factor| {
                let identity = DMatrix::identity(ny, ny);
                factor.l_dirty().solve_lower_triangular(&identity)
            })
            .ok_or(untouched(0.0))?;
        Ok(Self {
            model,
            filter,
            post_filter,
        })
    }

    /// The model with its disturbances and faults.
    pub fn model(&self) -> &FaultModel {
        &self.model
    }

    /// The Kalman filter that it is, with `L` as its predictor gain and `R_e` as the covariance of
    /// its innovations.
    pub fn kalman(&self) -> &KalmanFilter {
        &self.filter
    }

    /// `V (ny x ny)`, the inverse of the lower Cholesky factor of `R_e`.
    pub fn post_filter(&self) -> &DMatrix<f64> {
        &self.post_filter
    }

    /// `N_d`: the normalised residuals (ny) that disturbances (nd) cause, signals `d0...` and
    /// `r0...`.
    ///
    /// # Errors
    /// [`FdiError::Model`] when the numbers overflow.
    pub fn from_disturbance(&self) -> Result<StateSpace, FdiError> {
        self.response(self.model.disturbance(), "d")
    }

    /// `N_f`: the normalised residuals (ny) that faults (nf) cause, signals `f0...` and `r0...`.
    ///
    /// # Errors
    /// [`FdiError::Model`] when the numbers overflow.
    pub fn from_fault(&self) -> Result<StateSpace, FdiError> {
        self.response(self.model.fault(), "f")
    }

    /// `(A - L C, E - L F, V C, V F)`.
    fn response(&self, input: &UnknownInput, prefix: &str) -> Result<StateSpace, FdiError> {
        let (model, gain) = (self.model.model(), self.filter.predictor_gain());
        let matrices = [
            model.a() - gain * model.c(),
            &input.state - gain * &input.output,
            &self.post_filter * model.c(),
            &self.post_filter * &input.output,
        ];
        let signals = (numbered(prefix, input.count()), numbered("r", model.ny()));
        let (inputs, outputs) = signals;
        let response = StateSpace::new(matrices, model.sample_time_s(), inputs, outputs)?;
        Ok(response)
    }

    /// What the filter achieves on faults within a band; the gain of disturbances is 1 but for
    /// rounding.
    ///
    /// # Errors
    /// As [`Robustness::of`].
    pub fn robustness(&self, band: FrequencyBand) -> Result<Robustness, FdiError> {
        Robustness::of(&self.from_disturbance()?, &self.from_fault()?, band)
    }

    /// The same as a residual generator of the online detector, round an operating point: its
    /// residuals are those before `V`, in the units of the outputs.
    ///
    /// # Errors
    /// As [`ResidualGenerator::kalman`].
    pub fn generator(&self, point: OperatingPoint) -> Result<ResidualGenerator, FdiError> {
        let (model, noise) = (self.model.model().clone(), self.filter.noise().clone());
        ResidualGenerator::kalman(model, point, noise)
    }

    /// The normalised residuals `r0...` (ny) from measured inputs and outputs, round an operating
    /// point.
    ///
    /// # Errors
    /// As [`LinearResidual::new`].
    pub fn residual(&self, point: OperatingPoint) -> Result<LinearResidual, FdiError> {
        let (model, gain) = (self.model.model(), self.filter.predictor_gain());
        let (nx, nu, ny) = (model.nx(), model.nu(), model.ny());
        let mut b = DMatrix::zeros(nx, nu + ny);
        b.columns_mut(0, nu)
            .copy_from(&(model.b() - gain * model.d()));
        b.columns_mut(nu, ny).copy_from(gain);
        let v = &self.post_filter;
        let mut d = DMatrix::zeros(ny, nu + ny);
        d.columns_mut(0, nu).copy_from(&-(v * model.d()));
        d.columns_mut(nu, ny).copy_from(v);
        let matrices = [model.a() - gain * model.c(), b, -(v * model.c()), d];
        let channels: Vec<Signal> = model
            .inputs()
            .iter()
            .chain(model.outputs())
            .cloned()
            .collect();
        let ts = model.sample_time_s();
        let system = StateSpace::new(matrices, ts, channels, numbered("r", ny))?;
        LinearResidual::new(system, point)
    }
}

/// Refuses an `R_e` that is singular but for rounding, whatever the units of the outputs.
fn check_reach(covariance: &DMatrix<f64>) -> Result<(), UnknownInputError> {
    let scales = covariance.diagonal().map(f64::sqrt);
    let correlations = DMatrix::from_fn(covariance.nrows(), covariance.ncols(), |row, column| {
        covariance[(row, column)] / scales[row] / scales[column]
    });
    if correlations.is_empty() {
        return Ok(());
    }
    let iterations = EIGEN_ITERATIONS * covariance.nrows();
    let found = SymmetricEigen::try_new(correlations, f64::EPSILON, iterations)
        .map_or(f64::NAN, |eigen| eigen.eigenvalues.min());
    if found >= MIN_REACH {
        Ok(())
    } else {
        Err(UnknownInputError::UntouchedOutputs {
            found,
            limit: MIN_REACH,
        })
    }
}
