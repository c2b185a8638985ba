//! `TimeVaryingKalman`: the Kalman filter from a stated start, before it is steady.

use gtfdi::core::{OperatingPoint, StateSpace};
use gtfdi::fdi::{Innovation, NoiseCovariance, TimeVaryingKalman};
use nalgebra::{DMatrix, DVector};
use numpy::{PyArray1, PyArray2};
use pyo3::prelude::*;
use pyo3::types::PyDict;

use crate::array::{matrix, matrix_out, pair_out, samples_out, vector};
use crate::dataset::names;
use crate::error::Failure;
use crate::filter_run::record_of;
use crate::noise_covariance::PyNoiseCovariance;
use crate::observer::{Model, model_and_point};
use crate::pickle::{Pickled, Reduced, reduce};
use crate::state_space::PyStateSpace;

/// A Kalman filter that steps the covariance of its state too, from a stated start.
///
/// Parameters
/// ----------
/// model : StateSpace or OutputModel
///     The model.
/// noise : NoiseCovariance
///     The noise of states and outputs.
/// P0 : array_like, shape (nx, nx)
///     The covariance of the error of ``x0``; large numbers on the diagonal where nothing is known.
/// x0 : array_like, shape (nx,), optional
///     The state before the first sample; zero where left out.
/// point : tuple of array_like, optional
///     Operating point ``(u0, y0)``; that of the OutputModel, or zero.
///
/// Raises
/// ------
/// DimensionError
///     Sizes disagree.
/// DesignError
///     ``P0`` is not a covariance, or the covariance of the first innovation is singular.
///
/// Examples
/// --------
/// The mean of readings, one after the other.
///
/// >>> constant = gtfdi.StateSpace([[1.0]], [[0.0]], [[1.0]], [[0.0]], 1.0)
/// >>> noise = gtfdi.NoiseCovariance(Q=[[0.0]], R=[[1.0]])
/// >>> mean = gtfdi.TimeVaryingKalman(constant, noise, P0=[[1e12]])
/// >>> for reading in [1.0, 2.0, 6.0]:
/// ...     innovation = mean.step([0.0], [reading])
/// >>> mean.state.round(6), mean.covariance.round(6)
/// (array([3.]), array([[0.333333]]))
/// >>> float(innovation["value"][0].round(6))  # 6 less the mean of the first two
/// 4.5
#[pyclass(name = "TimeVaryingKalman", module = "gtfdi")]
pub struct PyTimeVaryingKalman {
    inner: TimeVaryingKalman,
    model: StateSpace,
    noise: NoiseCovariance,
    point: OperatingPoint,
    start: (DVector<f64>, DMatrix<f64>),
}

impl PyTimeVaryingKalman {
    /// Takes a sample in the units of the channels.
    fn take(&mut self, u: DVector<f64>, y: DVector<f64>) -> Result<Innovation, Failure> {
        // Sizes are checked where the sample is taken.
        let own = [(u, &self.point.u), (y, &self.point.y)];
        let [u, y] = own.map(|(values, point)| {
            if values.len() == point.len() {
                values - point
            } else {
                values
            }
        });
        Ok(self.inner.step(&u, &y)?)
    }
}

#[pymethods]
impl PyTimeVaryingKalman {
    #[new]
    #[pyo3(signature = (model, noise, P0, x0=None, point=None))]
    #[allow(non_snake_case)] // the field's notation
    fn py_new(
        model: Model<'_>,
        noise: &PyNoiseCovariance,
        P0: &Bound<'_, PyAny>,
        x0: Option<&Bound<'_, PyAny>>,
        point: Option<(Bound<'_, PyAny>, Bound<'_, PyAny>)>,
    ) -> Result<Self, Failure> {
        let (model, point) = model_and_point(model, point)?;
        let p0 = matrix(P0, "P0")?;
        let x0 = match x0 {
            Some(x0) => vector(x0, "x0")?,
            None => DVector::zeros(model.nx()),
        };
        let noise = noise.inner.clone();
        let inner = TimeVaryingKalman::new(model.clone(), noise.clone(), x0.clone(), &p0)?;
        Ok(Self {
            inner,
            model,
            noise,
            point,
            start: (x0, p0),
        })
    }

    /// Takes the next sample.
    ///
    /// Parameters
    /// ----------
    /// u, y : array_like, shapes (nu,) and (ny,)
    ///     Inputs and outputs. What is not finite stays in the state from there on.
    ///
    /// Returns
    /// -------
    /// dict
    ///     The innovation: its ``value`` (ny,) in the units of the outputs, its ``covariance``
    ///     (ny, ny), ``normalised`` (ny,) by the lower Cholesky factor of that, and ``squared``,
    ///     the sum of squares of that: chi-square with ny degrees of freedom under the noise.
    ///
    /// Raises
    /// ------
    /// DimensionError
    ///     Sizes disagree; nothing was taken.
    /// DesignError
    ///     The covariance of the next innovation would be singular; nothing was taken.
    fn step<'py>(
        &mut self,
        u: &Bound<'py, PyAny>,
        y: &Bound<'py, PyAny>,
    ) -> Result<Bound<'py, PyDict>, Failure> {
        let py = u.py();
        let innovation = self.take(vector(u, "u")?, vector(y, "y")?)?;
        let entry = PyDict::new(py);
        entry.set_item("value", array(py, &innovation.value))?;
        entry.set_item("covariance", matrix_out(py, &innovation.covariance)?)?;
        entry.set_item("normalised", array(py, &innovation.normalised))?;
        entry.set_item("squared", innovation.squared)?;
        Ok(entry)
    }

    /// Takes the next samples, a record; the normalised innovations, an array (N, ny).
    ///
    /// Raises
    /// ------
    /// DesignError
    ///     As ``step``; the samples before that one were taken.
    #[pyo3(signature = (u, y=None))]
    fn process<'py>(
        &mut self,
        u: &Bound<'py, PyAny>,
        y: Option<&Bound<'py, PyAny>>,
    ) -> Result<Bound<'py, PyArray2<f64>>, Failure> {
        let py = u.py();
        let data = record_of(&self.model, u, y)?;
        let normalised = py.detach(|| {
            let mut normalised = DMatrix::zeros(data.ny(), data.len());
            for sample in 0..data.len() {
                let u = data.u().column(sample).into_owned();
                let y = data.y().column(sample).into_owned();
                normalised.set_column(sample, &self.take(u, y)?.normalised);
            }
            Ok::<_, Failure>(normalised)
        })?;
        Ok(samples_out(py, normalised)?)
    }

    /// Back to the start.
    fn reset(&mut self) -> Result<(), Failure> {
        let (x0, p0) = self.start.clone();
        self.inner = TimeVaryingKalman::new(self.model.clone(), self.noise.clone(), x0, &p0)?;
        Ok(())
    }

    /// The state of the sample that comes next, an array (nx,), in deviations from the operating
    /// point.
    #[getter]
    fn state<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<f64>> {
        array(py, self.inner.state())
    }

    /// The covariance of that state's error, an array (nx, nx).
    #[getter]
    fn covariance<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray2<f64>>> {
        matrix_out(py, self.inner.covariance())
    }

    /// The gain of the sample that comes next on the state one step ahead, an array (nx, ny).
    #[getter]
    fn predictor_gain<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray2<f64>>> {
        matrix_out(py, self.inner.predictor_gain())
    }

    /// The gain of the sample that comes next on the state now, an array (nx, ny).
    #[getter]
    fn filter_gain<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray2<f64>>> {
        matrix_out(py, self.inner.filter_gain())
    }

    /// The model (StateSpace).
    #[getter]
    fn model(&self) -> PyStateSpace {
        PyStateSpace {
            inner: self.model.clone(),
        }
    }

    /// The noise (NoiseCovariance).
    #[getter]
    fn noise(&self) -> PyNoiseCovariance {
        PyNoiseCovariance {
            inner: self.noise.clone(),
        }
    }

    /// The operating point, a dictionary of arrays ``u`` and ``y``.
    #[getter]
    fn point<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        pair_out(py, &self.point.u, &self.point.y)
    }

    fn __reduce__<'py>(&self, py: Python<'py>) -> Result<Reduced<'py>, Failure> {
        reduce(py, self)
    }

    fn __repr__(&self) -> String {
        format!(
            "TimeVaryingKalman(outputs: {}, inputs: {})",
            names(self.model.outputs()).join(", "),
            names(self.model.inputs()).join(", ")
        )
    }
}

impl Pickled for PyTimeVaryingKalman {
    /// The model, the noise, the operating point, state and covariance at the start and now.
    type Stored = (
        StateSpace,
        NoiseCovariance,
        OperatingPoint,
        [(DVector<f64>, DMatrix<f64>); 2],
    );

    fn stored(&self) -> Result<Self::Stored, Failure> {
        let now = (self.inner.state().clone(), self.inner.covariance().clone());
        let (model, noise) = (self.model.clone(), self.noise.clone());
        Ok((model, noise, self.point.clone(), [self.start.clone(), now]))
    }

    fn restored((model, noise, point, [start, now]): Self::Stored) -> Result<Self, Failure> {
        let (x0, p0) = now;
        let inner = TimeVaryingKalman::new(model.clone(), noise.clone(), x0, &p0)?;
        Ok(Self {
            inner,
            model,
            noise,
            point,
            start,
        })
    }
}

fn array<'py>(py: Python<'py>, values: &DVector<f64>) -> Bound<'py, PyArray1<f64>> {
    PyArray1::from_slice(py, values.as_slice())
}
