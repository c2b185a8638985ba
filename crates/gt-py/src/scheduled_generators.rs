//! `ScheduledGenerators`: residual generators at several operating points, blended along a channel.

use gtfdi::core::Dataset;
use gtfdi::fdi::{Blend, ResidualGenerator, ScheduledGenerators, ScheduledPoint};
use numpy::{PyArray1, PyArray2};
use pyo3::prelude::*;
use pyo3::types::{IntoPyDict, PyDict, PyType};

use crate::array::{json_text, json_value, samples_out};
use crate::dataset::{PyDataset, names};
use crate::error::Failure;
use crate::fleet::GeneratorArgument;
use crate::pickle::{Reduced, pickle_inner, reduce};

/// Residual generators at several operating points, blended along a scheduling channel such as the
/// load.
///
/// All run beside each other over the whole record; between two points their residuals are weighted
/// by the distance to each, and beyond the ends the last one stands alone.
///
/// Parameters
/// ----------
/// channel : str
///     Tag of the scheduling channel, an input, an output or any other channel of the records.
/// points : list of tuple (float, Observer or KalmanFilter)
///     The channel's values in ascending order, each with the generator that holds there; all have
///     the same inputs and outputs.
/// hysteresis : float, optional
///     Switch to the nearest point in place of weighting, once the channel is so far beyond the
///     middle between two; in the channel's unit.
///
/// Raises
/// ------
/// DesignError
///     There is no point, values do not ascend, generators of different channels, or a hysteresis
///     of more than half of the narrowest interval.
///
/// Examples
/// --------
/// >>> part = model.output_model("q_c")
/// >>> low, high = gtfdi.observer(part, 0.5), gtfdi.observer(part, 0.7)
/// >>> blended = gtfdi.ScheduledGenerators("M_f", [(0.4, low), (0.5, high)])
/// >>> blended.weights(0.425).round(9)
/// array([0.75, 0.25])
/// >>> blended.run(run.measured)["residuals"].shape
/// (7500, 1)
#[pyclass(frozen, eq, name = "ScheduledGenerators", module = "gtfdi")]
#[derive(PartialEq)]
pub struct PyScheduledGenerators {
    inner: ScheduledGenerators,
}

#[pymethods]
impl PyScheduledGenerators {
    #[new]
    #[pyo3(signature = (channel, points, hysteresis=None))]
    fn py_new(
        channel: String,
        points: Vec<(f64, GeneratorArgument<'_>)>,
        hysteresis: Option<f64>,
    ) -> Result<Self, Failure> {
        let points = points.iter().map(|(breakpoint, generator)| {
            let generator: &ResidualGenerator = match generator {
                GeneratorArgument::Observer(observer) => &observer.get().inner,
                GeneratorArgument::Kalman(filter) => &filter.get().inner,
            };
            ScheduledPoint {
                breakpoint: *breakpoint,
                generator: generator.clone(),
            }
        });
        let blend = hysteresis.map_or(Blend::Interpolated, |hysteresis| Blend::Switched {
            hysteresis,
        });
        let inner = ScheduledGenerators::new(channel, points.collect(), blend)?;
        Ok(Self { inner })
    }

    /// Runs over a record that has the channels of the generators and the scheduling channel.
    ///
    /// Parameters
    /// ----------
    /// data : Dataset
    ///     The record.
    ///
    /// Returns
    /// -------
    /// dict
    ///     ``residuals`` (N, ny), in the outputs' units, and ``weights`` (N, number of points). A
    ///     sample whose scheduling channel is missing has NaN for both.
    ///
    /// Raises
    /// ------
    /// DesignError
    ///     The record lacks a channel, or has another sample time.
    fn run<'py>(&self, data: &Bound<'py, PyDataset>) -> Result<Bound<'py, PyDict>, Failure> {
        let py = data.py();
        let data: &Dataset = &data.get().inner;
        let run = py.detach(|| self.inner.run(data))?;
        let entries = [
            ("residuals", samples_out(py, run.residuals)?),
            ("weights", samples_out(py, run.weights)?),
        ];
        Ok(entries.into_py_dict(py)?)
    }

    /// The residuals of a record, an array (N, ny): those of ``run``.
    fn residuals<'py>(
        &self,
        data: &Bound<'py, PyDataset>,
    ) -> Result<Bound<'py, PyArray2<f64>>, Failure> {
        let py = data.py();
        let data: &Dataset = &data.get().inner;
        let residuals = py.detach(|| self.inner.residuals(data))?;
        Ok(samples_out(py, residuals)?)
    }

    /// The weights of the points at a value of the scheduling channel, an array; with a hysteresis
    /// those of a channel that was there from the beginning.
    fn weights<'py>(&self, py: Python<'py>, value: f64) -> Bound<'py, PyArray1<f64>> {
        PyArray1::from_vec(py, self.inner.weights(value))
    }

    /// Tag of the scheduling channel.
    #[getter]
    fn channel(&self) -> String {
        self.inner.channel().to_owned()
    }

    /// The points' values of the scheduling channel, an array.
    #[getter]
    fn breakpoints<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<f64>> {
        let points = self.inner.points().iter();
        PyArray1::from_vec(py, points.map(|point| point.breakpoint).collect())
    }

    /// The hysteresis in the channel's unit; ``None`` where points are weighted.
    #[getter]
    fn hysteresis(&self) -> Option<f64> {
        match self.inner.blend() {
            Blend::Interpolated => None,
            Blend::Switched { hysteresis } => Some(hysteresis),
        }
    }

    /// Samples after which a wrong initial state is forgotten by all.
    #[getter]
    fn settle_samples(&self) -> usize {
        self.inner.settle_samples()
    }

    /// The generators as JSON.
    fn to_json(&self) -> Result<String, Failure> {
        json_text("generators", &self.inner)
    }

    /// Generators from the JSON that ``to_json`` gave; they are checked.
    #[classmethod]
    fn from_json(_class: &Bound<'_, PyType>, text: &str) -> Result<Self, Failure> {
        let inner = json_value("generators", text)?;
        Ok(Self { inner })
    }

    fn __reduce__<'py>(&self, py: Python<'py>) -> Result<Reduced<'py>, Failure> {
        reduce(py, self)
    }

    fn __repr__(&self) -> String {
        let points = self.inner.points();
        let outputs = points.first().map(|point| names(point.generator.outputs()));
        format!(
            "ScheduledGenerators({} points along {}, outputs: {})",
            points.len(),
            self.inner.channel(),
            outputs.unwrap_or_default().join(", ")
        )
    }
}

pickle_inner!(PyScheduledGenerators, ScheduledGenerators);
