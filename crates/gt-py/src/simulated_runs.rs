//! `SimulatedRuns`: run lengths of any statistic by simulation.

use gtfdi::core::DimensionError;
use gtfdi::fdi::{SimulatedRunLength, SimulatedRuns, Statistic};
use pyo3::prelude::*;
use pyo3::types::{IntoPyDict, PyDict};

use crate::array::vector;
use crate::error::Failure;
use crate::pickle::{Reduced, pickle_inner, reduce};
use crate::statistics::{
    PyCusum, PyGlr, PyGrowingChiSquare, PyGrowingVariance, PyMovingAverage, PyRunSum,
    PyShiryaevRoberts, PySprt, PyWhiteness, PyWindowedChiSquare, PyWindowedVariance,
};

/// Any streaming statistic, and what is done with each.
macro_rules! statistics {
    ($($variant:ident($class:ty) $name:literal),* $(,)?) => {
        /// Any streaming statistic.
        #[derive(FromPyObject)]
        pub enum AnyStatistic<'py> {
            $(
                #[doc = $name]
                #[pyo3(annotation = $name)]
                $variant(Bound<'py, $class>),
            )*
        }

        impl AnyStatistic<'_> {
            /// The paths of the statistic, which itself stays as it is.
            fn runs(
                &self,
                noise: &Bound<'_, PyAny>,
                paths: usize,
                samples: usize,
            ) -> Result<SimulatedRuns, Failure> {
                match self {
                    $(
                        Self::$variant(statistic) => {
                            let own = statistic.try_borrow().map_err(PyErr::from)?;
                            simulated(own.inner.clone(), noise, paths, samples)
                        }
                    )*
                }
            }
        }
    };
}

statistics![
    Cusum(PyCusum) "Cusum",
    ShiryaevRoberts(PyShiryaevRoberts) "ShiryaevRoberts",
    Glr(PyGlr) "Glr",
    MovingAverage(PyMovingAverage) "MovingAverage",
    RunSum(PyRunSum) "RunSum",
    Sprt(PySprt) "Sprt",
    WindowedChiSquare(PyWindowedChiSquare) "WindowedChiSquare",
    WindowedVariance(PyWindowedVariance) "WindowedVariance",
    Whiteness(PyWhiteness) "Whiteness",
    GrowingChiSquare(PyGrowingChiSquare) "GrowingChiSquare",
    GrowingVariance(PyGrowingVariance) "GrowingVariance",
];

/// Simulated running of a statistic, from which the average run length at every threshold can be
/// read.
///
/// A path begins with a statistic that is reset. When many paths end before an alarm, the run
/// length supposes that an alarm is as likely at any time of a path, which holds when paths are long
/// against the statistic's memory.
///
/// Parameters
/// ----------
/// statistic : a class of gtfdi.statistics
///     Any but the AdaptiveThreshold. It stays as it is, and its threshold does not matter.
/// noise : callable
///     Gives the residuals of a path, an array (samples,) in healthy standard deviations, from its
///     index, so that any path can be made again alone.
/// paths, samples : int
///     Number of paths, and of samples of each.
///
/// Raises
/// ------
/// DesignError
///     There are no paths or no samples.
/// DimensionError
///     The noise has another number of samples.
///
/// Examples
/// --------
/// >>> from gtfdi.run_length import SimulatedRuns, cusum
/// >>> from gtfdi.statistics import Cusum
/// >>> white = lambda path: np.random.default_rng([1, path]).standard_normal(600)
/// >>> runs = SimulatedRuns(Cusum(0.5, 2.5), white, paths=2000, samples=600)
/// >>> found = runs.run_length(2.5)
/// >>> found["low"] < cusum(0.5, 2.5) < found["high"]
/// True
#[pyclass(frozen, eq, name = "SimulatedRuns", module = "gtfdi.run_length")]
#[derive(PartialEq)]
pub struct PySimulatedRuns {
    inner: SimulatedRuns,
}

#[pymethods]
impl PySimulatedRuns {
    #[new]
    fn py_new(
        statistic: AnyStatistic<'_>,
        noise: &Bound<'_, PyAny>,
        paths: usize,
        samples: usize,
    ) -> Result<Self, Failure> {
        let inner = statistic.runs(noise, paths, samples)?;
        Ok(Self { inner })
    }

    /// The average run length at a threshold.
    ///
    /// Returns
    /// -------
    /// dict
    ///     ``threshold``; ``samples``, the run length; ``low`` and ``high``, its 99 % interval;
    ///     ``alarms``, the paths that crossed the threshold.
    ///
    /// Raises
    /// ------
    /// DesignError
    ///     Fewer than 20 paths cross the threshold.
    fn run_length<'py>(
        &self,
        py: Python<'py>,
        threshold: f64,
    ) -> Result<Bound<'py, PyDict>, Failure> {
        let found = self.inner.run_length(threshold)?;
        Ok(found_out(py, &found)?)
    }

    /// The smallest threshold with an average run length of at least that many samples, with its
    /// interval: a dictionary as of ``run_length``.
    ///
    /// Raises
    /// ------
    /// DesignError
    ///     The paths are too few or too short for it.
    fn threshold_for<'py>(
        &self,
        py: Python<'py>,
        run_length: f64,
    ) -> Result<Bound<'py, PyDict>, Failure> {
        let found = py.detach(|| self.inner.threshold_for(run_length))?;
        Ok(found_out(py, &found)?)
    }

    fn __reduce__<'py>(&self, py: Python<'py>) -> Result<Reduced<'py>, Failure> {
        reduce(py, self)
    }
}

pickle_inner!(PySimulatedRuns, SimulatedRuns);

/// Path by path, with a look for signals and the noise between two.
fn simulated<S: Statistic + Send>(
    mut statistic: S,
    noise: &Bound<'_, PyAny>,
    paths: usize,
    samples: usize,
) -> Result<SimulatedRuns, Failure> {
    let py = noise.py();
    if paths == 0 || samples == 0 {
        // What is wrong is said where the paths would begin.
        let none = SimulatedRuns::run(&mut statistic, paths, samples, |_| || f64::NAN)?;
        return Ok(none);
    }
    let mut path = |index: usize| -> Result<SimulatedRuns, Failure> {
        py.check_signals()?;
        let residuals = vector(&noise.call1((index,))?, "noise")?;
        DimensionError::check("samples of noise", samples, residuals.len())?;
        let statistic = &mut statistic;
        let runs = py.detach(move || {
            let mut residuals = Some(residuals.as_slice().iter().copied());
            SimulatedRuns::run(statistic, 1, samples, |_| {
                let mut own = residuals.take();
                move || own.as_mut().and_then(Iterator::next).unwrap_or(f64::NAN)
            })
        })?;
        Ok(runs)
    };
    let mut runs = path(0)?;
    for index in 1..paths {
        runs.extend(path(index)?)?;
    }
    Ok(runs)
}

fn found_out<'py>(py: Python<'py>, found: &SimulatedRunLength) -> PyResult<Bound<'py, PyDict>> {
    let entries = [
        ("threshold", found.threshold),
        ("samples", found.samples),
        ("low", found.low),
        ("high", found.high),
    ];
    let entry = entries.into_py_dict(py)?;
    entry.set_item("alarms", found.alarms)?;
    Ok(entry)
}
