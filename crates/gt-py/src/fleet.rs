//! `Fleet`: one residual generator on many streams.

use gtfdi::core::DimensionError;
use gtfdi::fdi::{Fleet, ResidualGenerator};
use numpy::{PyArray1, PyArray3, PyArrayMethods};
use pyo3::prelude::*;

use crate::array::Block;
use crate::dataset::names;
use crate::error::Failure;
use crate::kalman::PyKalmanFilter;
use crate::observer::PyObserver;

/// What a fleet is of.
#[derive(FromPyObject)]
pub enum GeneratorArgument<'py> {
    /// Placed poles.
    #[pyo3(annotation = "Observer")]
    Observer(Bound<'py, PyObserver>),
    /// Steady filters.
    #[pyo3(annotation = "KalmanFilter")]
    Kalman(Bound<'py, PyKalmanFilter>),
}

/// One observer or Kalman filter on many streams, such as machines of one type.
///
/// The residuals are those of the generator on each stream by itself, bit for bit, and many streams
/// are computed side by side in the registers of the processor.
///
/// Parameters
/// ----------
/// generator : Observer or KalmanFilter
///     The generator.
/// streams : int
///     Number of streams, all at rest at the operating point.
///
/// Examples
/// --------
/// >>> observer = gtfdi.observer(model.output_model("q_c"), poles=0.5)
/// >>> fleet = gtfdi.Fleet(observer, streams=3)
/// >>> three = np.repeat(u[:, :, None], 3, axis=2), np.repeat(y[:, :, None], 3, axis=2)
/// >>> residuals = fleet.process(*three)
/// >>> residuals.shape, bool((residuals[:, 0, 2] == observer.residual(u, y)).all())
/// ((7500, 1, 3), True)
#[pyclass(name = "Fleet", module = "gtfdi")]
pub struct PyFleet {
    inner: Fleet,
    inputs: Vec<String>,
    outputs: Vec<String>,
}

#[pymethods]
impl PyFleet {
    #[new]
    fn py_new(generator: GeneratorArgument<'_>, streams: usize) -> Result<Self, Failure> {
        if streams == 0 {
            return Err(Failure::Option {
                option: "streams",
                expected: "1 or more".to_owned(),
                found: "0".to_owned(),
            });
        }
        let generator: &ResidualGenerator = match &generator {
            GeneratorArgument::Observer(observer) => &observer.get().inner,
            GeneratorArgument::Kalman(filter) => &filter.get().inner,
        };
        Ok(Self {
            inner: Fleet::new(generator, streams),
            inputs: names(generator.inputs()),
            outputs: names(generator.outputs()),
        })
    }

    /// Tags of the inputs.
    #[getter]
    fn inputs(&self) -> Vec<String> {
        self.inputs.clone()
    }

    /// Tags of the outputs.
    #[getter]
    fn outputs(&self) -> Vec<String> {
        self.outputs.clone()
    }

    /// Number of streams.
    #[getter]
    fn streams(&self) -> usize {
        self.inner.streams()
    }

    /// Takes the next samples of all streams and returns the residuals, an array (N, ny, streams)
    /// in the outputs' units.
    ///
    /// Parameters
    /// ----------
    /// u, y : array_like, shapes (N, nu, streams) and (N, ny, streams)
    ///     Inputs and outputs; NaN means *no valid sample*. C-contiguous float64 arrays are read
    ///     where they are.
    ///
    /// Raises
    /// ------
    /// DimensionError
    ///     Sizes disagree; nothing was taken.
    fn process<'py>(
        &mut self,
        u: &Bound<'py, PyAny>,
        y: &Bound<'py, PyAny>,
    ) -> Result<Bound<'py, PyArray3<f64>>, Failure> {
        let py = u.py();
        let (u, y) = (Block::new(u, "u")?, Block::new(y, "y")?);
        let streams = self.inner.streams();
        let [count, ny, _] = y.shape();
        DimensionError::check("samples of u", count, u.shape()[0])?;
        DimensionError::check("channels of u", self.inputs.len(), u.shape()[1])?;
        DimensionError::check("channels of y", self.outputs.len(), ny)?;
        DimensionError::check("streams of u", streams, u.shape()[2])?;
        DimensionError::check("streams of y", streams, y.shape()[2])?;
        let mut residuals = vec![0.0; count * ny * streams];
        let (u, y) = (u.values()?, y.values()?);
        let inner = &mut self.inner;
        py.detach(|| inner.step(u, y, &mut residuals))?;
        Ok(PyArray1::from_vec(py, residuals).reshape([count, ny, streams])?)
    }

    /// All streams back to rest at the operating point.
    fn reset(&mut self) {
        self.inner.reset();
    }

    fn __repr__(&self) -> String {
        format!(
            "Fleet({} streams, inputs: {}, outputs: {})",
            self.inner.streams(),
            self.inputs.join(", "),
            self.outputs.join(", ")
        )
    }
}
