//! `Trend`: the lines in time that a record loses.

use gtfdi::core::Trend;
use nalgebra::DVector;
use pyo3::prelude::*;

use crate::error::Failure;
use crate::pickle::{Reduced, pickle_inner, reduce};

/// Straight lines in time through the channels of a record: what ``Dataset.detrended`` subtracts
/// from a channel at time t is ``slope * (t - centre_time_s)``.
///
/// Parameters
/// ----------
/// u_slope_per_s, y_slope_per_s : list of float
///     Slopes of the inputs and of the outputs, per second.
/// centre_time_s : float
///     The time at which nothing is subtracted.
///
/// Examples
/// --------
/// >>> t = np.arange(100.0)
/// >>> data = gtfdi.Dataset(np.sin(t), 3.0 + 0.5 * t, 1.0)
/// >>> trend = data.trend()
/// >>> round(trend.y_slope_per_s[0], 6)
/// 0.5
/// >>> flat = data.detrended(trend)
/// >>> bool(np.ptp(flat.y) < 1e-9)
/// True
#[pyclass(name = "Trend", module = "gtfdi", frozen, eq)]
#[derive(PartialEq)]
pub struct PyTrend {
    pub inner: Trend,
}

#[pymethods]
impl PyTrend {
    #[new]
    fn new(u_slope_per_s: Vec<f64>, y_slope_per_s: Vec<f64>, centre_time_s: f64) -> Self {
        Self {
            inner: Trend {
                u_slope_per_s: DVector::from_vec(u_slope_per_s),
                y_slope_per_s: DVector::from_vec(y_slope_per_s),
                centre_time_s,
            },
        }
    }

    /// Slopes of the inputs, per second.
    #[getter]
    fn u_slope_per_s(&self) -> Vec<f64> {
        self.inner.u_slope_per_s.as_slice().to_vec()
    }

    /// Slopes of the outputs, per second.
    #[getter]
    fn y_slope_per_s(&self) -> Vec<f64> {
        self.inner.y_slope_per_s.as_slice().to_vec()
    }

    /// The time at which nothing is subtracted, in seconds.
    #[getter]
    fn centre_time_s(&self) -> f64 {
        self.inner.centre_time_s
    }

    fn __repr__(&self) -> String {
        format!(
            "Trend({:?}, {:?}, {:?})",
            self.u_slope_per_s(),
            self.y_slope_per_s(),
            self.inner.centre_time_s
        )
    }

    fn __reduce__<'py>(&self, py: Python<'py>) -> Result<Reduced<'py>, Failure> {
        reduce(py, self)
    }
}

pickle_inner!(PyTrend, Trend);
