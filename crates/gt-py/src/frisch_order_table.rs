//! `frisch_order_table` and `FrischOrderTable`: what covariances say of the order.

use gtfdi::ident::frisch::{FrischOrderTable, frisch_order_table_until};
use pyo3::prelude::*;
use pyo3::types::PyIterator;

use crate::dataset::Names;
use crate::error::Failure;
use crate::interrupt::interruptible;
use crate::order::{Numbers, lags_of_each, range};
use crate::output_key::OutputKey;
use crate::pickle::{Reduced, pickle_inner, reduce};
use crate::record::Given;
use crate::table::{row, rows};

/// What the covariances of a record say of several orders of an output's relation, all on one
/// window; a sequence of dictionaries.
///
/// ``surface_gap``, ``yule_walker`` and ``rank_ratio`` are zero from the true order on with exact
/// covariances. ``statistic`` is near ``degrees_of_freedom`` at the true order and ``None`` where
/// the moments do not determine the relation, as beyond it; ``selection`` is the statistic minus
/// ``degrees_of_freedom`` times the logarithm of the rows, the smaller the better.
#[pyclass(frozen, sequence, eq, name = "FrischOrderTable", module = "gtfdi")]
#[derive(PartialEq)]
pub struct PyFrischOrderTable {
    inner: FrischOrderTable,
}

#[pymethods]
impl PyFrischOrderTable {
    /// Rows of the window that all orders share.
    #[getter]
    fn window_rows(&self) -> usize {
        self.inner.window_rows
    }

    /// The order of the least ``selection``, ``None`` where no order has one.
    #[getter]
    fn best(&self) -> Option<usize> {
        self.inner.best()
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

/// What the covariances of a record say of several errors-in-variables orders of one output.
///
/// Parameters
/// ----------
/// u, y, nk, sample_time_s, inputs, outputs
///     As for ``gtfdi.eiv``.
/// orders : tuple of int
///     Lowest and highest order.
/// output : int or str, default 0
///     The output, by position or tag.
///
/// Returns
/// -------
/// FrischOrderTable
///
/// Examples
/// --------
/// >>> table = gtfdi.frisch_order_table(u[:500], y[:500], orders=(1, 2))
/// >>> [row["degrees_of_freedom"] for row in table], table.window_rows
/// ([18, 15], 493)
#[pyfunction]
#[pyo3(name = "frisch_order_table", signature = (u, y=None, orders=(1, 6), *, output=None,
    nk=None, sample_time_s=None, inputs=None, outputs=None),
    text_signature = "(u, y=None, orders=(1, 6), *, output=0, nk=1, sample_time_s=None, \
    inputs=None, outputs=None)")]
#[allow(clippy::too_many_arguments)] // Python names them
pub fn py_frisch_order_table(
    u: &Bound<'_, PyAny>,
    y: Option<&Bound<'_, PyAny>>,
    orders: (i64, i64),
    output: Option<OutputKey>,
    nk: Option<Numbers>,
    sample_time_s: Option<f64>,
    inputs: Option<Names>,
    outputs: Option<Names>,
) -> Result<PyFrischOrderTable, Failure> {
    let data = Given::new(u, y)?.unknown(inputs, outputs, sample_time_s)?;
    let orders = range(orders)?;
    let nk = lags_of_each(nk, data.nu());
    let output = output.map_or(Ok(0), |output| output.index(data.outputs()))?;
    let inner = interruptible(u.py(), move |abandoned| {
        Ok(frisch_order_table_until(
            &data, output, orders, &nk, abandoned,
        )?)
    })?;
    Ok(PyFrischOrderTable { inner })
}

pickle_inner!(PyFrischOrderTable, FrischOrderTable);
