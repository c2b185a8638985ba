//! What a caller should know though a call succeeds.

use pyo3::exceptions::PyUserWarning;
use pyo3::prelude::*;

/// Issues a `UserWarning` at the caller's line.
pub fn warn(py: Python<'_>, text: &str) -> PyResult<()> {
    let category = py.get_type::<PyUserWarning>();
    py.import("warnings")?
        .call_method1("warn", (text, category, 1))?;
    Ok(())
}
