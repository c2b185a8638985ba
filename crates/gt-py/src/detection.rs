//! `Detection`: what a bank says of a record.

use gtfdi::fdi::BankRun;
use numpy::{PyArray1, PyArray2};
use pyo3::prelude::*;

use crate::array::{json_out, samples_out};
use crate::error::Failure;
use crate::interop::{FRAMES, call};
use crate::pickle::{Reduced, pickle_inner, reduce};

/// What a bank says of a record.
#[pyclass(frozen, name = "Detection", module = "gtfdi")]
pub struct PyDetection {
    pub inner: BankRun,
}

#[pymethods]
impl PyDetection {
    /// Times of the samples in seconds, an array (N,).
    #[getter]
    fn time_s<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<f64>> {
        PyArray1::from_slice(py, &self.inner.time_s)
    }

    /// Tags of the outputs, the columns of ``residuals``.
    #[getter]
    fn outputs(&self) -> Vec<String> {
        self.inner.outputs.clone()
    }

    /// Residuals, an array (N, ny), in the outputs' units, settling included; NaN where a sample is
    /// missing.
    #[getter]
    fn residuals<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray2<f64>>> {
        samples_out(py, self.inner.residuals.clone())
    }

    /// Names of the tests, the columns of ``statistics``.
    #[getter]
    fn tests(&self) -> Vec<String> {
        self.inner.tests.clone()
    }

    /// The statistics, an array (N, number of tests); NaN where nothing is judged.
    #[getter]
    fn statistics<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray2<f64>>> {
        samples_out(py, self.inner.statistics.clone())
    }

    /// The alarms in order of time: dictionaries with ``time_s``, ``first_exceedance_s``,
    /// ``onset_s`` and ``deviation`` (``None`` where the statistic does not tell), ``end_s``
    /// (``None`` while it lasts), ``tag``, ``residual``, ``statistic`` and ``threshold``.
    #[getter]
    fn alarms<'py>(&self, py: Python<'py>) -> Result<Bound<'py, PyAny>, Failure> {
        json_out(py, "alarms", &self.inner.alarms)
    }

    /// For each test the share of its judged samples above the limit, an array.
    #[getter]
    fn share_above_limit<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<f64>> {
        PyArray1::from_slice(py, &self.inner.share_above_limit)
    }

    fn __repr__(&self) -> String {
        format!(
            "Detection({} samples, outputs: {}, {} alarms)",
            self.inner.time_s.len(),
            self.inner.outputs.join(", "),
            self.inner.alarms.len()
        )
    }

    /// A ``pandas.DataFrame`` with the time in seconds as its index and the columns ``residual TAG``
    /// and ``statistic TEST``; units
    /// are in its ``attrs``.
    ///
    /// Needs the package ``pandas`` (``pip install 'gtfdi[pandas]'``).
    ///
    /// Examples
    /// --------
    /// >>> bank.detect(run.measured).to_pandas().index.name
    /// 'time_s'
    fn to_pandas<'py>(slf: &Bound<'py, Self>) -> PyResult<Bound<'py, PyAny>> {
        call(slf.py(), FRAMES, "to_pandas", (slf,))
    }

    /// A ``polars.DataFrame`` with the column ``time_s`` and those of ``to_pandas``.
    ///
    /// Needs the package ``polars`` (``pip install 'gtfdi[polars]'``).
    ///
    /// Examples
    /// --------
    /// >>> bank.detect(run.measured).to_polars().columns[0]
    /// 'time_s'
    fn to_polars<'py>(slf: &Bound<'py, Self>) -> PyResult<Bound<'py, PyAny>> {
        call(slf.py(), FRAMES, "to_polars", (slf,))
    }

    /// The columns of ``to_polars`` as an Arrow stream, for anything that reads the PyCapsule
    /// interface: ``pyarrow.table``, ``polars.DataFrame``, DuckDB.
    ///
    /// Needs the package ``pyarrow`` (``pip install 'gtfdi[arrow]'``).
    ///
    /// Examples
    /// --------
    /// >>> import pyarrow
    /// >>> pyarrow.table(bank.detect(run.measured)).column_names[0]
    /// 'time_s'
    #[pyo3(signature = (requested_schema=None))]
    fn __arrow_c_stream__<'py>(
        slf: &Bound<'py, Self>,
        requested_schema: Option<&Bound<'py, PyAny>>,
    ) -> PyResult<Bound<'py, PyAny>> {
        call(slf.py(), FRAMES, "arrow_stream", (slf, requested_schema))
    }

    fn __reduce__<'py>(&self, py: Python<'py>) -> Result<Reduced<'py>, Failure> {
        reduce(py, self)
    }
}

pickle_inner!(PyDetection, BankRun);
