//! Statistics of the residual's mean.

use gtfdi::fdi::{
    Cusum, Glr, MovingAverage, RunSum, ShiryaevRoberts, Sprt, SprtDecision, Statistic,
};
use numpy::PyArray1;
use pyo3::prelude::*;

use super::{Answer, answer, process, sides as sides_of, waveform as waveform_of};
use crate::error::Failure;
use crate::pickle::{Reduced, pickle_inner, reduce};

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
            let inner = Cusum::new(allowance, threshold, sides_of(sides)?)?;
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
            let inner = ShiryaevRoberts::new(shift, threshold, sides_of(sides)?)?;
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
            let (waveform, sides) = (waveform_of(waveform)?, sides_of(sides)?);
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
            let inner = MovingAverage::new(window, threshold, sides_of(sides)?)?;
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
            let inner = RunSum::new(width, scores, threshold, sides_of(sides)?)?;
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
