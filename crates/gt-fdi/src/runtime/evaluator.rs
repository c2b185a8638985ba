//! The statistic of a detector, whichever it is.

use serde::{Deserialize, Serialize};

use super::{
    Cusum, Glr, MovingAverage, ShiryaevRoberts, Statistic, Whiteness, WindowedChiSquare,
    WindowedVariance,
};

/// One of the statistics that detectors watch.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(tag = "kind", rename_all = "snake_case", deny_unknown_fields)]
pub enum Evaluator {
    /// The modulus of the last residual.
    Modulus(Modulus),
    /// The cumulative sum.
    Cusum(Cusum),
    /// The generalised likelihood ratio of steps or ramps.
    Glr(Glr),
    /// The moving average.
    MovingAverage(MovingAverage),
    /// The sum of squares over a window.
    ChiSquare(WindowedChiSquare),
    /// The Shiryaev-Roberts procedure.
    ShiryaevRoberts(ShiryaevRoberts),
    /// The variance over a window.
    Variance(WindowedVariance),
    /// The correlations over a window.
    Whiteness(Whiteness),
}

/// The modulus of the last residual, without memory (the paper's eq. 26).
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Modulus {
    threshold: f64,
    value: f64,
}

impl Modulus {
    /// Of no residual yet. The threshold is compared as it is: a NaN or negative one is of no use,
    /// but harmless.
    pub fn new(threshold: f64) -> Self {
        Self {
            threshold,
            value: 0.0,
        }
    }
}

impl Statistic for Modulus {
    fn take(&mut self, r: f64) {
        self.value = r.abs();
    }

    fn reset(&mut self) {
        self.value = 0.0;
    }

    fn value(&self) -> f64 {
        self.value
    }

    fn threshold(&self) -> f64 {
        self.threshold
    }
}

/// What a statistic makes of a fault when its alarm comes up, in the residual's own terms.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Estimate {
    /// Samples since the onset, the newest included.
    pub age: u64,
    /// The deviation of the residual's mean at the newest sample, with its sign, in the standard
    /// deviations of the whitened residual.
    pub deviation: f64,
}

impl Evaluator {
    fn inner(&self) -> &dyn Statistic {
        match self {
            Self::Modulus(statistic) => statistic,
            Self::Cusum(statistic) => statistic,
            Self::Glr(statistic) => statistic,
            Self::MovingAverage(statistic) => statistic,
            Self::ChiSquare(statistic) => statistic,
            Self::ShiryaevRoberts(statistic) => statistic,
            Self::Variance(statistic) => statistic,
            Self::Whiteness(statistic) => statistic,
        }
    }

    /// The likeliest onset and size, where the statistic says something of them and something has
    /// happened.
    pub fn estimate(&self) -> Option<Estimate> {
        match self {
            Self::Cusum(cusum) => cusum
                .change()
                .map(|(age, deviation)| Estimate { age, deviation }),
            Self::Glr(glr) => glr.change().map(|change| Estimate {
                age: change.age as u64,
                deviation: glr.deviation(change),
            }),
            _ => None,
        }
    }

    /// Keeps an accumulated value from growing beyond what an alarm needs, so that a long fault is
    /// not remembered for as long again: cumulative sums stop at `ceiling`.
    pub(crate) fn cap(&mut self, ceiling: f64) {
        match self {
            Self::Cusum(statistic) => statistic.cap(ceiling),
            Self::ShiryaevRoberts(statistic) => statistic.cap(ceiling),
            _ => {}
        }
    }
}

impl Statistic for Evaluator {
    fn take(&mut self, r: f64) {
        match self {
            Self::Modulus(statistic) => statistic.take(r),
            Self::Cusum(statistic) => statistic.take(r),
            Self::Glr(statistic) => statistic.take(r),
            Self::MovingAverage(statistic) => statistic.take(r),
            Self::ChiSquare(statistic) => statistic.take(r),
            Self::ShiryaevRoberts(statistic) => statistic.take(r),
            Self::Variance(statistic) => statistic.take(r),
            Self::Whiteness(statistic) => statistic.take(r),
        }
    }

    fn reset(&mut self) {
        match self {
            Self::Modulus(statistic) => statistic.reset(),
            Self::Cusum(statistic) => statistic.reset(),
            Self::Glr(statistic) => statistic.reset(),
            Self::MovingAverage(statistic) => statistic.reset(),
            Self::ChiSquare(statistic) => statistic.reset(),
            Self::ShiryaevRoberts(statistic) => statistic.reset(),
            Self::Variance(statistic) => statistic.reset(),
            Self::Whiteness(statistic) => statistic.reset(),
        }
    }

    fn value(&self) -> f64 {
        self.inner().value()
    }

    fn threshold(&self) -> f64 {
        self.inner().threshold()
    }
}
