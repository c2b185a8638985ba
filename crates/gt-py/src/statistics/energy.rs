//! Statistics of the residual's energy, noise and colour.

use gtfdi::fdi::{
    GrowingChiSquare, GrowingVariance, Growth, Statistic, Whiteness, WindowedChiSquare,
    WindowedVariance,
};
use numpy::PyArray1;
use pyo3::prelude::*;

use super::{Answer, answer, process, sides as sides_of};
use crate::error::Failure;
use crate::pickle::{Reduced, pickle_inner, reduce};

/// A growing window; without an end it begins anew only when it is told to.
fn growth(shortest: u64, longest: Option<u64>) -> Growth {
    Growth {
        shortest,
        longest: longest.unwrap_or(u64::MAX),
    }
}

statistic! {
    /// The sum of the squares of the last samples: more energy.
    ///
    /// Parameters
    /// ----------
    /// window : int
    ///     Samples in the sum; those before the first count as 0.
    /// threshold : float
    ///     On the sum, which is chi-square with as many degrees of freedom while all is well.
    ///
    /// Examples
    /// --------
    /// >>> from gtfdi.statistics import WindowedChiSquare
    /// >>> WindowedChiSquare(2, 9.0).process([1.0, 2.0, 3.0])
    /// array([ 1.,  5., 13.])
    PyWindowedChiSquare, "WindowedChiSquare", WindowedChiSquare, {
        #[new]
        fn py_new(window: usize, threshold: f64) -> Result<Self, Failure> {
            let inner = WindowedChiSquare::new(window, threshold)?;
            Ok(Self { inner })
        }

        /// Samples in the sum.
        #[getter]
        fn window(&self) -> usize {
            self.inner.window()
        }
    }
}

statistic! {
    /// The sum of squares of a window that grows and begins anew.
    ///
    /// Parameters
    /// ----------
    /// shortest : int
    ///     Samples from which on it is judged.
    /// threshold : float
    ///     On its normal score.
    /// longest : int, optional
    ///     Samples after which a new window begins; never where left out.
    /// sides : {"upper", "lower", "both"}, default "upper"
    ///     More energy, less energy, or either.
    ///
    /// Examples
    /// --------
    /// >>> from gtfdi.statistics import GrowingChiSquare
    /// >>> statistic = GrowingChiSquare(2, 3.0)
    /// >>> _ = statistic.process([1.0, 2.0, 2.0])
    /// >>> statistic.count, statistic.sum
    /// (3, 9.0)
    PyGrowingChiSquare, "GrowingChiSquare", GrowingChiSquare, {
        #[new]
        #[pyo3(signature = (shortest, threshold, longest=None, sides="upper"))]
        fn py_new(
            shortest: u64,
            threshold: f64,
            longest: Option<u64>,
            sides: &str,
        ) -> Result<Self, Failure> {
            let growth = growth(shortest, longest);
            let inner = GrowingChiSquare::new(growth, threshold, sides_of(sides)?)?;
            Ok(Self { inner })
        }

        /// Samples in the window.
        #[getter]
        fn count(&self) -> u64 {
            self.inner.count()
        }

        /// The sum of their squares.
        #[getter]
        fn sum(&self) -> f64 {
            self.inner.sum()
        }
    }
}

statistic! {
    /// The variance of the last samples about their mean, as a normal score: more or less noise.
    ///
    /// Parameters
    /// ----------
    /// window : int
    ///     Samples in the window; nothing is judged before it is full.
    /// threshold : float
    ///     On the normal score.
    /// sides : {"upper", "lower", "both"}, default "both"
    ///     More noise, less noise, or either.
    ///
    /// Examples
    /// --------
    /// >>> from gtfdi.statistics import WindowedVariance
    /// >>> statistic = WindowedVariance(4, 3.0)
    /// >>> _ = statistic.process([1.0, -1.0, 1.0, -1.0])
    /// >>> round(statistic.variance, 6)  # four squares of 1 over three degrees of freedom
    /// 1.333333
    PyWindowedVariance, "WindowedVariance", WindowedVariance, {
        #[new]
        #[pyo3(signature = (window, threshold, sides="both"))]
        fn py_new(window: usize, threshold: f64, sides: &str) -> Result<Self, Failure> {
            let inner = WindowedVariance::new(window, threshold, sides_of(sides)?)?;
            Ok(Self { inner })
        }

        /// Samples in the window.
        #[getter]
        fn window(&self) -> usize {
            self.inner.window()
        }

        /// The variance of the window, ``None`` while it is not full.
        #[getter]
        fn variance(&self) -> Option<f64> {
            self.inner.variance()
        }
    }
}

statistic! {
    /// The variance of a window that grows and begins anew.
    ///
    /// Parameters
    /// ----------
    /// shortest : int
    ///     Samples from which on it is judged.
    /// threshold : float
    ///     On its normal score.
    /// longest : int, optional
    ///     Samples after which a new window begins; never where left out.
    /// sides : {"upper", "lower", "both"}, default "both"
    ///     More noise, less noise, or either.
    ///
    /// Examples
    /// --------
    /// >>> from gtfdi.statistics import GrowingVariance
    /// >>> statistic = GrowingVariance(2, 3.0)
    /// >>> _ = statistic.process([1.0, 2.0, 3.0])
    /// >>> statistic.count, statistic.mean, statistic.variance
    /// (3, 2.0, 1.0)
    PyGrowingVariance, "GrowingVariance", GrowingVariance, {
        #[new]
        #[pyo3(signature = (shortest, threshold, longest=None, sides="both"))]
        fn py_new(
            shortest: u64,
            threshold: f64,
            longest: Option<u64>,
            sides: &str,
        ) -> Result<Self, Failure> {
            let growth = growth(shortest, longest);
            let inner = GrowingVariance::new(growth, threshold, sides_of(sides)?)?;
            Ok(Self { inner })
        }

        /// Samples in the window.
        #[getter]
        fn count(&self) -> u64 {
            self.inner.count()
        }

        /// Their mean.
        #[getter]
        fn mean(&self) -> f64 {
            self.inner.mean()
        }

        /// Their variance, ``None`` with fewer than two.
        #[getter]
        fn variance(&self) -> Option<f64> {
            self.inner.variance()
        }
    }
}

statistic! {
    /// The portmanteau statistic of the autocorrelations of the last samples: a model that no longer
    /// fits.
    ///
    /// Parameters
    /// ----------
    /// window : int
    ///     Samples in the window; nothing is judged before it is full.
    /// lags : int
    ///     The largest lag.
    /// threshold : float
    ///     On the statistic, which is about chi-square with as many degrees of freedom as lags while
    ///     all is well.
    ///
    /// Examples
    /// --------
    /// >>> from gtfdi.statistics import Whiteness
    /// >>> whiteness = Whiteness(100, 2, 13.8)
    /// >>> bool(whiteness.process(np.tile([1.0, -1.0], 100))[-1] > 13.8)
    /// True
    PyWhiteness, "Whiteness", Whiteness, {
        #[new]
        fn py_new(window: usize, lags: usize, threshold: f64) -> Result<Self, Failure> {
            let inner = Whiteness::new(window, lags, threshold)?;
            Ok(Self { inner })
        }

        /// Samples in the window.
        #[getter]
        fn window(&self) -> usize {
            self.inner.window()
        }

        /// The largest lag.
        #[getter]
        fn lags(&self) -> usize {
            self.inner.lags()
        }

        /// The autocorrelations at the lags 1, 2, ..., an array.
        #[getter]
        fn correlations<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<f64>> {
            PyArray1::from_vec(py, self.inner.correlations().collect())
        }
    }
}
