//! Methods whose work is done by the package's Python half, with other packages.

use pyo3::call::PyCallArgs;
use pyo3::prelude::*;

/// The Python module that knows the tables of other packages.
pub const FRAMES: &str = "gtfdi._frames";

/// What a function of the package's Python half returns.
pub fn call<'py>(
    py: Python<'py>,
    module: &str,
    function: &str,
    arguments: impl PyCallArgs<'py>,
) -> PyResult<Bound<'py, PyAny>> {
    py.import(module)?.call_method1(function, arguments)
}
