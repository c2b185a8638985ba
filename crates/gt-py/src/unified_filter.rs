//! `UnifiedFilter`: residuals that disturbances disturb least in proportion to what faults show.

use gtfdi::fdi::{LinearResidual, UnifiedFilter};
use numpy::PyArray2;
use pyo3::prelude::*;
use pyo3::types::PyDict;

use crate::array::matrix_out;
use crate::dataset::names;
use crate::error::Failure;
use crate::fault_model::PyFaultModel;
use crate::kalman::PyKalmanFilter;
use crate::linear_residual::{PyLinearResidual, residuals_of};
use crate::pickle::{Pickled, Reduced, reduce};
use crate::robustness::{band, robustness_out};
use crate::state_space::PyStateSpace;

/// The residual generator that bounded disturbances of unknown spectrum disturb least in proportion
/// to what it shows of faults (the unified solution of S. X. Ding, *Model-based fault diagnosis
/// techniques*, Springer 2013).
///
/// Disturbances reach its residuals with a gain of 1 at every frequency and in every direction, and
/// any other residual generator is a stable system after it. Of all generators it has the largest
/// ratio of the least gain of a fault, in any band, to the largest gain of a disturbance. Fewer
/// disturbances than outputs can be taken out altogether (UnknownInputObserver).
///
/// Parameters
/// ----------
/// model : FaultModel
///     The model with its disturbances.
///
/// Raises
/// ------
/// DesignError
///     There is no disturbance, some combination of outputs feels none, or a zero from the
///     disturbances to the outputs lies on the unit circle.
///
/// Examples
/// --------
/// >>> tank = gtfdi.StateSpace([[0.9]], [[1.0]], [[1.0]], [[0.0]], 1.0)
/// >>> faulty = gtfdi.FaultModel(tank, E_d=[[1.0, 0.0]], F_d=[[0.0, 0.5]], F_f=[[1.0]])
/// >>> unified = gtfdi.UnifiedFilter(faulty)
/// >>> round(gtfdi.peak_gain(unified.from_disturbance)["gain"], 6)
/// 1.0
/// >>> unified.robustness((0.0, 0.5))["fault_frequency_hz"]
/// 0.0
#[pyclass(frozen, name = "UnifiedFilter", module = "gtfdi")]
pub struct PyUnifiedFilter {
    inner: UnifiedFilter,
    residual: LinearResidual,
}

#[pymethods]
impl PyUnifiedFilter {
    #[new]
    fn py_new(model: &PyFaultModel) -> Result<Self, Failure> {
        let inner = UnifiedFilter::new(model.inner.clone())?;
        let residual = inner.residual(model.point.clone())?;
        Ok(Self { inner, residual })
    }

    /// The normalised residuals of a record, an array (N, ny), from the initial state zero; the
    /// first ``settle_samples`` of them hold the initial transient. A sample without a valid input
    /// or output gives NaN and begins a new transient.
    #[pyo3(signature = (u, y=None))]
    fn residuals<'py>(
        &self,
        u: &Bound<'py, PyAny>,
        y: Option<&Bound<'py, PyAny>>,
    ) -> Result<Bound<'py, PyArray2<f64>>, Failure> {
        residuals_of(&self.residual, u, y)
    }

    /// The filter as a system from measured inputs and outputs to normalised residuals
    /// (LinearResidual).
    #[getter]
    fn linear_residual(&self) -> PyLinearResidual {
        PyLinearResidual {
            inner: self.residual.clone(),
        }
    }

    /// The Kalman filter that it is (KalmanFilter): its innovations, times ``post_filter``, are the
    /// residuals.
    #[getter]
    fn kalman(&self) -> Result<PyKalmanFilter, Failure> {
        let inner = self.inner.generator(self.residual.point().clone())?;
        Ok(PyKalmanFilter { inner })
    }

    /// The matrix that normalises the innovations, an array (ny, ny): the inverse of the lower
    /// Cholesky factor of their covariance.
    #[getter]
    fn post_filter<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray2<f64>>> {
        matrix_out(py, self.inner.post_filter())
    }

    /// What disturbances do to the normalised residuals (StateSpace): its gain is 1 everywhere.
    #[getter(from_disturbance)]
    fn disturbance_response(&self) -> Result<PyStateSpace, Failure> {
        let inner = self.inner.from_disturbance()?;
        Ok(PyStateSpace { inner })
    }

    /// What faults do to the normalised residuals (StateSpace).
    #[getter(from_fault)]
    fn fault_response(&self) -> Result<PyStateSpace, Failure> {
        let inner = self.inner.from_fault()?;
        Ok(PyStateSpace { inner })
    }

    /// What the filter achieves on faults within a band of frequencies ``(low, high)`` in hertz,
    /// all where left out; a dictionary as of ``gtfdi.robustness``.
    ///
    /// Raises
    /// ------
    /// DesignError
    ///     The band is empty or reaches beyond half of the sampling frequency.
    #[pyo3(signature = (band_hz=None))]
    fn robustness<'py>(
        &self,
        py: Python<'py>,
        band_hz: Option<(f64, f64)>,
    ) -> Result<Bound<'py, PyDict>, Failure> {
        let band = band(band_hz, self.inner.model().model().sample_time_s());
        let found = py.detach(|| self.inner.robustness(band))?;
        Ok(robustness_out(py, &found)?)
    }

    /// Samples after which a wrong initial state is forgotten.
    #[getter]
    fn settle_samples(&self) -> usize {
        self.residual.settle_samples()
    }

    /// The model with its disturbances and faults (FaultModel).
    #[getter]
    fn model(&self) -> PyFaultModel {
        PyFaultModel {
            inner: self.inner.model().clone(),
            point: self.residual.point().clone(),
        }
    }

    fn __reduce__<'py>(&self, py: Python<'py>) -> Result<Reduced<'py>, Failure> {
        reduce(py, self)
    }

    fn __repr__(&self) -> String {
        format!(
            "UnifiedFilter(outputs: {}, inputs: {})",
            names(self.residual.outputs()).join(", "),
            names(self.residual.inputs()).join(", ")
        )
    }
}

impl Pickled for PyUnifiedFilter {
    /// What it is made of: the same filter, bit for bit, is made again.
    type Stored = <PyFaultModel as Pickled>::Stored;

    fn stored(&self) -> Result<Self::Stored, Failure> {
        self.model().stored()
    }

    fn restored(model: Self::Stored) -> Result<Self, Failure> {
        Self::py_new(&PyFaultModel::restored(model)?)
    }
}
