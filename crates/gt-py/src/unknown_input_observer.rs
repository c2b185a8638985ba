//! `UnknownInputObserver`: residuals that disturbances do not reach.

use gtfdi::core::OperatingPoint;
use gtfdi::fdi::{FaultModel, NoiseCovariance, UnknownInputObserver};
use numpy::PyArray2;
use pyo3::prelude::*;
use serde::{Deserialize, Serialize};

use crate::array::matrix_out;
use crate::dataset::names;
use crate::error::Failure;
use crate::fault_model::PyFaultModel;
use crate::linear_residual::{PyLinearResidual, residuals_of};
use crate::noise_covariance::PyNoiseCovariance;
use crate::pickle::{Pickled, Reduced, reduce};
use crate::state_space::PyStateSpace;

/// An observer whose residuals no disturbance reaches, whatever its size and course.
///
/// It exists if the outputs show every disturbance, at once or one sample later, some combination
/// of outputs is left, and the zeros from the disturbances to the outputs lie inside the unit
/// circle. A fault that enters as a disturbance does is not seen either; ``from_fault`` shows what
/// is.
///
/// Parameters
/// ----------
/// model : FaultModel
///     The model with its disturbances.
/// noise : NoiseCovariance, optional
///     The plant's noise: of all residuals without disturbances the observer then has those that
///     are white under it.
/// poles : list of float, optional
///     In place of the noise, where one residual is left: as many real poles as states are left,
///     which is nx less the disturbances that only the states show.
///
/// Raises
/// ------
/// DesignError
///     There is no such observer, or the poles cannot be had.
/// OptionError
///     Not one of ``noise`` and ``poles``.
///
/// Examples
/// --------
/// Nobody measures what leaks out of the second of two tanks; the sensor of the first one is
/// watched.
///
/// >>> tanks = gtfdi.StateSpace(
/// ...     [[0.9, 0.0], [0.1, 0.9]], [[1.0], [0.0]], np.eye(2), np.zeros((2, 1)), 1.0
/// ... )
/// >>> leak, sensor = [[0.0], [1.0]], [[1.0], [0.0]]
/// >>> faulty = gtfdi.FaultModel(tanks, E_d=leak, F_f=sensor)
/// >>> observer = gtfdi.UnknownInputObserver(faulty, poles=[0.5])
/// >>> gtfdi.peak_gain(observer.from_disturbance)["gain"] < 1e-15
/// True
/// >>> level = np.array([[0.0, 0.0], [0.0, -1.0], [0.0, -1.9]])  # it leaks
/// >>> bool(np.abs(observer.residuals(np.zeros((3, 1)), level)).max() < 1e-14)
/// True
#[pyclass(frozen, eq, name = "UnknownInputObserver", module = "gtfdi")]
#[derive(PartialEq)]
pub struct PyUnknownInputObserver {
    inner: UnknownInputObserver,
    model: FaultModel,
    gain_by: GainBy,
}

/// What the gain is made by.
#[derive(Clone, PartialEq, Serialize, Deserialize)]
pub enum GainBy {
    /// A Kalman filter for this noise.
    Noise(NoiseCovariance),
    /// These poles.
    Poles(Vec<f64>),
}

impl PyUnknownInputObserver {
    fn of(model: FaultModel, point: OperatingPoint, gain_by: GainBy) -> Result<Self, Failure> {
        let inner = match &gain_by {
            GainBy::Noise(noise) => UnknownInputObserver::kalman(&model, point, noise)?,
            GainBy::Poles(poles) => UnknownInputObserver::placed(&model, point, poles)?,
        };
        Ok(Self {
            inner,
            model,
            gain_by,
        })
    }
}

#[pymethods]
impl PyUnknownInputObserver {
    #[new]
    #[pyo3(signature = (model, *, noise=None, poles=None))]
    fn py_new(
        model: &PyFaultModel,
        noise: Option<&PyNoiseCovariance>,
        poles: Option<Vec<f64>>,
    ) -> Result<Self, Failure> {
        let gain_by = match (noise, poles) {
            (Some(noise), None) => GainBy::Noise(noise.inner.clone()),
            (None, Some(poles)) => GainBy::Poles(poles),
            (noise, _) => {
                return Err(Failure::Option {
                    option: "noise",
                    expected: "one of noise and poles".to_owned(),
                    found: if noise.is_some() { "both" } else { "none" }.to_owned(),
                });
            }
        };
        Self::of(model.inner.clone(), model.point.clone(), gain_by)
    }

    /// The residuals of a record, an array (N, nr), from the initial state zero; the first
    /// ``settle_samples`` of them hold the initial transient. They are combinations of outputs
    /// without a unit. A sample without a valid input or output gives NaN and begins a new
    /// transient.
    #[pyo3(signature = (u, y=None))]
    fn residuals<'py>(
        &self,
        u: &Bound<'py, PyAny>,
        y: Option<&Bound<'py, PyAny>>,
    ) -> Result<Bound<'py, PyArray2<f64>>, Failure> {
        residuals_of(self.inner.residual(), u, y)
    }

    /// The observer as a system from measured inputs and outputs to residuals (LinearResidual).
    #[getter]
    fn linear_residual(&self) -> PyLinearResidual {
        PyLinearResidual {
            inner: self.inner.residual().clone(),
        }
    }

    /// What disturbances do to the residuals (StateSpace): nothing but for rounding.
    #[getter(from_disturbance)]
    fn disturbance_response(&self) -> PyStateSpace {
        PyStateSpace {
            inner: self.inner.from_disturbance().clone(),
        }
    }

    /// What faults do to the residuals (StateSpace).
    #[getter(from_fault)]
    fn fault_response(&self) -> PyStateSpace {
        PyStateSpace {
            inner: self.inner.from_fault().clone(),
        }
    }

    /// The gain on the residuals, an array of as many rows as states are left, and nr columns.
    #[getter]
    fn gain<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray2<f64>>> {
        matrix_out(py, self.inner.gain())
    }

    /// The covariance of the residuals under the noise, an array (nr, nr); ``None`` with poles.
    #[getter]
    fn covariance<'py>(&self, py: Python<'py>) -> PyResult<Option<Bound<'py, PyArray2<f64>>>> {
        let covariance = self.inner.covariance();
        covariance.map(|values| matrix_out(py, values)).transpose()
    }

    /// Samples after which a wrong initial state is forgotten.
    #[getter]
    fn settle_samples(&self) -> usize {
        self.inner.settle_samples()
    }

    /// The model with its disturbances and faults (FaultModel).
    #[getter]
    fn model(&self) -> PyFaultModel {
        PyFaultModel {
            inner: self.model.clone(),
            point: self.inner.residual().point().clone(),
        }
    }

    fn __reduce__<'py>(&self, py: Python<'py>) -> Result<Reduced<'py>, Failure> {
        reduce(py, self)
    }

    fn __repr__(&self) -> String {
        let residual = self.inner.residual();
        format!(
            "UnknownInputObserver({} residuals, outputs: {}, inputs: {})",
            residual.residual_signals().len(),
            names(residual.outputs()).join(", "),
            names(residual.inputs()).join(", ")
        )
    }
}

impl Pickled for PyUnknownInputObserver {
    /// What it is made of: the same observer, bit for bit, is made again.
    type Stored = (<PyFaultModel as Pickled>::Stored, GainBy);

    fn stored(&self) -> Result<Self::Stored, Failure> {
        Ok((self.model().stored()?, self.gain_by.clone()))
    }

    fn restored((model, gain_by): Self::Stored) -> Result<Self, Failure> {
        let model = PyFaultModel::restored(model)?;
        Self::of(model.inner, model.point, gain_by)
    }
}
