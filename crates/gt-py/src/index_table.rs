//! `index_table` and `IndexTable`: the criteria of canonical indices.

use gtfdi::ident::{IndexTable, index_table};
use pyo3::prelude::*;
use pyo3::types::{PyDict, PyIterator};

use crate::array::json_out;
use crate::dataset::Names;
use crate::error::Failure;
use crate::interrupt::interruptible;
use crate::order::range;
use crate::pickle::{Reduced, pickle_inner, reduce};
use crate::record::Given;
use crate::table::{row, rows};

/// The criteria of several sets of canonical indices on one window; a sequence of dictionaries with
/// the keys ``indices``, ``order``, ``parameters``, ``ln_det``, ``aic``, ``mdl`` and ``condition``.
#[pyclass(frozen, sequence, name = "IndexTable", module = "gtfdi")]
pub struct PyIndexTable {
    inner: IndexTable,
}

#[pymethods]
impl PyIndexTable {
    /// Rows of the window that all sets share.
    #[getter]
    fn window_rows(&self) -> usize {
        self.inner.window_rows
    }

    /// The best row by each criterion: a dictionary with ``aic`` and ``mdl``.
    #[getter]
    fn best<'py>(&self, py: Python<'py>) -> Result<Bound<'py, PyDict>, Failure> {
        let best = PyDict::new(py);
        best.set_item("aic", json_out(py, "index table", self.inner.best_aic())?)?;
        best.set_item("mdl", json_out(py, "index table", self.inner.best_mdl())?)?;
        Ok(best)
    }

    fn __iter__<'py>(&self, py: Python<'py>) -> Result<Bound<'py, PyIterator>, Failure> {
        rows(py, "index table", &self.inner.rows)
    }

    fn __len__(&self) -> usize {
        self.inner.rows.len()
    }

    fn __getitem__<'py>(
        &self,
        py: Python<'py>,
        index: isize,
    ) -> Result<Bound<'py, PyAny>, Failure> {
        row(py, "index table", &self.inner.rows, index)
    }

    fn __reduce__<'py>(&self, py: Python<'py>) -> Result<Reduced<'py>, Failure> {
        reduce(py, self)
    }
}

/// The criteria of canonical structures of several orders, for all sets of indices near the generic
/// ones, all on the same rows.
///
/// Parameters
/// ----------
/// u, y, sample_time_s, inputs, outputs
///     As for ``gtfdi.order_table``.
/// orders : tuple of int
///     Lowest and highest order, the sum of the indices; at least the number of outputs.
/// spread : int, default 1
///     How far an index may be from the generic one.
/// feedthrough : bool, default False
///     Whether ``u(t)`` acts on ``y(t)``.
///
/// Returns
/// -------
/// IndexTable
///
/// Examples
/// --------
/// >>> table = gtfdi.index_table(run.measured.select(["a_v"], ["t3", "p7"]), orders=(2, 4))
/// >>> [row["indices"] for row in table if row["order"] == 4]
/// [[2, 2], [1, 3], [3, 1]]
#[pyfunction]
#[pyo3(name = "index_table", signature = (u, y=None, *, orders, spread=1, feedthrough=false,
    sample_time_s=None, inputs=None, outputs=None))]
#[allow(clippy::too_many_arguments)] // Python names them
pub fn py_index_table(
    u: &Bound<'_, PyAny>,
    y: Option<&Bound<'_, PyAny>>,
    orders: (i64, i64),
    spread: usize,
    feedthrough: bool,
    sample_time_s: Option<f64>,
    inputs: Option<Names>,
    outputs: Option<Names>,
) -> Result<PyIndexTable, Failure> {
    let data = Given::new(u, y)?.unknown(inputs, outputs, sample_time_s)?;
    let orders = range(orders)?;
    let inner = interruptible(u.py(), move |_| {
        Ok(index_table(&data, orders, spread, feedthrough)?)
    })?;
    Ok(PyIndexTable { inner })
}

pickle_inner!(PyIndexTable, IndexTable);
