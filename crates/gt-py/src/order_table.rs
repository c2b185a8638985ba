//! `order_table` and `OrderTable`: the criteria of ARX orders.

use gtfdi::ident::{OrderTable, order_table};
use pyo3::prelude::*;
use pyo3::types::{PyDict, PyIterator};

use crate::arx_structure::Kind;
use crate::dataset::Names;
use crate::error::Failure;
use crate::interrupt::interruptible;
use crate::order::{Numbers, range, smallest_lags};
use crate::pickle::{Reduced, pickle_inner, reduce};
use crate::record::Given;
use crate::table::{row, rows};

/// The criteria of several orders on one window; a sequence of dictionaries with the keys
/// ``order``, ``parameters``, ``residual_variance``, ``ln_det``, ``aic``, ``mdl``, ``fpe``,
/// ``ppcre_percent`` and ``condition``.
#[pyclass(frozen, sequence, name = "OrderTable", module = "gtfdi")]
pub struct PyOrderTable {
    pub inner: OrderTable,
}

#[pymethods]
impl PyOrderTable {
    /// Rows of the window that all orders share.
    #[getter]
    fn window_rows(&self) -> usize {
        self.inner.window_rows
    }

    /// The best order by each criterion: a dictionary with ``aic``, ``mdl`` and ``fpe``.
    #[getter]
    fn best<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        let best = PyDict::new(py);
        best.set_item("aic", self.inner.best_aic())?;
        best.set_item("mdl", self.inner.best_mdl())?;
        best.set_item("fpe", self.inner.best_fpe())?;
        Ok(best)
    }

    fn __iter__<'py>(&self, py: Python<'py>) -> Result<Bound<'py, PyIterator>, Failure> {
        rows(py, "order table", &self.inner.rows)
    }

    fn __len__(&self) -> usize {
        self.inner.rows.len()
    }

    fn __getitem__<'py>(
        &self,
        py: Python<'py>,
        index: isize,
    ) -> Result<Bound<'py, PyAny>, Failure> {
        row(py, "order table", &self.inner.rows, index)
    }

    fn __reduce__<'py>(&self, py: Python<'py>) -> Result<Reduced<'py>, Failure> {
        reduce(py, self)
    }
}

/// The criteria of several orders, all on the same rows.
///
/// Parameters
/// ----------
/// u, y, structure, nk, sample_time_s, inputs, outputs
///     As for ``gtfdi.arx``.
/// orders : tuple of int
///     Lowest and highest order; a canonical one is at least the number of outputs.
///
/// Returns
/// -------
/// OrderTable
///
/// Examples
/// --------
/// >>> gtfdi.order_table(u, y, orders=(1, 12)).best["mdl"]
/// 5
#[pyfunction]
#[pyo3(name = "order_table", signature = (u, y=None, orders=(1, 12), *, structure=None, nk=None,
    sample_time_s=None, inputs=None, outputs=None),
    text_signature = "(u, y=None, orders=(1, 12), *, structure=None, nk=1, sample_time_s=None, \
    inputs=None, outputs=None)")]
#[allow(clippy::too_many_arguments)] // Python names them
pub fn py_order_table(
    u: &Bound<'_, PyAny>,
    y: Option<&Bound<'_, PyAny>>,
    orders: (i64, i64),
    structure: Option<&str>,
    nk: Option<Numbers>,
    sample_time_s: Option<f64>,
    inputs: Option<Names>,
    outputs: Option<Names>,
) -> Result<PyOrderTable, Failure> {
    let data = Given::new(u, y)?.unknown(inputs, outputs, sample_time_s)?;
    let kind = match structure {
        Some(name) => Kind::read(name)?,
        None if data.ny() > 1 => Kind::Canonical,
        None => Kind::Full,
    };
    let family = kind.family(smallest_lags(nk))?;
    let orders = range(orders)?;
    let orders = family.searched(orders, data.ny())?;
    let inner = interruptible(u.py(), move |_| Ok(order_table(&data, orders, &family)?))?;
    Ok(PyOrderTable { inner })
}

pickle_inner!(PyOrderTable, OrderTable);
