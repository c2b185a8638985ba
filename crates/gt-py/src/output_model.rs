//! `OutputModel`: a row of an ARX model in state space.

use gtfdi::ident::OutputModel;
use pyo3::prelude::*;
use pyo3::types::PyDict;

use crate::array::pair_out;
use crate::error::Failure;
use crate::pickle::{Reduced, pickle_inner, reduce};
use crate::state_space::PyStateSpace;

/// The row of one output as a state-space model; other outputs that it uses are inputs of it.
#[pyclass(frozen, name = "OutputModel", module = "gtfdi")]
pub struct PyOutputModel {
    pub inner: OutputModel,
}

#[pymethods]
impl PyOutputModel {
    /// The model, of deviations from ``point`` (StateSpace).
    #[getter]
    fn model(&self) -> PyStateSpace {
        PyStateSpace {
            inner: self.inner.model.clone(),
        }
    }

    /// The operating point, a dictionary of arrays ``u`` and ``y``.
    #[getter]
    fn point<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        pair_out(py, &self.inner.point.u, &self.inner.point.y)
    }

    fn __reduce__<'py>(&self, py: Python<'py>) -> Result<Reduced<'py>, Failure> {
        reduce(py, self)
    }
}

pickle_inner!(PyOutputModel, OutputModel);
