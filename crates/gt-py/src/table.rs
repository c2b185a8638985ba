//! Tables of criteria: sequences of dictionaries.

use pyo3::exceptions::PyIndexError;
use pyo3::prelude::*;
use pyo3::types::PyIterator;
use serde::Serialize;

use crate::array::json_out;
use crate::error::Failure;

/// One row; Python counts from 0 and ends an iteration by an `IndexError`.
pub fn row<'py, T: Serialize>(
    py: Python<'py>,
    what: &'static str,
    rows: &[T],
    index: isize,
) -> Result<Bound<'py, PyAny>, Failure> {
    let found = usize::try_from(index).ok().and_then(|at| rows.get(at));
    let Some(row) = found else {
        let count = rows.len();
        return Err(PyIndexError::new_err(format!(
            "row of the {what}: expected an index below {count}, found {index}"
        ))
        .into());
    };
    json_out(py, what, row)
}

/// All rows.
pub fn rows<'py, T: Serialize>(
    py: Python<'py>,
    what: &'static str,
    rows: &[T],
) -> Result<Bound<'py, PyIterator>, Failure> {
    Ok(json_out(py, what, rows)?.try_iter()?)
}
