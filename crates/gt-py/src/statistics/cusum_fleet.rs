//! `CusumFleet`: the cumulative sum on many streams at once.

use gtfdi::core::DimensionError;
use gtfdi::fdi::CusumFleet;
use numpy::{PyArray1, PyArray2, PyArrayMethods};
use pyo3::prelude::*;

use super::mean::PyCusum;
use crate::array::Samples;
use crate::error::Failure;

/// One Cusum on many streams, such as the residuals of a Fleet of one output.
///
/// The values are those of the Cusum on each stream by itself, bit for bit, and many streams are
/// computed side by side in the registers of the processor. Onsets and sizes are not kept.
///
/// Parameters
/// ----------
/// cusum : Cusum
///     Its allowance, threshold and sides count; its sums do not.
/// streams : int
///     Number of streams, all at zero.
///
/// Examples
/// --------
/// >>> from gtfdi.statistics import Cusum, CusumFleet
/// >>> fleet = CusumFleet(Cusum(0.5, 5.0), streams=2)
/// >>> fleet.process([[2.0, 0.0], [2.0, -3.0]])
/// array([[1.5, 0. ],
///        [3. , 2.5]])
#[pyclass(name = "CusumFleet", module = "gtfdi.statistics")]
pub struct PyCusumFleet {
    inner: CusumFleet,
}

#[pymethods]
impl PyCusumFleet {
    #[new]
    fn py_new(cusum: PyRef<'_, PyCusum>, streams: usize) -> Result<Self, Failure> {
        if streams == 0 {
            return Err(Failure::Option {
                option: "streams",
                expected: "1 or more".to_owned(),
                found: "0".to_owned(),
            });
        }
        Ok(Self {
            inner: CusumFleet::new(&cusum.inner, streams),
        })
    }

    /// Number of streams.
    #[getter]
    fn streams(&self) -> usize {
        self.inner.streams()
    }

    /// The value above which an alarm is up.
    #[getter]
    fn threshold(&self) -> f64 {
        self.inner.threshold()
    }

    /// Takes the next residuals of all streams, an array (N, streams) in healthy standard
    /// deviations, and returns the values after each, an array (N, streams). One that is NaN or
    /// infinite leaves its stream as it was. A C-contiguous float64 array is read where it is.
    ///
    /// Raises
    /// ------
    /// DimensionError
    ///     Another number of streams; nothing was taken.
    fn process<'py>(
        &mut self,
        residuals: &Bound<'py, PyAny>,
    ) -> Result<Bound<'py, PyArray2<f64>>, Failure> {
        let py = residuals.py();
        let residuals = Samples::new(residuals, "residuals")?;
        let streams = self.inner.streams();
        DimensionError::check("streams of residuals", streams, residuals.channels())?;
        let taken = residuals.values()?;
        let mut values = vec![0.0; taken.len()];
        let inner = &mut self.inner;
        py.detach(|| inner.step(taken, &mut values))?;
        Ok(PyArray1::from_vec(py, values).reshape([residuals.count(), streams])?)
    }

    /// All sums back to zero.
    fn reset(&mut self) {
        self.inner.reset();
    }

    fn __repr__(&self) -> String {
        format!(
            "CusumFleet({} streams, threshold {})",
            self.inner.streams(),
            self.inner.threshold()
        )
    }
}
