//! `LinearResidual`: residuals of any linear form.

use gtfdi::fdi::LinearResidual;
use numpy::PyArray2;
use pyo3::prelude::*;
use pyo3::types::{PyDict, PyType};

use crate::array::{json_text, json_value, pair_out, samples_out};
use crate::dataset::names;
use crate::error::Failure;
use crate::observer::{Model, model_and_point};
use crate::pickle::{Reduced, pickle_inner, reduce};
use crate::record::Given;
use crate::state_space::PyStateSpace;

/// Residuals r as a stable linear system driven by the deviations of inputs and outputs from their
/// operating point: ``z(t+1) = A z + B [u - u0; y - y0]``, ``r(t) = C z + D [u - u0; y - y0]``.
///
/// Parameters
/// ----------
/// system : StateSpace
///     From the inputs and, after them, the outputs of the plant to the residuals.
/// point : tuple of array_like
///     Operating point ``(u0, y0)``; its sizes say which inputs of the system are which.
///
/// Raises
/// ------
/// DimensionError
///     The system has another number of inputs than the point has channels.
/// DesignError
///     The point is not finite, a tag stands twice, or the system does not settle.
///
/// Examples
/// --------
/// The output less what a static gain of 2 makes of the input.
///
/// >>> system = gtfdi.StateSpace(
/// ...     np.zeros((0, 0)), np.zeros((0, 2)), np.zeros((1, 0)), [[-2.0, 1.0]], 1.0,
/// ...     inputs=["u", "y"], outputs="r",
/// ... )
/// >>> parity = gtfdi.LinearResidual(system, point=([0.0], [0.0]))
/// >>> parity.residuals([1.0, 1.0], [2.0, 2.5]).ravel()
/// array([0. , 0.5])
#[pyclass(frozen, eq, name = "LinearResidual", module = "gtfdi")]
#[derive(PartialEq)]
pub struct PyLinearResidual {
    pub inner: LinearResidual,
}

#[pymethods]
impl PyLinearResidual {
    #[new]
    fn py_new(
        system: Bound<'_, PyStateSpace>,
        point: (Bound<'_, PyAny>, Bound<'_, PyAny>),
    ) -> Result<Self, Failure> {
        let (system, point) = model_and_point(Model::StateSpace(system), Some(point))?;
        let inner = LinearResidual::new(system, point)?;
        Ok(Self { inner })
    }

    /// The residuals of a record, an array (N, nr), from the initial state zero; the first
    /// ``settle_samples`` of them hold the initial transient. A sample without a valid input or
    /// output gives NaN and begins a new transient.
    #[pyo3(signature = (u, y=None))]
    fn residuals<'py>(
        &self,
        u: &Bound<'py, PyAny>,
        y: Option<&Bound<'py, PyAny>>,
    ) -> Result<Bound<'py, PyArray2<f64>>, Failure> {
        residuals_of(&self.inner, u, y)
    }

    /// The system from ``[u - u0; y - y0]`` to the residuals (StateSpace).
    #[getter]
    fn system(&self) -> PyStateSpace {
        PyStateSpace {
            inner: self.inner.system().clone(),
        }
    }

    /// The operating point, a dictionary of arrays ``u`` and ``y``.
    #[getter]
    fn point<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        let point = self.inner.point();
        pair_out(py, &point.u, &point.y)
    }

    /// Tags of the measured inputs.
    #[getter]
    fn inputs(&self) -> Vec<String> {
        names(self.inner.inputs())
    }

    /// Tags of the measured outputs.
    #[getter]
    fn outputs(&self) -> Vec<String> {
        names(self.inner.outputs())
    }

    /// Names of the residuals.
    #[getter]
    fn residual_names(&self) -> Vec<String> {
        names(self.inner.residual_signals())
    }

    /// Samples after which a wrong initial state is forgotten.
    #[getter]
    fn settle_samples(&self) -> usize {
        self.inner.settle_samples()
    }

    /// The generator as JSON.
    fn to_json(&self) -> Result<String, Failure> {
        json_text("residual generator", &self.inner)
    }

    /// A generator from the JSON that ``to_json`` gave; it is checked.
    #[classmethod]
    fn from_json(_class: &Bound<'_, PyType>, text: &str) -> Result<Self, Failure> {
        let inner = json_value("residual generator", text)?;
        Ok(Self { inner })
    }

    fn __reduce__<'py>(&self, py: Python<'py>) -> Result<Reduced<'py>, Failure> {
        reduce(py, self)
    }

    fn __repr__(&self) -> String {
        format!(
            "LinearResidual(residuals: {}, outputs: {}, inputs: {})",
            self.residual_names().join(", "),
            self.outputs().join(", "),
            self.inputs().join(", ")
        )
    }
}

pickle_inner!(PyLinearResidual, LinearResidual);

/// The residuals (N, nr) of a record as it is given.
pub fn residuals_of<'py>(
    generator: &LinearResidual,
    u: &Bound<'py, PyAny>,
    y: Option<&Bound<'py, PyAny>>,
) -> Result<Bound<'py, PyArray2<f64>>, Failure> {
    let given = Given::new(u, y)?;
    let (inputs, outputs) = (generator.inputs(), generator.outputs());
    let data = given.known(inputs, outputs, generator.sample_time_s())?;
    let residuals = u.py().detach(|| generator.residuals(&data))?;
    Ok(samples_out(u.py(), residuals)?)
}
