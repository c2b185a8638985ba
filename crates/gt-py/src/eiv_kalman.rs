//! `EivKalman`: the filter of a model whose inputs are measured with noise too.

use gtfdi::core::OperatingPoint;
use gtfdi::fdi::EivKalman;
use nalgebra::DVector;
use numpy::PyArray2;
use pyo3::prelude::*;
use pyo3::types::{IntoPyDict, PyDict};

use crate::array::{matrix_out, pair_out, samples_out, vector};
use crate::dataset::names;
use crate::error::Failure;
use crate::filter_run::{PyFilterRun, filter_run};
use crate::observer::{Model, model_and_point};
use crate::pickle::{Pickled, Reduced, reduce};
use crate::state_space::PyStateSpace;

/// The steady Kalman filter of a model whose measured inputs and outputs have white noise, and what
/// it says of the channels without noise.
///
/// ``gtfdi.kalman`` makes the same filter as a residual generator.
///
/// Parameters
/// ----------
/// model : StateSpace or OutputModel
///     The model.
/// input_variances, output_variances : array_like, shapes (nu,) and (ny,)
///     Variances of the noise of each channel, in squared units; those of an EivModel are in its
///     ``noise_variances``.
/// point : tuple of array_like, optional
///     Operating point ``(u0, y0)``; that of the OutputModel, or zero.
///
/// Raises
/// ------
/// DesignError
///     A variance is negative, or the model has no stabilising filter for this noise.
///
/// Examples
/// --------
/// A flow into a tank, both measured with noise; the level tells most of itself and some of the
/// flow a sample earlier.
///
/// >>> tank = gtfdi.StateSpace([[0.9]], [[1.0]], [[1.0]], [[0.0]], 1.0)
/// >>> filter = gtfdi.EivKalman(tank, [1.0], [0.1])
/// >>> bool(filter.output_error_covariance[0, 0] < 0.1)
/// True
/// >>> filter.input_error_covariance, bool(filter.smoothed_input_error_covariance[0, 0] < 0.2)
/// (array([[1.]]), True)
#[pyclass(frozen, name = "EivKalman", module = "gtfdi")]
pub struct PyEivKalman {
    inner: EivKalman,
    point: OperatingPoint,
    input_variances: DVector<f64>,
    output_variances: DVector<f64>,
}

#[pymethods]
impl PyEivKalman {
    #[new]
    #[pyo3(signature = (model, input_variances, output_variances, point=None))]
    fn py_new(
        model: Model<'_>,
        input_variances: &Bound<'_, PyAny>,
        output_variances: &Bound<'_, PyAny>,
        point: Option<(Bound<'_, PyAny>, Bound<'_, PyAny>)>,
    ) -> Result<Self, Failure> {
        let (model, point) = model_and_point(model, point)?;
        let inputs = vector(input_variances, "input_variances")?;
        let outputs = vector(output_variances, "output_variances")?;
        Self::restored((model, point, inputs, outputs))
    }

    /// Filters a record: innovations and states of every sample, as ``KalmanFilter.run``.
    ///
    /// Parameters
    /// ----------
    /// u, y
    ///     The record. A sample that is not finite stays in the state from there on.
    /// x0 : array_like, shape (nx,), optional
    ///     The state before the first sample; zero where left out.
    ///
    /// Returns
    /// -------
    /// FilterRun
    #[pyo3(signature = (u, y=None, x0=None))]
    fn run(
        &self,
        u: &Bound<'_, PyAny>,
        y: Option<&Bound<'_, PyAny>>,
        x0: Option<&Bound<'_, PyAny>>,
    ) -> Result<PyFilterRun, Failure> {
        let (_, inner) = filter_run(self.inner.filter(), &self.point, u, y, x0)?;
        Ok(PyFilterRun { inner })
    }

    /// The channels of a record without their noise, as well as the filter knows them; nothing is
    /// assumed of the inputs.
    ///
    /// Parameters
    /// ----------
    /// u, y
    ///     The record. A sample that is not finite stays in the state from there on.
    /// x0 : array_like, shape (nx,), optional
    ///     The state before the first sample; zero where left out.
    ///
    /// Returns
    /// -------
    /// dict
    ///     Arrays in the units of the channels: ``y`` (N, ny) and ``u`` (N, nu) from the samples up
    ///     to each, and ``u_smoothed`` (N, nu) from one sample more, when an input has acted on an
    ///     output even without a direct term; its last sample is that of ``u``.
    ///
    /// Examples
    /// --------
    /// >>> filter = gtfdi.EivKalman(model.output_model(0), [1e-4, 1e-6], [0.01])
    /// >>> {name: each.shape for name, each in filter.estimate(u, y).items()}
    /// {'u': (7500, 2), 'u_smoothed': (7500, 2), 'y': (7500, 1)}
    #[pyo3(signature = (u, y=None, x0=None))]
    fn estimate<'py>(
        &self,
        u: &Bound<'py, PyAny>,
        y: Option<&Bound<'py, PyAny>>,
        x0: Option<&Bound<'py, PyAny>>,
    ) -> Result<Bound<'py, PyDict>, Failure> {
        let py = u.py();
        let (data, run) = filter_run(self.inner.filter(), &self.point, u, y, x0)?;
        // What is added to the measured channels does not depend on the operating point.
        let inputs = self.inner.inputs(data.u(), &run)?;
        let smoothed = self.inner.smoothed_inputs(data.u(), &run)?;
        let outputs = self.inner.outputs(data.y(), &run)?;
        let entries = [
            ("u", samples_out(py, inputs)?),
            ("u_smoothed", samples_out(py, smoothed)?),
            ("y", samples_out(py, outputs)?),
        ];
        Ok(entries.into_py_dict(py)?)
    }

    /// The covariance of the error of the outputs of ``estimate``, an array (ny, ny).
    #[getter]
    fn output_error_covariance<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray2<f64>>> {
        matrix_out(py, &self.inner.output_error_covariance())
    }

    /// The covariance of the error of its ``u``, an array (nu, nu).
    #[getter]
    fn input_error_covariance<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray2<f64>>> {
        matrix_out(py, &self.inner.input_error_covariance())
    }

    /// The covariance of the error of its ``u_smoothed``, an array (nu, nu).
    #[getter]
    fn smoothed_input_error_covariance<'py>(
        &self,
        py: Python<'py>,
    ) -> PyResult<Bound<'py, PyArray2<f64>>> {
        matrix_out(py, &self.inner.smoothed_input_error_covariance())
    }

    /// The gain that corrects the state one step ahead, an array (nx, ny).
    #[getter]
    fn predictor_gain<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray2<f64>>> {
        matrix_out(py, self.inner.filter().predictor_gain())
    }

    /// The gain that corrects the state now, an array (nx, ny).
    #[getter]
    fn filter_gain<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray2<f64>>> {
        matrix_out(py, self.inner.filter().filter_gain())
    }

    /// The covariance of the innovations under the noise, an array (ny, ny).
    #[getter]
    fn innovation_covariance<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray2<f64>>> {
        matrix_out(py, &self.inner.filter().innovation_covariance())
    }

    /// The model (StateSpace).
    #[getter]
    fn model(&self) -> PyStateSpace {
        PyStateSpace {
            inner: self.inner.filter().model().clone(),
        }
    }

    /// The operating point, a dictionary of arrays ``u`` and ``y``.
    #[getter]
    fn point<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        pair_out(py, &self.point.u, &self.point.y)
    }

    fn __reduce__<'py>(&self, py: Python<'py>) -> Result<Reduced<'py>, Failure> {
        reduce(py, self)
    }

    fn __repr__(&self) -> String {
        let model = self.inner.filter().model();
        format!(
            "EivKalman(outputs: {}, inputs: {})",
            names(model.outputs()).join(", "),
            names(model.inputs()).join(", ")
        )
    }
}

impl Pickled for PyEivKalman {
    /// The model, the operating point, the variances of inputs and outputs.
    type Stored = (
        gtfdi::core::StateSpace,
        OperatingPoint,
        DVector<f64>,
        DVector<f64>,
    );

    fn stored(&self) -> Result<Self::Stored, Failure> {
        let model = self.inner.filter().model().clone();
        let (inputs, outputs) = (&self.input_variances, &self.output_variances);
        Ok((model, self.point.clone(), inputs.clone(), outputs.clone()))
    }

    fn restored(
        (model, point, input_variances, output_variances): Self::Stored,
    ) -> Result<Self, Failure> {
        let (inputs, outputs) = (input_variances.as_slice(), output_variances.as_slice());
        Ok(Self {
            inner: EivKalman::new(model, inputs, outputs)?,
            point,
            input_variances,
            output_variances,
        })
    }
}
