//! `ResidualReport`: are the one-step errors of a model white, and independent of past inputs?

use gtfdi::ident::{RecordOrigin, ResidualOptions, ResidualReport};
use numpy::{PyArray1, PyArray2, PyArray3, PyArrayMethods};
use pyo3::prelude::*;
use pyo3::types::{PyDict, PyList};

use crate::array::{json_out, table_out};
use crate::choice::named;
use crate::error::Failure;
use crate::pickle::{Reduced, pickle_inner, reduce};

/// The options of a test, as given.
pub fn options(lags: usize, significance: f64, origin: &str) -> Result<ResidualOptions, Failure> {
    let origins = [
        ("fresh", RecordOrigin::Fresh),
        ("fitted", RecordOrigin::Fitted),
    ];
    Ok(ResidualOptions {
        lags,
        significance,
        origin: named("origin", origin, &origins)?,
    })
}

/// The tests on the one-step errors of a model; ``ArxModel.test_residuals`` makes one.
///
/// A test is a dictionary with ``statistic``, ``degrees_of_freedom``, ``correction``, ``scale`` and
/// ``p_value``, or ``None`` where nothing was left to test.
#[pyclass(frozen, name = "ResidualReport", module = "gtfdi")]
pub struct PyResidualReport {
    pub inner: ResidualReport,
}

#[pymethods]
impl PyResidualReport {
    /// Number of residuals of each output.
    #[getter]
    fn rows(&self) -> usize {
        self.inner.rows
    }

    /// What the tests say: a dictionary with ``lags``, ``significance``, ``joint_whiteness`` and
    /// ``outputs``, a dictionary each with ``output``, ``whiteness`` and ``independence``. A
    /// verdict is ``not_rejected``, ``rejected`` or ``untested``.
    #[getter]
    fn verdict<'py>(&self, py: Python<'py>) -> Result<Bound<'py, PyAny>, Failure> {
        json_out(py, "verdict", &self.inner.verdict())
    }

    /// Autocorrelations at the lags 1 to M, an array (M, ny).
    #[getter]
    fn autocorrelation<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray2<f64>>> {
        self.by_lag(py, |output, lag| {
            self.inner.autocorrelations[output].values[lag]
        })
    }

    /// Half width of the band that autocorrelations of white errors keep to, an array (M, ny).
    #[getter]
    fn autocorrelation_band<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray2<f64>>> {
        self.by_lag(py, |output, lag| {
            self.inner.autocorrelations[output].bands[lag]
        })
    }

    /// Lags of the cross-correlations, -M to M samples, an array (2 M + 1,); positive ones are past
    /// inputs.
    #[getter]
    fn cross_lags<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<i64>> {
        let first = self.inner.cross_correlations.first();
        PyArray1::from_slice(py, first.map_or(&[], |each| &each.lags))
    }

    /// Correlations of the errors with the inputs, an array (2 M + 1, ny, nu).
    #[getter]
    fn cross_correlation<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray3<f64>>> {
        let channels = &self.inner.cross_correlations;
        let lags = channels.first().map_or(0, |each| each.lags.len());
        let values: Vec<f64> = (0..lags)
            .flat_map(|lag| channels.iter().map(move |each| each.values[lag]))
            .collect();
        PyArray1::from_vec(py, values).reshape([lags, self.outputs(), self.inputs()])
    }

    /// Half width of the band that correlations with independent inputs keep to, an array
    /// (ny, nu).
    #[getter]
    fn cross_correlation_band<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray2<f64>>> {
        let bands = self.inner.cross_correlations.iter().map(|each| each.band);
        PyArray1::from_vec(py, bands.collect()).reshape([self.outputs(), self.inputs()])
    }

    /// Whiteness of each output, the test of Ljung and Box: a list of tests.
    #[getter]
    fn ljung_box<'py>(&self, py: Python<'py>) -> Result<Bound<'py, PyAny>, Failure> {
        json_out(py, "residual tests", &self.inner.ljung_box)
    }

    /// Whiteness of all outputs together, the test of Hosking; ``None`` where the errors of one
    /// output follow from those of the others.
    #[getter]
    fn hosking<'py>(&self, py: Python<'py>) -> Result<Bound<'py, PyAny>, Failure> {
        json_out(py, "residual tests", &self.inner.hosking)
    }

    /// Independence of each output's errors from the past of all inputs together: a list of tests.
    #[getter]
    fn independence<'py>(&self, py: Python<'py>) -> Result<Bound<'py, PyAny>, Failure> {
        json_out(py, "residual tests", &self.inner.independence)
    }

    /// The tests of single inputs, all inputs of the first output first: dictionaries with
    /// ``output``, ``input``, ``independence`` (of the input's past) and ``feedback`` (of its
    /// present and future: rejected where the input is fed back from the outputs).
    #[getter]
    fn by_input<'py>(&self, py: Python<'py>) -> Result<Bound<'py, PyList>, Failure> {
        let list = PyList::empty(py);
        for each in &self.inner.cross_correlations {
            let entry = PyDict::new(py);
            entry.set_item("output", &each.output)?;
            entry.set_item("input", &each.input)?;
            let independence = json_out(py, "residual tests", &each.independence)?;
            entry.set_item("independence", independence)?;
            entry.set_item("feedback", json_out(py, "residual tests", &each.feedback)?)?;
            list.append(entry)?;
        }
        Ok(list)
    }

    fn __reduce__<'py>(&self, py: Python<'py>) -> Result<Reduced<'py>, Failure> {
        reduce(py, self)
    }
}

impl PyResidualReport {
    fn outputs(&self) -> usize {
        self.inner.autocorrelations.len()
    }

    fn inputs(&self) -> usize {
        let channels = self.inner.cross_correlations.len();
        channels.checked_div(self.outputs()).unwrap_or(0)
    }

    /// A value of each output at each lag of its autocorrelation.
    fn by_lag<'py>(
        &self,
        py: Python<'py>,
        of: impl Fn(usize, usize) -> f64,
    ) -> PyResult<Bound<'py, PyArray2<f64>>> {
        let outputs = self.outputs();
        let lags = self.inner.options.lags;
        let places = (0..lags).flat_map(|lag| (0..outputs).map(move |output| (output, lag)));
        let values = places.map(|(output, lag)| of(output, lag)).collect();
        table_out(py, values, outputs)
    }
}

pickle_inner!(PyResidualReport, ResidualReport);
