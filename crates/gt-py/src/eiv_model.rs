//! `EivModel`: a relation between noise-free channels, and the noise.

use std::path::PathBuf;

use gt_log::{ModelFile, ModelKind, read_json, write_json};
use gtfdi::ident::eiv::{EivModel, EivOrderTable};
use numpy::PyArray1;
use pyo3::prelude::*;
use pyo3::types::{PyDict, PyType};

use crate::array::{json_text, json_value};
use crate::arx_model::{PyArxModel, errors_out};
use crate::dataset::names;
use crate::eiv_order_table::PyEivOrderTable;
use crate::error::Failure;
use crate::pickle::{Pickled, Reduced, reduce};

/// What a JSON text of a model is called in errors.
const WHAT: &str = "errors-in-variables model";

/// An errors-in-variables model; ``gtfdi.eiv`` and ``gtfdi.frisch`` make one.
///
/// Two models are equal where kind, relation and noise are; a file keeps these, and not the table of
/// orders.
#[pyclass(frozen, eq, name = "EivModel", module = "gtfdi")]
pub struct PyEivModel {
    pub inner: EivModel,
    pub kind: ModelKind,
    pub orders: Option<EivOrderTable>,
}

impl PartialEq for PyEivModel {
    fn eq(&self, other: &Self) -> bool {
        (self.kind, &self.inner) == (other.kind, &other.inner)
    }
}

#[pymethods]
impl PyEivModel {
    /// How the model was identified: ``eiv`` (maximum likelihood) or ``frisch``.
    #[getter]
    fn kind(&self) -> &'static str {
        match self.kind {
            ModelKind::Arx => "arx",
            ModelKind::Frisch => "frisch",
            ModelKind::Eiv => "eiv",
        }
    }

    /// The equations of what the channels would be without noise (ArxModel). Its one-step
    /// prediction from measured channels is not the best there is: the noise passes through it.
    #[getter]
    fn relation(&self) -> PyArxModel {
        PyArxModel {
            inner: self.inner.relation().clone(),
        }
    }

    /// Tags of the inputs.
    #[getter]
    fn inputs(&self) -> Vec<String> {
        names(self.inner.relation().inputs())
    }

    /// Tags of the outputs.
    #[getter]
    fn outputs(&self) -> Vec<String> {
        names(self.inner.relation().outputs())
    }

    /// Sample time in seconds.
    #[getter]
    fn sample_time_s(&self) -> f64 {
        self.inner.relation().sample_time_s()
    }

    /// The variance of each channel's noise by tag, in squared units of the channel.
    #[getter]
    fn noise_variances<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        let report = PyDict::new(py);
        for (signal, noise) in self.inner.noise() {
            report.set_item(&signal.name, noise.variance)?;
        }
        Ok(report)
    }

    /// What is known of each channel's noise, by tag, outputs first: dictionaries with
    /// ``variance``, ``standard_error`` (of the variance; for the Frisch scheme the least that any
    /// estimate from the same covariances has), ``at_limit`` (it stands at a limit of what the
    /// record admits) and ``identifiable`` (the record tells it: neither at a limit nor with a
    /// standard error above half of it; ``None`` without a standard error).
    #[getter]
    fn noise<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        let report = PyDict::new(py);
        for (signal, noise) in self.inner.noise() {
            let entry = PyDict::new(py);
            entry.set_item("variance", noise.variance)?;
            entry.set_item("standard_error", noise.standard_error)?;
            entry.set_item("at_limit", noise.at_limit)?;
            entry.set_item("identifiable", noise.identifiable())?;
            report.set_item(&signal.name, entry)?;
        }
        Ok(report)
    }

    /// Standard errors of the relation's coefficients, an array for each output in the order of
    /// ``relation.regression``; ``None`` for the Frisch scheme, which gives none.
    #[getter]
    fn standard_errors<'py>(&self, py: Python<'py>) -> Option<Vec<Bound<'py, PyArray1<f64>>>> {
        errors_out(py, self.inner.relation())
    }

    /// What the orders were compared by (EivOrderTable), ``None`` where one was given.
    #[getter]
    fn order_table(&self) -> Option<PyEivOrderTable> {
        let inner = self.orders.clone()?;
        Some(PyEivOrderTable { inner })
    }

    /// Writes a model file, as ``gtfdi identify --method eiv --out`` does.
    fn save(&self, py: Python<'_>, path: PathBuf) -> Result<(), Failure> {
        let file = self.file()?;
        Ok(py.detach(|| write_json(&path, &file))?)
    }

    /// Reads a model file; it is checked.
    #[classmethod]
    fn load(class: &Bound<'_, PyType>, path: PathBuf) -> Result<Self, Failure> {
        let file: ModelFile = class.py().detach(|| read_json(&path))?;
        Self::from_file(&file, || path.display().to_string())
    }

    /// The model as the JSON of a model file.
    fn to_json(&self) -> Result<String, Failure> {
        json_text(WHAT, &self.file()?)
    }

    /// A model from the JSON that ``to_json`` gave, or from the text of a model file; it is
    /// checked.
    #[classmethod]
    fn from_json(_class: &Bound<'_, PyType>, text: &str) -> Result<Self, Failure> {
        Self::from_file(&json_value(WHAT, text)?, || WHAT.to_owned())
    }

    fn __reduce__<'py>(&self, py: Python<'py>) -> Result<Reduced<'py>, Failure> {
        reduce(py, self)
    }

    fn __repr__(&self) -> String {
        format!(
            "EivModel({}, {}, inputs: {}, outputs: {}, sample time {} s)",
            self.kind(),
            self.inner.relation().structure(),
            self.inputs().join(", "),
            self.outputs().join(", "),
            self.sample_time_s()
        )
    }
}

impl PyEivModel {
    fn file(&self) -> Result<ModelFile, Failure> {
        Ok(ModelFile::with_noise(self.kind, &self.inner, None)?)
    }

    fn from_file(file: &ModelFile, place: impl Fn() -> String) -> Result<Self, Failure> {
        let inner = file
            .eiv()?
            .ok_or_else(|| Failure::NoNoise { place: place() })?;
        Ok(Self {
            inner,
            kind: file.kind,
            orders: None,
        })
    }
}

impl Pickled for PyEivModel {
    type Stored = (ModelFile, Option<EivOrderTable>);

    fn stored(&self) -> Result<Self::Stored, Failure> {
        Ok((self.file()?, self.orders.clone()))
    }

    fn restored((file, orders): Self::Stored) -> Result<Self, Failure> {
        let model = Self::from_file(&file, || WHAT.to_owned())?;
        Ok(Self { orders, ..model })
    }
}
