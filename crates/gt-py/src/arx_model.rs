//! `ArxModel`: what an identification found.

use std::path::PathBuf;

use gt_log::{ModelFile, read_json, write_json};
use gtfdi::core::index_of;
use gtfdi::ident::{ArxModel, Channel, FreeRun, OutputModel, validate};
use numpy::{PyArray1, PyArray2};
use pyo3::prelude::*;
use pyo3::types::{PyDict, PyType};

use crate::array::{json_out, json_text, json_value, pair_out, samples_out};
use crate::dataset::{Given, names};
use crate::error::Failure;
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

    /// The means of the training record, a dictionary of arrays ``u`` and ``y``.
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

    /// The whole model in state space, of the deviations from the operating point.
    fn state_space(&self) -> Result<PyStateSpace, Failure> {
        Ok(PyStateSpace {
            inner: self.inner.state_space()?,
        })
    }

    /// The row of one output, by index or name, as a model of one output.
    fn output_model(&self, output: OutputKey) -> Result<PyOutputModel, Failure> {
        let index = match output {
            OutputKey::Index(index) => index,
            OutputKey::Name(name) => index_of(self.inner.outputs(), &name)?,
        };
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

    fn __reduce__<'py>(slf: &Bound<'py, Self>) -> Result<(Bound<'py, PyAny>, (String,)), Failure> {
        Ok((
            slf.get_type().getattr("from_json")?,
            (slf.get().to_json()?,),
        ))
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
    fn known(
        &self,
        u: &Bound<'_, PyAny>,
        y: Option<&Bound<'_, PyAny>>,
    ) -> Result<std::sync::Arc<gtfdi::core::Dataset>, Failure> {
        let model = &self.inner;
        Given::new(u, y)?.known(model.inputs(), model.outputs(), model.sample_time_s())
    }
}

/// An output, by position or name.
#[derive(FromPyObject)]
enum OutputKey {
    #[pyo3(annotation = "int")]
    Index(usize),
    #[pyo3(annotation = "str")]
    Name(String),
}

/// The outputs of a model that sees only the inputs.
#[pyclass(frozen, name = "FreeRun", module = "gtfdi")]
pub struct PyFreeRun {
    inner: FreeRun,
}

#[pymethods]
impl PyFreeRun {
    /// Outputs, an array (N, ny); NaN from where an output diverged.
    #[getter]
    fn y<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray2<f64>>> {
        samples_out(py, self.inner.y.clone())
    }

    /// For each output the sample from which it diverged, or ``None``.
    #[getter]
    fn diverges_at(&self) -> Vec<Option<usize>> {
        self.inner.diverges_at.clone()
    }

    /// Whether any output diverged.
    #[getter]
    fn diverged(&self) -> bool {
        self.inner.diverges_at.iter().any(Option::is_some)
    }
}

/// The row of one output as a state-space model; other outputs that it uses are inputs of it.
#[pyclass(frozen, name = "OutputModel", module = "gtfdi")]
pub struct PyOutputModel {
    pub inner: OutputModel,
}

#[pymethods]
impl PyOutputModel {
    /// The model, of deviations from ``point`` (StateSpace).
    #[getter]
    fn model(&self) -> PyStateSpace {
        PyStateSpace {
            inner: self.inner.model.clone(),
        }
    }

    /// The operating point, a dictionary of arrays ``u`` and ``y``.
    #[getter]
    fn point<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        pair_out(py, &self.inner.point.u, &self.inner.point.y)
    }
}
