//! `Verdict` and `VerdictSeries`: what a detector says of samples.

use std::sync::Arc;

use gtfdi::fdi::{ChannelVerdict, Verdict};
use numpy::{Element, PyArray1, PyArray2};
use pyo3::prelude::*;
use serde::{Deserialize, Serialize};

use crate::array::table_out;
use crate::error::Failure;
use crate::interop::{FRAMES, call};
use crate::pickle::{Pickled, Reduced, pickle_inner, reduce};

/// What the detector says of one sample; each array has an entry for every test.
#[pyclass(frozen, name = "Verdict", module = "gtfdi")]
pub struct PyVerdict {
    inner: Verdict,
    tests: Arc<[String]>,
}

impl Pickled for PyVerdict {
    type Stored = (Verdict, Vec<String>);

    fn stored(&self) -> Result<Self::Stored, Failure> {
        Ok((self.inner.clone(), self.tests.to_vec()))
    }

    fn restored((inner, tests): Self::Stored) -> Result<Self, Failure> {
        Ok(Self::new(inner, tests.into()))
    }
}

impl PyVerdict {
    pub fn new(inner: Verdict, tests: Arc<[String]>) -> Self {
        Self { inner, tests }
    }

    fn array<'py, T: Element>(
        &self,
        py: Python<'py>,
        value: impl Fn(&ChannelVerdict) -> T,
    ) -> Bound<'py, PyArray1<T>> {
        PyArray1::from_vec(py, self.inner.channels.iter().map(value).collect())
    }
}

#[pymethods]
impl PyVerdict {
    /// Names of the tests, in the order of the arrays.
    #[getter]
    fn tests(&self) -> Vec<String> {
        self.tests.to_vec()
    }

    /// Time of the sample in seconds.
    #[getter]
    fn time_s(&self) -> f64 {
        self.inner.time_s
    }

    /// Whether samples are missing before this one, so that every generator started afresh.
    #[getter]
    fn gap(&self) -> bool {
        self.inner.gap
    }

    /// Residuals: in the output's unit where a test watches one output as it is, in standard
    /// deviations where it is whitened, the norm where it watches several; NaN where one is missing.
    #[getter]
    fn residual<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<f64>> {
        self.array(py, |channel| channel.residual)
    }

    /// The statistics, which are compared with the limits; NaN where nothing is judged.
    #[getter]
    fn statistic<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<f64>> {
        self.array(py, |channel| channel.statistic)
    }

    /// The likeliest deviations of the residuals' means, in the outputs' units; NaN where the
    /// statistic does not tell or is within its limit.
    #[getter]
    fn deviation<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<f64>> {
        self.array(py, |channel| channel.deviation.unwrap_or(f64::NAN))
    }

    /// Whether the residual is above the limit.
    #[getter]
    fn exceeds<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<bool>> {
        self.array(py, |channel| channel.exceeds)
    }

    /// Samples above the limit in a row, this one included.
    #[getter]
    fn run_length<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<usize>> {
        self.array(py, |channel| channel.run_length)
    }

    /// Whether an alarm is up.
    #[getter]
    fn alarm<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<bool>> {
        self.array(py, |channel| channel.alarm)
    }

    /// Whether the alarm came up with this sample.
    #[getter]
    fn new_alarm<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<bool>> {
        self.array(py, |channel| channel.new_alarm)
    }

    /// Time of the first sample of the present run above the limit; NaN outside a run.
    #[getter]
    fn first_exceedance_s<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<f64>> {
        self.array(py, |channel| channel.first_exceedance_s.unwrap_or(f64::NAN))
    }

    /// Whether the generator has not yet forgotten its initial state.
    #[getter]
    fn settling<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<bool>> {
        self.array(py, |channel| channel.settling)
    }

    fn __repr__(&self) -> String {
        let up = self.tests.iter().zip(&self.inner.channels);
        let up: Vec<&str> = up
            .filter(|(_, channel)| channel.alarm)
            .map(|(tag, _)| tag.as_str())
            .collect();
        let up = if up.is_empty() {
            "none".to_owned()
        } else {
            up.join(", ")
        };
        format!("Verdict(at {} s, alarms: {up})", self.inner.time_s)
    }

    fn __reduce__<'py>(&self, py: Python<'py>) -> Result<Reduced<'py>, Failure> {
        reduce(py, self)
    }
}

/// What the detector says of many samples; arrays have a row a sample and a column a test.
#[pyclass(frozen, name = "VerdictSeries", module = "gtfdi")]
pub struct PyVerdictSeries {
    inner: Series,
}

/// Verdicts, column by column.
#[derive(Clone, Serialize, Deserialize)]
pub struct Series {
    tests: Vec<String>,
    time_s: Vec<f64>,
    gap: Vec<bool>,
    /// Those of the first sample, then those of the second.
    channels: Vec<ChannelVerdict>,
}

impl Series {
    /// None yet, and room for so many.
    pub fn new(tests: &[String], count: usize) -> Self {
        Self {
            tests: tests.to_vec(),
            time_s: Vec::with_capacity(count),
            gap: Vec::with_capacity(count),
            channels: Vec::with_capacity(count * tests.len()),
        }
    }

    /// One more.
    pub fn push(&mut self, verdict: &Verdict) {
        self.time_s.push(verdict.time_s);
        self.gap.push(verdict.gap);
        self.channels.extend_from_slice(&verdict.channels);
    }
}

impl From<Series> for PyVerdictSeries {
    fn from(inner: Series) -> Self {
        Self { inner }
    }
}

pickle_inner!(PyVerdictSeries, Series);

impl PyVerdictSeries {
    fn table<'py, T: Element>(
        &self,
        py: Python<'py>,
        value: impl Fn(&ChannelVerdict) -> T,
    ) -> PyResult<Bound<'py, PyArray2<T>>> {
        let values = self.inner.channels.iter().map(value).collect();
        table_out(py, values, self.inner.tests.len())
    }
}

#[pymethods]
impl PyVerdictSeries {
    /// Names of the tests, in the order of the arrays.
    #[getter]
    fn tests(&self) -> Vec<String> {
        self.inner.tests.clone()
    }

    /// Times of the samples in seconds (N,).
    #[getter]
    fn time_s<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<f64>> {
        PyArray1::from_slice(py, &self.inner.time_s)
    }

    /// Whether samples are missing before each (N,).
    #[getter]
    fn gap<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<bool>> {
        PyArray1::from_slice(py, &self.inner.gap)
    }

    /// Residuals, as those of one ``Verdict``.
    #[getter]
    fn residual<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray2<f64>>> {
        self.table(py, |channel| channel.residual)
    }

    /// The statistics, which are compared with the limits; NaN where nothing is judged.
    #[getter]
    fn statistic<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray2<f64>>> {
        self.table(py, |channel| channel.statistic)
    }

    /// Whether the residual is above the limit (a column a test).
    #[getter]
    fn exceeds<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray2<bool>>> {
        self.table(py, |channel| channel.exceeds)
    }

    /// Whether an alarm is up (a column a test).
    #[getter]
    fn alarm<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray2<bool>>> {
        self.table(py, |channel| channel.alarm)
    }

    /// Whether the alarm came up with the sample (a column a test).
    #[getter]
    fn new_alarm<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray2<bool>>> {
        self.table(py, |channel| channel.new_alarm)
    }

    /// Time of the first sample of the present run above the limit (a column a test); NaN outside a run.
    #[getter]
    fn first_exceedance_s<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray2<f64>>> {
        self.table(py, |channel| channel.first_exceedance_s.unwrap_or(f64::NAN))
    }

    /// Whether the generator has not yet forgotten its initial state (a column a test).
    #[getter]
    fn settling<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray2<bool>>> {
        self.table(py, |channel| channel.settling)
    }

    fn __len__(&self) -> usize {
        self.inner.time_s.len()
    }

    /// A ``pandas.DataFrame`` with the time in seconds as its index and the columns ``gap`` and, for
    /// each test, ``residual TEST``, ``statistic``, ``exceeds``, ``alarm`` and ``settling``; units
    /// are in its ``attrs``.
    ///
    /// Needs the package ``pandas`` (``pip install 'gtfdi[pandas]'``).
    ///
    /// Examples
    /// --------
    /// >>> bank.detector().process(run.measured).to_pandas().index.name
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
    /// >>> bank.detector().process(run.measured).to_polars().columns[0]
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
    /// >>> pyarrow.table(bank.detector().process(run.measured)).column_names[0]
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
