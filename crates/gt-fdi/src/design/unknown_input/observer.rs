//! The unknown-input observer: residuals that disturbances do not reach.

use gt_core::{Dataset, OperatingPoint, StateSpace};
use nalgebra::DMatrix;

use super::super::kalman::KalmanFilter;
use super::super::noise::NoiseCovariance;
use super::super::observer::place;
use super::decoupling::Decoupling;
use super::fault_model::{FaultModel, UnknownInput, numbered};
use super::linear_residual::LinearResidual;
use crate::FdiError;

/// An observer whose residuals no disturbance reaches, whatever its size and course.
///
/// With `H = E (C E)^+` and `T = I - H C`, `T E = 0`: what is left of the state, `T x`, is driven by
/// known signals only and is observed through the outputs across `C E`, of which there are
/// `ny - rank([E; F])`, that many residuals. Disturbances that enter the outputs at once are taken
/// out of these first. Exists if and only if the outputs show every disturbance, at once or one
/// step later, and no invariant zero from the disturbances to the outputs lies on or outside the unit
/// circle (J. Chen, R. J. Patton, *Robust model-based fault diagnosis for dynamic systems*, Kluwer
/// 1999, chapter 3; M. Darouach, M. Zasadzinski, S. J. Xu, IEEE Trans. Automatic Control 39, 1994;
/// of minimal order, M. Hou, P. C. Müller, IEEE Trans. Automatic Control 37, 1992).
///
/// A fault that enters as a disturbance does is not seen either; [`UnknownInputObserver::from_fault`]
/// shows what is.
#[derive(Debug, Clone, PartialEq)]
pub struct UnknownInputObserver {
    residual: LinearResidual,
    gain: DMatrix<f64>,
    covariance: Option<DMatrix<f64>>,
    from_disturbance: StateSpace,
    from_fault: StateSpace,
}

impl UnknownInputObserver {
    /// The observer with the gain of the Kalman filter for what is left of the plant's noise: of all
    /// residuals without disturbances, it has the innovations, white under that noise.
    ///
    /// # Errors
    /// [`super::UnknownInputError::HiddenDisturbance`], [`super::UnknownInputError::NoOutputLeft`],
    /// [`super::UnknownInputError::UnstableZero`] where no such observer exists; as [`KalmanFilter::new`]
    /// and [`LinearResidual::new`].
    pub fn kalman(
        model: &FaultModel,
        point: OperatingPoint,
        noise: &NoiseCovariance,
    ) -> Result<Self, FdiError> {
        let decoupling = Decoupling::of(model)?;
        let noise = decoupling.noise(noise)?;
        let filter = KalmanFilter::new(decoupling.reduced.clone(), noise)?;
        let gain = filter.predictor_gain().clone();
        let covariance = Some(filter.innovation_covariance());
        Self::with_gain(model, &decoupling, point, gain, covariance)
    }

    /// The observer with real poles as given, `nx - rank(E)` of them, where one residual is left.
    ///
    /// # Errors
    /// As [`UnknownInputObserver::kalman`] where no such observer exists; [`FdiError::OutputCount`]
    /// where more than one residual is left; as [`place`] and [`LinearResidual::new`].
    pub fn placed(
        model: &FaultModel,
        point: OperatingPoint,
        poles: &[f64],
    ) -> Result<Self, FdiError> {
        let decoupling = Decoupling::of(model)?;
        let gain = place(&decoupling.reduced, poles)?;
        let gain = DMatrix::from_column_slice(gain.len(), 1, gain.as_slice());
        Self::with_gain(model, &decoupling, point, gain, None)
    }

    fn with_gain(
        model: &FaultModel,
        decoupling: &Decoupling,
        point: OperatingPoint,
        gain: DMatrix<f64>,
        covariance: Option<DMatrix<f64>>,
    ) -> Result<Self, FdiError> {
        let (plant, reduced) = (model.model(), &decoupling.reduced);
        let (nu, ny, nr) = (plant.nu(), plant.ny(), reduced.ny());
        let mut d = DMatrix::zeros(nr, nu + ny);
        d.columns_mut(0, nu)
            .copy_from(&-(&decoupling.outputs * plant.d()));
        d.columns_mut(nu, ny).copy_from(&decoupling.outputs);
        let closed = reduced.a() - &gain * reduced.c();
        let matrices = [closed.clone(), reduced.b() + &gain * &d, -reduced.c(), d];
        let ts = plant.sample_time_s();
        let (channels, residuals) = (reduced.inputs().to_vec(), reduced.outputs().to_vec());
        let system = StateSpace::new(matrices, ts, channels, residuals.clone())?;
        let response = |input: &UnknownInput, prefix: &str| {
            let own = decoupling.of_input(input);
            let b = own.state - &gain * &own.output;
            let matrices = [closed.clone(), b, reduced.c().clone(), own.output];
            let inputs = numbered(prefix, input.count());
            StateSpace::new(matrices, ts, inputs, residuals.clone())
        };
        Ok(Self {
            from_disturbance: response(model.disturbance(), "d")?,
            from_fault: response(model.fault(), "f")?,
            residual: LinearResidual::new(system, point)?,
            gain,
            covariance,
        })
    }

    /// The observer as a system from measured inputs and outputs to residuals `r0...`, combinations
    /// of outputs without unit.
    pub fn residual(&self) -> &LinearResidual {
        &self.residual
    }

    /// The gain `K ((nx - rank(E)) x nr)` on the residuals.
    pub fn gain(&self) -> &DMatrix<f64> {
        &self.gain
    }

    /// The covariance of the residuals (nr x nr) under the noise of the design, where there is one.
    pub fn covariance(&self) -> Option<&DMatrix<f64>> {
        self.covariance.as_ref()
    }

    /// What disturbances (nd) do to the residuals: nothing but for rounding.
    pub fn from_disturbance(&self) -> &StateSpace {
        &self.from_disturbance
    }

    /// What faults (nf) do to the residuals.
    pub fn from_fault(&self) -> &StateSpace {
        &self.from_fault
    }

    /// Samples after which a wrong initial state is forgotten.
    pub fn settle_samples(&self) -> usize {
        self.residual.settle_samples()
    }

    /// The residuals (nr x N) of a record: see [`LinearResidual::residuals`].
    ///
    /// # Errors
    /// As [`LinearResidual::residuals`].
    pub fn residuals(&self, data: &Dataset) -> Result<DMatrix<f64>, FdiError> {
        self.residual.residuals(data)
    }
}
