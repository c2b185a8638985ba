//! The streaming statistics: decisions on one residual with memory.

use gtfdi::core::DimensionError;
use gtfdi::fdi::{Decision, Sides, Statistic, Waveform};
use numpy::PyArray1;
use pyo3::prelude::*;

use crate::array::Samples;
use crate::choice::named;
use crate::error::Failure;

/// Samples between two looks for signals.
const BLOCK: usize = 100_000;

/// The sides of zero by name.
pub fn sides(name: &str) -> Result<Sides, Failure> {
    let all = [
        ("upper", Sides::Upper),
        ("lower", Sides::Lower),
        ("both", Sides::Both),
    ];
    named("sides", name, &all)
}

/// The waveforms by name.
pub fn waveform(name: &str) -> Result<Waveform, Failure> {
    let all = [("step", Waveform::Step), ("ramp", Waveform::Ramp)];
    named("waveform", name, &all)
}

/// What `step` gives: the value, whether it alarms and whether the sample was missing.
type Answer = (f64, bool, bool);

fn answer(decision: Decision) -> Answer {
    (decision.value, decision.alarm, decision.missing)
}

/// A statistic over many samples, in blocks between which Ctrl-C is heard.
fn process<'py, S: Statistic + Send>(
    residuals: &Bound<'py, PyAny>,
    statistic: &mut S,
) -> Result<Bound<'py, PyArray1<f64>>, Failure> {
    let py = residuals.py();
    let residuals = Samples::new(residuals, "residuals")?;
    DimensionError::check("channels of residuals", 1, residuals.channels())?;
    let mut values = Vec::with_capacity(residuals.count());
    for block in residuals.values()?.chunks(BLOCK) {
        py.detach(|| values.extend(block.iter().map(|&r| statistic.step(r).value)));
        py.check_signals()?;
    }
    Ok(PyArray1::from_vec(py, values))
}

/// A class around a statistic: what is its own, then what all have.
macro_rules! statistic {
    ($(#[doc = $doc:literal])* $class:ident, $name:literal, $inner:ty, { $($own:tt)* }) => {
        $(#[doc = $doc])*
        #[pyclass(eq, name = $name, module = "gtfdi.statistics")]
        #[derive(PartialEq)]
        pub struct $class {
            pub inner: $inner,
        }

        #[pymethods]
        impl $class {
            $($own)*

            /// Takes one residual, in healthy standard deviations, and returns the statistic,
            /// whether it is above the threshold, and whether the residual was missing (NaN or
            /// infinite: then nothing changes).
            fn step(&mut self, residual: f64) -> Answer {
                answer(self.inner.step(residual))
            }

            /// Takes many residuals, an array (N,) in healthy standard deviations, and returns the
            /// statistic after each, an array (N,). A C-contiguous float64 array is read where it
            /// is.
            fn process<'py>(
                &mut self,
                residuals: &Bound<'py, PyAny>,
            ) -> Result<Bound<'py, PyArray1<f64>>, Failure> {
                process(residuals, &mut self.inner)
            }

            /// Forgets all samples.
            fn reset(&mut self) {
                self.inner.reset();
            }

            /// The statistic after the last sample.
            #[getter]
            fn value(&self) -> f64 {
                self.inner.value()
            }

            /// The value above which the alarm is up.
            #[getter]
            fn threshold(&self) -> f64 {
                self.inner.threshold()
            }

            fn __reduce__<'py>(&self, py: Python<'py>) -> Result<Reduced<'py>, Failure> {
                reduce(py, self)
            }
        }

        pickle_inner!($class, $inner);
    };
}

mod adaptive_threshold;
mod cusum_fleet;
mod energy;
mod mean;

pub use adaptive_threshold::PyAdaptiveThreshold;
pub use cusum_fleet::PyCusumFleet;
pub use energy::{
    PyGrowingChiSquare, PyGrowingVariance, PyWhiteness, PyWindowedChiSquare, PyWindowedVariance,
};
pub use mean::{PyCusum, PyGlr, PyMovingAverage, PyRunSum, PyShiryaevRoberts, PySprt};
