//! `kalman`: the steady Kalman filter of a model as a residual generator.

use gtfdi::core::{OperatingPoint, StateSpace};
use gtfdi::fdi::{KalmanFilter, NoiseCovariance, ResidualGenerator};
use numpy::PyArray2;
use pyo3::prelude::*;
use pyo3::types::{PyDict, PyType};

use crate::array::{json_text, json_value, matrix_out, pair_out, samples_out};
use crate::dataset::names;
use crate::error::Failure;
use crate::filter_run::{PyFilterRun, filter_run};
use crate::noise_covariance::{PyNoiseCovariance, of_channels};
use crate::observer::{Model, model_and_point};
use crate::pickle::{Pickled, Reduced, reduce};
use crate::record::Given;
use crate::state_space::PyStateSpace;

/// A steady Kalman filter; ``gtfdi.kalman`` makes one.
#[pyclass(frozen, eq, name = "KalmanFilter", module = "gtfdi")]
#[derive(PartialEq)]
pub struct PyKalmanFilter {
    pub inner: ResidualGenerator,
}

impl PyKalmanFilter {
    /// The filter behind the generator, whose noise a file or a call has given.
    fn filter(&self) -> Result<KalmanFilter, Failure> {
        let noise = self.inner.noise().ok_or_else(|| Failure::Refusal {
            option: "noise",
            reason: "expected that of a Kalman filter, found the poles of an observer".to_owned(),
        })?;
        let model = self.inner.model().clone();
        Ok(KalmanFilter::new(model, noise.clone())?)
    }
}

#[pymethods]
impl PyKalmanFilter {
    /// The innovations of a record, an array (N, ny) in the units of the outputs, from the initial
    /// state zero; the first ``settle_samples`` of them hold the initial transient. A sample
    /// without a valid input or output gives NaN. C-contiguous float64 arrays are read where they
    /// are.
    ///
    /// Examples
    /// --------
    /// >>> gtfdi.kalman(model.output_model(0), [0.0, 0.0], [0.01]).innovations(u, y).shape
    /// (7500, 1)
    #[pyo3(signature = (u, y=None))]
    fn innovations<'py>(
        &self,
        u: &Bound<'py, PyAny>,
        y: Option<&Bound<'py, PyAny>>,
    ) -> Result<Bound<'py, PyArray2<f64>>, Failure> {
        let innovations = Given::new(u, y)?.residuals(u.py(), &self.inner)?;
        Ok(samples_out(u.py(), innovations)?)
    }

    /// Filters a record: innovations and states of every sample.
    ///
    /// Parameters
    /// ----------
    /// u, y
    ///     The record. A sample that is not finite stays in the state from there on.
    /// x0 : array_like, shape (nx,), optional
    ///     The state before the first sample; zero where left out.
    ///
    /// Returns
    /// -------
    /// FilterRun
    ///
    /// Examples
    /// --------
    /// >>> filter = gtfdi.kalman(model.output_model(0), [1e-4, 1e-6], [0.01])
    /// >>> filtered = filter.run(u, y)
    /// >>> filtered.predicted.shape, np.allclose(filtered.innovations, filter.innovations(u, y))
    /// ((7500, 8), True)
    #[pyo3(signature = (u, y=None, x0=None))]
    fn run(
        &self,
        u: &Bound<'_, PyAny>,
        y: Option<&Bound<'_, PyAny>>,
        x0: Option<&Bound<'_, PyAny>>,
    ) -> Result<PyFilterRun, Failure> {
        let (_, inner) = filter_run(&self.filter()?, self.inner.point(), u, y, x0)?;
        Ok(PyFilterRun { inner })
    }

    /// The noise of the design (NoiseCovariance).
    #[getter]
    fn noise(&self) -> Result<PyNoiseCovariance, Failure> {
        let inner = self.filter()?.noise().clone();
        Ok(PyNoiseCovariance { inner })
    }

    /// The gain that corrects the state one step ahead, an array (nx, ny).
    #[getter]
    fn predictor_gain<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray2<f64>>> {
        matrix_out(py, self.inner.gain())
    }

    /// The gain that corrects the state now, an array (nx, ny).
    #[getter]
    fn filter_gain<'py>(&self, py: Python<'py>) -> Result<Bound<'py, PyArray2<f64>>, Failure> {
        Ok(matrix_out(py, self.filter()?.filter_gain())?)
    }

    /// The covariance of the innovations under the noise, an array (ny, ny).
    #[getter]
    fn innovation_covariance<'py>(
        &self,
        py: Python<'py>,
    ) -> Result<Bound<'py, PyArray2<f64>>, Failure> {
        Ok(matrix_out(py, &self.filter()?.innovation_covariance())?)
    }

    /// The covariance P of the error of the predicted state, an array (nx, nx).
    #[getter]
    fn predicted_covariance<'py>(
        &self,
        py: Python<'py>,
    ) -> Result<Bound<'py, PyArray2<f64>>, Failure> {
        Ok(matrix_out(py, &self.filter()?.riccati().p)?)
    }

    /// The covariance of the error of the state that has seen the sample itself, an array (nx, nx).
    #[getter]
    fn filtered_covariance<'py>(
        &self,
        py: Python<'py>,
    ) -> Result<Bound<'py, PyArray2<f64>>, Failure> {
        Ok(matrix_out(py, &self.filter()?.filtered_covariance())?)
    }

    /// Spectral radius of ``A - K C``.
    #[getter]
    fn spectral_radius(&self) -> Result<f64, Failure> {
        Ok(self.filter()?.riccati().spectral_radius)
    }

    /// Samples after which a wrong initial state is forgotten.
    #[getter]
    fn settle_samples(&self) -> usize {
        self.inner.settle_samples()
    }

    /// The model (StateSpace).
    #[getter]
    fn model(&self) -> PyStateSpace {
        PyStateSpace {
            inner: self.inner.model().clone(),
        }
    }

    /// The operating point, a dictionary of arrays ``u`` and ``y``.
    #[getter]
    fn point<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        let point = self.inner.point();
        pair_out(py, &point.u, &point.y)
    }

    /// The filter as JSON.
    fn to_json(&self) -> Result<String, Failure> {
        json_text("filter", &self.inner)
    }

    /// A filter from the JSON that ``to_json`` gave; it is checked.
    #[classmethod]
    fn from_json(_class: &Bound<'_, PyType>, text: &str) -> Result<Self, Failure> {
        Self::restored(json_value("filter", text)?)
    }

    fn __reduce__<'py>(&self, py: Python<'py>) -> Result<Reduced<'py>, Failure> {
        reduce(py, self)
    }

    fn __repr__(&self) -> String {
        format!(
            "KalmanFilter(outputs: {}, inputs: {})",
            names(self.inner.outputs()).join(", "),
            names(self.inner.inputs()).join(", "),
        )
    }
}

/// Designs the steady Kalman filter of a model whose measured inputs and outputs have white noise.
///
/// With noise on the inputs the state's and the outputs' noise are correlated through the direct
/// term, which the design allows for; the innovations are white under the noise given.
///
/// Parameters
/// ----------
/// model : StateSpace or OutputModel
///     A model; of several outputs they are filtered together.
/// input_variances, output_variances : array_like, shapes (nu,) and (ny,), optional
///     Variances of the noise of each channel, in squared units; those of an EivModel are in its
///     ``noise_variances``.
/// point : tuple of array_like, optional
///     Operating point ``(u0, y0)``; that of the OutputModel, or zero.
/// noise : NoiseCovariance, optional
///     The noise of states and outputs, in place of the variances of the channels.
///
/// Returns
/// -------
/// KalmanFilter
///
/// Raises
/// ------
/// DesignError
///     A variance is negative, or the model has no stabilising filter for this noise.
/// OptionError
///     Neither both variances nor the noise.
///
/// Examples
/// --------
/// >>> filter = gtfdi.kalman(model.output_model("q_c"), [1e-4, 1e-6], [0.01])
/// >>> filter.predictor_gain.shape
/// (8, 1)
///
/// A level that wanders, read with noise of its own.
///
/// >>> level = gtfdi.StateSpace([[1.0]], [[0.0]], [[1.0]], [[0.0]], 1.0)
/// >>> filter = gtfdi.kalman(level, noise=gtfdi.NoiseCovariance(Q=[[1.0]], R=[[1.0]]))
/// >>> bool(abs(filter.predictor_gain[0, 0] - (5**0.5 - 1) / 2) < 1e-14)
/// True
#[pyfunction]
#[pyo3(signature = (model, input_variances=None, output_variances=None, point=None, *, noise=None))]
pub fn kalman(
    model: Model<'_>,
    input_variances: Option<&Bound<'_, PyAny>>,
    output_variances: Option<&Bound<'_, PyAny>>,
    point: Option<(Bound<'_, PyAny>, Bound<'_, PyAny>)>,
    noise: Option<&PyNoiseCovariance>,
) -> Result<PyKalmanFilter, Failure> {
    let (model, point): (StateSpace, OperatingPoint) = model_and_point(model, point)?;
    let noise: NoiseCovariance = match (noise, input_variances, output_variances) {
        (Some(noise), None, None) => noise.inner.clone(),
        (None, Some(inputs), Some(outputs)) => of_channels(&model, inputs, outputs)?,
        (noise, inputs, outputs) => {
            let given = [
                (inputs.is_some(), "input_variances"),
                (outputs.is_some(), "output_variances"),
                (noise.is_some(), "noise"),
            ];
            let found: Vec<&str> = given
                .iter()
                .filter_map(|(is_given, name)| is_given.then_some(*name))
                .collect();
            return Err(Failure::Option {
                option: "noise",
                expected: "both variances, or the noise in their place".to_owned(),
                found: match found.as_slice() {
                    [] => "none".to_owned(),
                    names => names.join(" and "),
                },
            });
        }
    };
    Ok(PyKalmanFilter {
        inner: ResidualGenerator::kalman(model, point, noise)?,
    })
}

impl Pickled for PyKalmanFilter {
    type Stored = ResidualGenerator;

    fn stored(&self) -> Result<ResidualGenerator, Failure> {
        Ok(self.inner.clone())
    }

    /// Refuses a generator without the noise of a filter.
    fn restored(inner: ResidualGenerator) -> Result<Self, Failure> {
        let filter = Self { inner };
        filter.filter()?;
        Ok(filter)
    }
}
