//! The outcome of one chi-square test.

use serde::{Deserialize, Serialize};

use crate::distributions::{chi_square_tail, chi_square_threshold};

/// A statistic that is distributed as `scale` times a chi-square variable where the hypothesis
/// holds.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct ChiSquareTest {
    /// The statistic.
    pub statistic: f64,
    /// Degrees of freedom, correction included; not whole where the correction is not.
    pub degrees_of_freedom: f64,
    /// What the estimated coefficients add to the plain count of correlations: negative on the
    /// record of the fit, positive on another one.
    pub correction: f64,
    /// 1 where the correlations that are tested are equally precise.
    pub scale: f64,
    /// Probability of a statistic at least this large where the hypothesis holds.
    pub p_value: f64,
}

impl ChiSquareTest {
    /// A test on `count + correction` degrees of freedom; `None` where none is left.
    pub(crate) fn new(statistic: f64, count: usize, correction: f64) -> Option<Self> {
        Self::scaled(statistic, count as f64, count as f64 + correction, 1.0)
    }

    /// A sum of `count` squared correlations whose expectation is that of `mean` degrees of freedom
    /// and whose variance is that of `spread` (both `count` for correlations of variance 1): the
    /// scaled chi-square law of the same two moments (Satterthwaite 1946).
    pub(crate) fn matched(statistic: f64, count: usize, mean: f64, spread: f64) -> Option<Self> {
        let matched = mean > 0.0 && spread > 0.0;
        let scale = spread / mean;
        Self::scaled(statistic, count as f64, mean / scale, scale).filter(|_| matched)
    }

    fn scaled(statistic: f64, count: f64, degrees_of_freedom: f64, scale: f64) -> Option<Self> {
        (degrees_of_freedom > 0.0).then(|| Self {
            statistic,
            degrees_of_freedom,
            correction: degrees_of_freedom - count,
            scale,
            p_value: chi_square_tail(statistic / scale, degrees_of_freedom),
        })
    }

    /// Whether the hypothesis is rejected at a significance (the rate of false rejections).
    pub fn rejects(&self, significance: f64) -> bool {
        self.p_value < significance
    }

    /// The statistic beyond which the hypothesis is rejected at a significance between 0 and 1.
    pub fn threshold(&self, significance: f64) -> f64 {
        self.scale * chi_square_threshold(significance, self.degrees_of_freedom)
    }
}
