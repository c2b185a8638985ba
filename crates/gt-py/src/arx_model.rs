//! `ArxModel`: what an identification found.

use std::path::PathBuf;

use gt_log::{ModelFile, read_json, write_json};
use gtfdi::ident::{ArxModel, Channel, realisation_report, test_residuals, validate};
use numpy::{PyArray1, PyArray2};
use pyo3::prelude::*;
use pyo3::types::{PyDict, PyType};

use crate::array::{json_out, json_text, json_value, pair_out, samples_out};
use crate::dataset::names;
use crate::error::Failure;
use crate::free_run::PyFreeRun;
use crate::output_key::OutputKey;
use crate::output_model::PyOutputModel;
use crate::pickle::{Reduced, pickle_inner, reduce};
use crate::record::Given;
use crate::residual_report::{PyResidualReport, options};
use crate::state_space::PyStateSpace;

/// A fitted ARX model; ``gtfdi.arx`` makes one.
///
/// Where a record is asked for, give arrays ``u`` (N, nu) and ``y`` (N, ny), or a Dataset alone,
/// whose channels are found by name.
#[pyclass(frozen, eq, name = "ArxModel", module = "gtfdi")]
#[derive(PartialEq)]
pub struct PyArxModel {
    pub inner: ArxModel,
}

#[pymethods]
impl PyArxModel {
    /// Tags of the inputs.
    #[getter]
    fn inputs(&self) -> Vec<String> {
        names(self.inner.inputs())
    }

    /// Tags of the outputs.
    #[getter]
    fn outputs(&self) -> Vec<String> {
        names(self.inner.outputs())
    }

    /// Sample time in seconds.
    #[getter]
    fn sample_time_s(&self) -> f64 {
        self.inner.sample_time_s()
    }

    /// The operating point, a dictionary of arrays ``u`` and ``y``: the means of the training
    /// records unless the fit was asked for another.
    #[getter]
    fn operating_point<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        let point = self.inner.operating_point();
        pair_out(py, &point.u, &point.y)
    }

    /// The structure as it stands in a model file, for example
    /// ``{"full": {"na": 2, "nb": [2], "nk": [1]}}``.
    #[getter]
    fn structure<'py>(&self, py: Python<'py>) -> Result<Bound<'py, PyAny>, Failure> {
        json_out(py, "structure", self.inner.structure())
    }

    /// For each output the terms ``{"signal", "lag", "coefficient"}`` of
    /// ``y(t) = sum of coefficient x signal(t - lag)``, in deviations from the operating point.
    #[getter]
    fn regression<'py>(&self, py: Python<'py>) -> PyResult<Vec<Vec<Bound<'py, PyDict>>>> {
        let signal = |channel: &Channel| match channel {
            Channel::Output(index) => self.inner.outputs()[*index].name.as_str(),
            Channel::Input(index) => self.inner.inputs()[*index].name.as_str(),
        };
        let rows = self.inner.rows().iter();
        rows.map(|row| {
            let terms = row.terms.iter();
            terms
                .map(|term| {
                    let entry = PyDict::new(py);
                    entry.set_item("signal", signal(&term.channel))?;
                    entry.set_item("lag", term.lag)?;
                    entry.set_item("coefficient", term.coefficient)?;
                    Ok(entry)
                })
                .collect()
        })
        .collect()
    }

    /// The longest lag in samples.
    #[getter]
    fn max_lag(&self) -> usize {
        self.inner.max_lag()
    }

    /// Number of samples in the regression.
    #[getter]
    fn rows_used(&self) -> usize {
        self.inner.rows_used()
    }

    /// Mean square of the equation error on the training record, an array (ny,).
    #[getter]
    fn residual_variance<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<f64>> {
        let variances = self.inner.rows().iter().map(|row| row.residual_variance);
        PyArray1::from_vec(py, variances.collect())
    }

    /// Condition of the column-scaled regressors, an array (ny,).
    #[getter]
    fn condition<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<f64>> {
        PyArray1::from_slice(py, self.inner.condition())
    }

    /// Standard errors of the coefficients, an array for each output in the order of
    /// ``regression``; they hold for white equation errors. ``None`` where the model has none, for
    /// example after a constrained fit.
    #[getter]
    fn standard_errors<'py>(&self, py: Python<'py>) -> Option<Vec<Bound<'py, PyArray1<f64>>>> {
        errors_out(py, &self.inner)
    }

    /// The outputs predicted one step ahead, an array (N, ny); the first ``max_lag`` rows are NaN.
    ///
    /// Examples
    /// --------
    /// >>> error = y - model.predict(u, y)
    /// >>> error.shape
    /// (7500, 1)
    #[pyo3(signature = (u, y=None))]
    fn predict<'py>(
        &self,
        u: &Bound<'py, PyAny>,
        y: Option<&Bound<'py, PyAny>>,
    ) -> Result<Bound<'py, PyArray2<f64>>, Failure> {
        let data = self.known(u, y)?;
        let predicted = u.py().detach(|| self.inner.predict(&data))?;
        Ok(samples_out(u.py(), predicted)?)
    }

    /// The equation error (N, ny): measured outputs minus their rows with every term measured; the
    /// first ``max_lag`` rows are NaN.
    #[pyo3(signature = (u, y=None))]
    fn equation_error<'py>(
        &self,
        u: &Bound<'py, PyAny>,
        y: Option<&Bound<'py, PyAny>>,
    ) -> Result<Bound<'py, PyArray2<f64>>, Failure> {
        let data = self.known(u, y)?;
        let error = u.py().detach(|| self.inner.equation_error(&data))?;
        Ok(samples_out(u.py(), error)?)
    }

    /// A free run over the inputs, started from the first ``max_lag`` measured outputs.
    ///
    /// Examples
    /// --------
    /// >>> free = model.simulate(u, y)
    /// >>> free.diverged, free.diverges_at
    /// (False, [None])
    #[pyo3(signature = (u, y=None))]
    fn simulate<'py>(
        &self,
        u: &Bound<'py, PyAny>,
        y: Option<&Bound<'py, PyAny>>,
    ) -> Result<PyFreeRun, Failure> {
        let data = self.known(u, y)?;
        let inner = u.py().detach(|| self.inner.simulate(&data))?;
        Ok(PyFreeRun { inner })
    }

    /// The errors on a record: a dictionary for each output with ``name``,
    /// ``fit_prediction_percent`` and ``fit_simulation_percent``, ``ppcre_prediction_percent`` and
    /// ``ppcre_simulation_percent``, ``sse_prediction`` and ``sse_simulation``, ``diverges_at_s``.
    /// Prediction is one step ahead, simulation the free run, ``None`` where that diverges.
    #[pyo3(signature = (u, y=None))]
    fn validate<'py>(
        &self,
        u: &Bound<'py, PyAny>,
        y: Option<&Bound<'py, PyAny>>,
    ) -> Result<Bound<'py, PyAny>, Failure> {
        let data = self.known(u, y)?;
        let validation = u.py().detach(|| validate(&self.inner, &data))?;
        json_out(u.py(), "validation", &validation.outputs)
    }

    /// Whether the one-step errors on a record are white, and independent of past inputs (a
    /// ``ResidualReport``).
    ///
    /// Parameters
    /// ----------
    /// u, y
    ///     The record.
    /// lags : int, default 20
    ///     The largest lag of the correlations.
    /// significance : float, default 0.01
    ///     Rate of false rejections of each test.
    /// origin : {"fresh", "fitted"}, default "fresh"
    ///     Whether the model was fitted to another record or to this one, which looks too white.
    ///
    /// Examples
    /// --------
    /// >>> report = model.test_residuals(u, y, origin="fitted")
    /// >>> report.verdict["outputs"][0]["output"], report.autocorrelation.shape
    /// ('q_c', (20, 1))
    #[pyo3(signature = (u, y=None, *, lags=20, significance=0.01, origin="fresh"))]
    fn test_residuals(
        &self,
        u: &Bound<'_, PyAny>,
        y: Option<&Bound<'_, PyAny>>,
        lags: usize,
        significance: f64,
        origin: &str,
    ) -> Result<PyResidualReport, Failure> {
        let options = options(lags, significance, origin)?;
        let data = self.known(u, y)?;
        let inner = u
            .py()
            .detach(|| test_residuals(&self.inner, &data, &options))?;
        Ok(PyResidualReport { inner })
    }

    /// How the realisation of ``state_space`` is to be judged: a dictionary with ``order``,
    /// ``reachable``, ``observable``, ``hankel_singular_values`` (``None`` where the model is not
    /// stable), ``minimal_order``, ``m_determinant``, ``m_condition`` and ``warnings``
    /// (``{"ill_conditioned": ...}``, ``{"not_minimal": ...}``).
    ///
    /// Examples
    /// --------
    /// >>> model.realisation_report()["order"]
    /// 8
    fn realisation_report<'py>(&self, py: Python<'py>) -> Result<Bound<'py, PyAny>, Failure> {
        let report = py.detach(|| realisation_report(&self.inner))?;
        json_out(py, "realisation report", &report)
    }

    /// The whole model in state space, of the deviations from the operating point.
    fn state_space(&self) -> Result<PyStateSpace, Failure> {
        Ok(PyStateSpace {
            inner: self.inner.state_space()?,
        })
    }

    /// The row of one output, by index or name, as a model of one output.
    fn output_model(&self, output: OutputKey) -> Result<PyOutputModel, Failure> {
        let index = output.index(self.inner.outputs())?;
        Ok(PyOutputModel {
            inner: self.inner.output_model(index)?,
        })
    }

    /// Writes a model file, as ``gtfdi identify --out`` does.
    fn save(&self, py: Python<'_>, path: PathBuf) -> Result<(), Failure> {
        let file = ModelFile::arx(self.inner.clone(), None)?;
        Ok(py.detach(|| write_json(&path, &file))?)
    }

    /// Reads a model file; it is checked.
    #[classmethod]
    fn load(class: &Bound<'_, PyType>, path: PathBuf) -> Result<Self, Failure> {
        let file: ModelFile = class.py().detach(|| read_json(&path))?;
        Ok(Self { inner: file.model })
    }

    /// The model as JSON.
    fn to_json(&self) -> Result<String, Failure> {
        json_text("ARX model", &self.inner)
    }

    /// A model from the JSON that ``to_json`` gave; it is checked.
    #[classmethod]
    fn from_json(_class: &Bound<'_, PyType>, text: &str) -> Result<Self, Failure> {
        let inner = json_value("ARX model", text)?;
        Ok(Self { inner })
    }

    fn __reduce__<'py>(&self, py: Python<'py>) -> Result<Reduced<'py>, Failure> {
        reduce(py, self)
    }

    fn __repr__(&self) -> String {
        format!(
            "ArxModel({}, inputs: {}, outputs: {}, sample time {} s)",
            self.inner.structure(),
            self.inputs().join(", "),
            self.outputs().join(", "),
            self.inner.sample_time_s()
        )
    }
}

impl PyArxModel {
    /// The record for the model.
    pub fn known(
        &self,
        u: &Bound<'_, PyAny>,
        y: Option<&Bound<'_, PyAny>>,
    ) -> Result<std::sync::Arc<gtfdi::core::Dataset>, Failure> {
        let model = &self.inner;
        Given::new(u, y)?.known(model.inputs(), model.outputs(), model.sample_time_s())
    }
}

/// The standard errors of a model's coefficients, an array an output.
pub fn errors_out<'py>(
    py: Python<'py>,
    model: &ArxModel,
) -> Option<Vec<Bound<'py, PyArray1<f64>>>> {
    let errors = model.standard_errors()?.iter();
    Some(errors.map(|row| PyArray1::from_slice(py, row)).collect())
}

pickle_inner!(PyArxModel, ArxModel);
