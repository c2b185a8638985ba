//! `FreeRun`: what a model says without seeing the outputs.

use gtfdi::ident::FreeRun;
use numpy::PyArray2;
use pyo3::prelude::*;

use crate::array::samples_out;
use crate::error::Failure;
use crate::pickle::{Reduced, pickle_inner, reduce};

/// The outputs of a model that sees only the inputs.
#[pyclass(frozen, name = "FreeRun", module = "gtfdi")]
pub struct PyFreeRun {
    pub inner: FreeRun,
}

#[pymethods]
impl PyFreeRun {
    /// Outputs, an array (N, ny); NaN from where an output diverged.
    #[getter]
    fn y<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray2<f64>>> {
        samples_out(py, self.inner.y.clone())
    }

    /// For each output the sample from which it diverged, or ``None``.
    #[getter]
    fn diverges_at(&self) -> Vec<Option<usize>> {
        self.inner.diverges_at.clone()
    }

    /// Whether any output diverged.
    #[getter]
    fn diverged(&self) -> bool {
        self.inner.diverges_at.iter().any(Option::is_some)
    }

    fn __reduce__<'py>(&self, py: Python<'py>) -> Result<Reduced<'py>, Failure> {
        reduce(py, self)
    }
}

pickle_inner!(PyFreeRun, FreeRun);
