//! `ScheduledModel`: ARX models along a load, handed over smoothly.

use std::sync::Arc;

use gtfdi::core::Dataset;
use gtfdi::ident::schedule::{SchedulePoint, ScheduledModel};
use numpy::PyArray2;
use pyo3::prelude::*;
use pyo3::types::{PyDict, PyType};

use crate::array::{json_text, json_value, samples_out};
use crate::arx_model::PyArxModel;
use crate::dataset::names;
use crate::error::Failure;
use crate::free_run::PyFreeRun;
use crate::pickle::{Reduced, pickle_inner, reduce};
use crate::record::Given;

/// ARX models along a scheduling channel; ``ScheduledArx.fit`` makes one.
///
/// Between two points the equations of both take part with weights that sum to 1; beyond the ends
/// the last point stands alone.
///
/// Parameters
/// ----------
/// channel : str
///     The scheduling channel, an input of all models.
/// points : list of tuple (float, ArxModel)
///     The channel's values in ascending order, each with the model that holds there.
/// width : float, default 1
///     Part of the way between two points over which one hands over to the other.
///
/// Raises
/// ------
/// IdentError
///     Values or a width out of range, or models of different channels.
/// DataError
///     The channel is no input.
#[pyclass(frozen, eq, name = "ScheduledModel", module = "gtfdi")]
#[derive(PartialEq)]
pub struct PyScheduledModel {
    pub inner: ScheduledModel,
}

#[pymethods]
impl PyScheduledModel {
    #[new]
    #[pyo3(signature = (channel, points, width=1.0))]
    fn py_new(
        channel: String,
        points: Vec<(f64, Bound<'_, PyArxModel>)>,
        width: f64,
    ) -> Result<Self, Failure> {
        let points = points.iter().map(|(value, model)| SchedulePoint {
            value: *value,
            model: model.get().inner.clone(),
        });
        let inner = ScheduledModel::new(channel, points.collect(), width)?;
        Ok(Self { inner })
    }

    /// The scheduling channel.
    #[getter]
    fn channel(&self) -> &str {
        self.inner.channel()
    }

    /// Part of the way between two points over which one hands over to the other.
    #[getter]
    fn width(&self) -> f64 {
        self.inner.width()
    }

    /// The points in ascending order: dictionaries with ``value`` and ``model`` (ArxModel).
    #[getter]
    fn points<'py>(&self, py: Python<'py>) -> PyResult<Vec<Bound<'py, PyDict>>> {
        let points = self.inner.points().iter();
        points
            .map(|point| {
                let model = PyArxModel {
                    inner: point.model.clone(),
                };
                let entry = PyDict::new(py);
                entry.set_item("value", point.value)?;
                entry.set_item("model", Bound::new(py, model)?)?;
                Ok(entry)
            })
            .collect()
    }

    /// Tags of the inputs.
    #[getter]
    fn inputs(&self) -> Vec<String> {
        names(self.first().inputs())
    }

    /// Tags of the outputs.
    #[getter]
    fn outputs(&self) -> Vec<String> {
        names(self.first().outputs())
    }

    /// Sample time in seconds.
    #[getter]
    fn sample_time_s(&self) -> f64 {
        self.first().sample_time_s()
    }

    /// The longest lag of any point in samples.
    #[getter]
    fn max_lag(&self) -> usize {
        self.inner.max_lag()
    }

    /// The outputs predicted one step ahead, an array (N, ny); the first ``max_lag`` rows are NaN.
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

    /// A free run over the inputs, started from the first ``max_lag`` measured outputs (FreeRun).
    #[pyo3(signature = (u, y=None))]
    fn simulate(
        &self,
        u: &Bound<'_, PyAny>,
        y: Option<&Bound<'_, PyAny>>,
    ) -> Result<PyFreeRun, Failure> {
        let data = self.known(u, y)?;
        let inner = u.py().detach(|| self.inner.simulate(&data))?;
        Ok(PyFreeRun { inner })
    }

    /// The model as JSON.
    fn to_json(&self) -> Result<String, Failure> {
        json_text("scheduled model", &self.inner)
    }

    /// A model from the JSON that ``to_json`` gave; it is checked.
    #[classmethod]
    fn from_json(_class: &Bound<'_, PyType>, text: &str) -> Result<Self, Failure> {
        let inner = json_value("scheduled model", text)?;
        Ok(Self { inner })
    }

    fn __reduce__<'py>(&self, py: Python<'py>) -> Result<Reduced<'py>, Failure> {
        reduce(py, self)
    }

    fn __repr__(&self) -> String {
        format!(
            "ScheduledModel({} points of {}, inputs: {}, outputs: {}, sample time {} s)",
            self.inner.points().len(),
            self.inner.channel(),
            self.inputs().join(", "),
            self.outputs().join(", "),
            self.sample_time_s()
        )
    }
}

impl PyScheduledModel {
    /// The first point's model; there is one at least, and all have the same channels.
    fn first(&self) -> &gtfdi::ident::ArxModel {
        &self.inner.points()[0].model
    }

    fn known(
        &self,
        u: &Bound<'_, PyAny>,
        y: Option<&Bound<'_, PyAny>>,
    ) -> Result<Arc<Dataset>, Failure> {
        let model = self.first();
        Given::new(u, y)?.known(model.inputs(), model.outputs(), model.sample_time_s())
    }
}

pickle_inner!(PyScheduledModel, ScheduledModel);
