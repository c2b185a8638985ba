//! The streaming statistics: decisions on one residual with memory.

use gtfdi::fdi::{
    AdaptiveThreshold, Cusum, Decision, Glr, GrowingChiSquare, GrowingVariance, Growth,
    MovingAverage, RunSum, ShiryaevRoberts, Sides, Sprt, SprtDecision, Statistic, Waveform,
    Whiteness, WindowedChiSquare, WindowedVariance,
};
use numpy::PyArray1;
use pyo3::prelude::*;

use crate::array::{Samples, vector};
use crate::choice::named;
use crate::error::Failure;
use crate::pickle::{Reduced, pickle_inner, reduce};

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

/// A growing window; without an end it begins anew only when it is told to.
fn growth(shortest: u64, longest: Option<u64>) -> Growth {
    Growth {
        shortest,
        longest: longest.unwrap_or(u64::MAX),
    }
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
    gtfdi::core::DimensionError::check("channels of residuals", 1, residuals.channels())?;
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
            inner: $inner,
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

statistic! {
    /// The cumulative sum for a step of about known size (Page 1954).
    ///
    /// Parameters
    /// ----------
    /// allowance : float
    ///     Half the deviation to be found, in standard deviations.
    /// threshold : float
    ///     The alarm is up while the sum is above it; ``gtfdi.run_length.cusum_threshold`` finds one.
    /// sides : {"upper", "lower", "both"}, default "both"
    ///     Which deviations count.
    ///
    /// Examples
    /// --------
    /// >>> from gtfdi.statistics import Cusum
    /// >>> cusum = Cusum(0.5, 5.0)
    /// >>> cusum.process([0.0, 1.5, 1.5, 1.5])
    /// array([0., 1., 2., 3.])
    /// >>> cusum.step(3.0)
    /// (5.5, True, False)
    PyCusum, "Cusum", Cusum, {
        #[new]
        #[pyo3(signature = (allowance, threshold, sides="both"))]
        fn py_new(allowance: f64, threshold: f64, sides: &str) -> Result<Self, Failure> {
            let inner = Cusum::new(allowance, threshold, self::sides(sides)?)?;
            Ok(Self { inner })
        }

        /// Half the deviation to be found.
        #[getter]
        fn allowance(&self) -> f64 {
            self.inner.allowance()
        }

        /// The sum of what rises.
        #[getter]
        fn upper(&self) -> f64 {
            self.inner.upper()
        }

        /// The sum of what falls.
        #[getter]
        fn lower(&self) -> f64 {
            self.inner.lower()
        }

        /// The likeliest step, a tuple ``(age, size)``: the samples since its onset, the newest
        /// included, and its size with its sign in standard deviations; ``None`` while the sums are
        /// zero.
        #[getter]
        fn change(&self) -> Option<(u64, f64)> {
            self.inner.change()
        }
    }
}

statistic! {
    /// The sum of the likelihood ratios of a step over all onsets (Shiryaev 1963, Roberts 1966), as
    /// ``ln(1 + R)``.
    ///
    /// Parameters
    /// ----------
    /// shift : float
    ///     The step, in standard deviations.
    /// threshold : float
    ///     On ``ln(1 + R)``; ``gtfdi.run_length.shiryaev_roberts_threshold`` finds one.
    /// sides : {"upper", "lower", "both"}, default "both"
    ///     Which deviations count.
    ///
    /// Examples
    /// --------
    /// >>> from gtfdi.statistics import ShiryaevRoberts
    /// >>> statistic = ShiryaevRoberts(1.0, 6.0, "upper")
    /// >>> round(statistic.step(0.5)[0], 6)  # ln 2: the ratio of one sample is exp(d r - d^2 / 2)
    /// 0.693147
    PyShiryaevRoberts, "ShiryaevRoberts", ShiryaevRoberts, {
        #[new]
        #[pyo3(signature = (shift, threshold, sides="both"))]
        fn py_new(shift: f64, threshold: f64, sides: &str) -> Result<Self, Failure> {
            let inner = ShiryaevRoberts::new(shift, threshold, self::sides(sides)?)?;
            Ok(Self { inner })
        }

        /// ``ln(1 + R)`` of a rise.
        #[getter]
        fn upper(&self) -> f64 {
            self.inner.upper()
        }

        /// ``ln(1 + R)`` of a fall.
        #[getter]
        fn lower(&self) -> f64 {
            self.inner.lower()
        }
    }
}

statistic! {
    /// The generalised likelihood ratio of a step or ramp of unknown size and onset.
    ///
    /// Parameters
    /// ----------
    /// waveform : {"step", "ramp"}
    ///     How the fault moves the mean.
    /// sizes : tuple of float
    ///     Smallest and largest size: standard deviations of a step, standard deviations a sample of
    ///     a ramp.
    /// threshold : float
    ///     On the logarithm of the likelihood ratio.
    /// longest : int, default 4096
    ///     How many samples ago an onset may lie.
    /// sides : {"upper", "lower", "both"}, default "both"
    ///     Which deviations count.
    ///
    /// Examples
    /// --------
    /// >>> from gtfdi.statistics import Glr
    /// >>> glr = Glr("step", (0.1, 10.0), 12.0)
    /// >>> glr.process([0.0] * 20 + [3.0] * 4)[-1]
    /// np.float64(18.0)
    /// >>> glr.change  # four samples ago, three standard deviations
    /// (4, 3.0)
    PyGlr, "Glr", Glr, {
        #[new]
        #[pyo3(signature = (waveform, sizes, threshold, longest=4096, sides="both"))]
        fn py_new(
            waveform: &str,
            sizes: (f64, f64),
            threshold: f64,
            longest: usize,
            sides: &str,
        ) -> Result<Self, Failure> {
            let (waveform, sides) = (self::waveform(waveform)?, self::sides(sides)?);
            let inner = Glr::new(waveform, sizes, longest, threshold, sides)?;
            Ok(Self { inner })
        }

        /// The likeliest fault, a tuple ``(age, size)``: the samples since its onset, the newest
        /// included, and its size with its sign; ``None`` while none is likelier than none.
        #[getter]
        fn change(&self) -> Option<(usize, f64)> {
            self.inner.change().map(|change| (change.age, change.size))
        }
    }
}

statistic! {
    /// The modulus of the mean of the last samples.
    ///
    /// Parameters
    /// ----------
    /// window : int
    ///     Samples in the mean; those before the first count as 0.
    /// threshold : float
    ///     In standard deviations.
    /// sides : {"upper", "lower", "both"}, default "both"
    ///     Which deviations count.
    ///
    /// Examples
    /// --------
    /// >>> from gtfdi.statistics import MovingAverage
    /// >>> MovingAverage(2, 1.0).process([2.0, 2.0, 0.0])
    /// array([1., 2., 1.])
    PyMovingAverage, "MovingAverage", MovingAverage, {
        #[new]
        #[pyo3(signature = (window, threshold, sides="both"))]
        fn py_new(window: usize, threshold: f64, sides: &str) -> Result<Self, Failure> {
            let inner = MovingAverage::new(window, threshold, self::sides(sides)?)?;
            Ok(Self { inner })
        }

        /// Samples in the mean.
        #[getter]
        fn window(&self) -> usize {
            self.inner.window()
        }

        /// The mean with its sign.
        #[getter]
        fn mean(&self) -> f64 {
            self.inner.mean()
        }
    }
}

statistic! {
    /// The run sum of zone scores (Roberts 1966, Reynolds 1971).
    ///
    /// Parameters
    /// ----------
    /// width : float
    ///     Width of a zone in standard deviations; ``gtfdi.run_length.run_sum_width`` finds one.
    /// scores : sequence of int, default (0, 2, 4, 8)
    ///     Scores of the four zones from zero outwards: by default the zone control chart's.
    /// threshold : float, default 7
    ///     The alarm is up while the sum is above it.
    /// sides : {"upper", "lower", "both"}, default "both"
    ///     Which deviations count.
    ///
    /// Examples
    /// --------
    /// >>> from gtfdi.statistics import RunSum
    /// >>> RunSum(1.0).process([1.5, 2.5, 2.5, -0.5])
    /// array([ 2.,  6., 10.,  0.])
    PyRunSum, "RunSum", RunSum, {
        #[new]
        #[pyo3(signature = (width, scores=RunSum::ZONE_SCORES, threshold=7.0, sides="both"),
            text_signature = "(width, scores=(0, 2, 4, 8), threshold=7.0, sides='both')")]
        fn py_new(
            width: f64,
            scores: [u32; 4],
            threshold: f64,
            sides: &str,
        ) -> Result<Self, Failure> {
            let inner = RunSum::new(width, scores, threshold, self::sides(sides)?)?;
            Ok(Self { inner })
        }

        /// The sum of the run above zero.
        #[getter]
        fn upper(&self) -> u64 {
            self.inner.upper()
        }

        /// The sum of the run below zero.
        #[getter]
        fn lower(&self) -> u64 {
            self.inner.lower()
        }
    }
}

statistic! {
    /// Wald's sequential test of the mean 0 against another one; it decides once.
    ///
    /// Parameters
    /// ----------
    /// shift : float
    ///     The other mean, in standard deviations.
    /// accept, reject : float
    ///     Logarithms of the likelihood ratio at or below which the mean is 0, and above which it is
    ///     the shift.
    ///
    /// Examples
    /// --------
    /// >>> from gtfdi.statistics import Sprt
    /// >>> sprt = Sprt(1.0, -3.0, 3.0)
    /// >>> sprt.process([2.0, 2.0, 2.0])
    /// array([1.5, 3. , 4.5])
    /// >>> sprt.decision
    /// 'faulty'
    PySprt, "Sprt", Sprt, {
        #[new]
        fn py_new(shift: f64, accept: f64, reject: f64) -> Result<Self, Failure> {
            let inner = Sprt::new(shift, accept, reject)?;
            Ok(Self { inner })
        }

        /// ``"undecided"``, ``"healthy"`` or ``"faulty"``.
        #[getter]
        fn decision(&self) -> &'static str {
            match self.inner.decision() {
                SprtDecision::Undecided => "undecided",
                SprtDecision::Healthy => "healthy",
                SprtDecision::Faulty => "faulty",
            }
        }
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
            let inner = WindowedVariance::new(window, threshold, self::sides(sides)?)?;
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
            let inner = GrowingChiSquare::new(growth, threshold, self::sides(sides)?)?;
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
            let inner = GrowingVariance::new(growth, threshold, self::sides(sides)?)?;
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
