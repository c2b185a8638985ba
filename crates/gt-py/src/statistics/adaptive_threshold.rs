//! `AdaptiveThreshold`: a limit that gives way while the inputs move.

use gtfdi::fdi::AdaptiveThreshold;
use pyo3::prelude::*;

use super::{Answer, answer};
use crate::array::vector;
use crate::error::Failure;
use crate::pickle::{Reduced, pickle_inner, reduce};

/// A limit on the modulus of a residual that gives way while the inputs move.
///
/// ``limit = base + a`` with ``a = q a + sum_j gains[j] |u_j - u_j before|`` and
/// ``q = exp(-1 / time_constant)``.
///
/// Parameters
/// ----------
/// base : float
///     The limit at rest, in the residual's unit.
/// gains : array_like, shape (nu,)
///     By how much it gives way, per unit of each input.
/// time_constant : float
///     With which it comes back, in samples.
///
/// Examples
/// --------
/// >>> from gtfdi.statistics import AdaptiveThreshold
/// >>> threshold = AdaptiveThreshold(2.0, [0.5], 10.0)
/// >>> threshold.step([100.0], 3.0)
/// (1.5, True, False)
/// >>> threshold.step([104.0], 3.0)  # the input moved by 4
/// (0.75, False, False)
/// >>> threshold.limit
/// 4.0
#[pyclass(eq, name = "AdaptiveThreshold", module = "gtfdi.statistics")]
#[derive(PartialEq)]
pub struct PyAdaptiveThreshold {
    inner: AdaptiveThreshold,
}

#[pymethods]
impl PyAdaptiveThreshold {
    #[new]
    fn py_new(base: f64, gains: &Bound<'_, PyAny>, time_constant: f64) -> Result<Self, Failure> {
        let gains = vector(gains, "gains")?;
        let inner = AdaptiveThreshold::new(base, gains.as_slice(), time_constant)?;
        Ok(Self { inner })
    }

    /// Takes the inputs (nu,) and the residual of one sample and returns ``|residual| / limit``,
    /// whether it is above 1, and whether something was missing (then nothing changes).
    fn step(&mut self, u: &Bound<'_, PyAny>, residual: f64) -> Result<Answer, Failure> {
        let u = vector(u, "u")?;
        Ok(answer(self.inner.step(u.as_slice(), residual)?))
    }

    /// Forgets all samples.
    fn reset(&mut self) {
        self.inner.reset();
    }

    /// The limit after the last sample, in the residual's unit.
    #[getter]
    fn limit(&self) -> f64 {
        self.inner.limit()
    }

    /// ``|residual| / limit`` after the last sample.
    #[getter]
    fn value(&self) -> f64 {
        self.inner.value()
    }

    fn __reduce__<'py>(&self, py: Python<'py>) -> Result<Reduced<'py>, Failure> {
        reduce(py, self)
    }
}

pickle_inner!(PyAdaptiveThreshold, AdaptiveThreshold);
