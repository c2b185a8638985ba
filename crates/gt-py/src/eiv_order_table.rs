//! `eiv_order_table` and `EivOrderTable`: the criteria of errors-in-variables orders.

use gtfdi::ident::eiv::{EivOrderTable, eiv_order_table_until};
use pyo3::prelude::*;
use pyo3::types::{PyDict, PyIterator};

use crate::dataset::Names;
use crate::error::Failure;
use crate::interrupt::interruptible;
use crate::order::{Numbers, lags_of_each, range};
use crate::pickle::{Reduced, pickle_inner, reduce};
use crate::record::Given;
use crate::table::{row, rows};

/// The criteria of several errors-in-variables orders, all from one spectrum of the record; a
/// sequence of dictionaries with the keys ``order``, ``parameters``, ``criterion``, ``aic``,
/// ``bic`` and ``converged``.
#[pyclass(frozen, sequence, eq, name = "EivOrderTable", module = "gtfdi")]
#[derive(PartialEq)]
pub struct PyEivOrderTable {
    pub inner: EivOrderTable,
}

#[pymethods]
impl PyEivOrderTable {
    /// Samples of the record.
    #[getter]
    fn samples(&self) -> usize {
        self.inner.samples
    }

    /// Order of the autoregression behind the spectrum.
    #[getter]
    fn autoregression_order(&self) -> usize {
        self.inner.autoregression_order
    }

    /// Frequencies at which the likelihood was taken.
    #[getter]
    fn frequencies(&self) -> usize {
        self.inner.frequencies
    }

    /// The best order by each criterion: a dictionary with ``aic`` and ``bic``. AIC takes too high
    /// an order in about half of all records; BIC is the one to use.
    #[getter]
    fn best<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        let best = PyDict::new(py);
        best.set_item("aic", self.inner.best_aic())?;
        best.set_item("bic", self.inner.best_bic())?;
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

/// The likelihood's criteria of several errors-in-variables orders.
///
/// Parameters
/// ----------
/// u, y, nk, sample_time_s, inputs, outputs
///     As for ``gtfdi.eiv``.
/// orders : tuple of int
///     Lowest and highest order.
///
/// Returns
/// -------
/// EivOrderTable
///
/// Examples
/// --------
/// >>> table = gtfdi.eiv_order_table(u[:500], y[:500], orders=(1, 2))
/// >>> [row["parameters"] for row in table]
/// [3, 6]
#[pyfunction]
#[pyo3(name = "eiv_order_table", signature = (u, y=None, orders=(1, 6), *, nk=None,
    sample_time_s=None, inputs=None, outputs=None),
    text_signature = "(u, y=None, orders=(1, 6), *, nk=1, sample_time_s=None, inputs=None, \
    outputs=None)")]
pub fn py_eiv_order_table(
    u: &Bound<'_, PyAny>,
    y: Option<&Bound<'_, PyAny>>,
    orders: (i64, i64),
    nk: Option<Numbers>,
    sample_time_s: Option<f64>,
    inputs: Option<Names>,
    outputs: Option<Names>,
) -> Result<PyEivOrderTable, Failure> {
    let data = Given::new(u, y)?.unknown(inputs, outputs, sample_time_s)?;
    let orders = range(orders)?;
    let nk = lags_of_each(nk, data.nu());
    let inner = interruptible(u.py(), move |abandoned| {
        Ok(eiv_order_table_until(&data, orders, &nk, abandoned)?)
    })?;
    Ok(PyEivOrderTable { inner })
}

pickle_inner!(PyEivOrderTable, EivOrderTable);
