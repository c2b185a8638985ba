//! The variance of a residual since the window began.

use serde::{Deserialize, Serialize};

use super::growth::LARGEST_SUM;
use super::moments::Moments;
use super::normal_score::normal_score;
use super::statistic::{LARGEST_SAMPLE, Statistic};
use super::{Growth, Sides, StatisticError, check_state, check_threshold};

/// The variance of all `n` residuals since the window began, about their own mean:
/// `sum (r - mean)^2` is chi-square with `n - 1` degrees of freedom while they are healthy and
/// white, whatever their mean. The value is its normal score, as that of a
/// [`GrowingChiSquare`](super::GrowingChiSquare), where it is said what the threshold means when the
/// window grows; 0 while the window is shorter than the shortest that is looked at.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(try_from = "Unchecked")]
pub struct GrowingVariance {
    growth: Growth,
    threshold: f64,
    sides: Sides,
    moments: Moments,
}

/// The fields of a [`GrowingVariance`] as they come from a file.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Unchecked {
    growth: Growth,
    threshold: f64,
    sides: Sides,
    moments: Moments,
}

impl TryFrom<Unchecked> for GrowingVariance {
    type Error = StatisticError;

    fn try_from(raw: Unchecked) -> Result<Self, StatisticError> {
        let made = Self::new(raw.growth, raw.threshold, raw.sides)?;
        let Moments {
            count,
            mean,
            squares,
        } = raw.moments;
        check_state("count", count as f64, 0.0, raw.growth.longest as f64)?;
        let farthest = if count > 0 { LARGEST_SAMPLE } else { 0.0 };
        check_state("mean", mean, 0.0 - farthest, farthest)?;
        let largest = if count > 1 { LARGEST_SUM } else { 0.0 };
        check_state("squares", squares, 0.0, largest)?;
        Ok(Self {
            moments: raw.moments,
            ..made
        })
    }
}

impl GrowingVariance {
    /// A window without samples that is looked at from `growth.shortest` samples (2 or more) on and
    /// begins anew after `growth.longest`, with the `threshold` (above 0) on the normal score, in
    /// standard deviations of a standard normal variable. [`Sides::Upper`] looks for a variance that
    /// is too large.
    ///
    /// # Errors
    /// [`StatisticError::Growth`] or [`StatisticError::Threshold`].
    pub fn new(growth: Growth, threshold: f64, sides: Sides) -> Result<Self, StatisticError> {
        growth.check(2)?;
        check_threshold(threshold)?;
        Ok(Self {
            growth,
            threshold,
            sides,
            moments: Moments::default(),
        })
    }

    /// Samples in the window.
    pub fn count(&self) -> u64 {
        self.moments.count
    }

    /// Their mean in standard deviations of the residual; 0 without samples.
    pub fn mean(&self) -> f64 {
        self.moments.mean
    }

    /// The sample variance in units of the healthy variance; `None` below two samples.
    pub fn variance(&self) -> Option<f64> {
        let degrees = self.moments.count.saturating_sub(1);
        (degrees > 0).then(|| self.moments.squares / degrees as f64)
    }
}

impl Statistic for GrowingVariance {
    fn take(&mut self, r: f64) {
        if self.moments.count >= self.growth.longest {
            self.reset();
        }
        self.moments = self.moments.with(r);
        // No farther to rounding either.
        let mean = self.moments.mean;
        self.moments.mean = mean.clamp(-LARGEST_SAMPLE, LARGEST_SAMPLE);
    }

    fn reset(&mut self) {
        self.moments = Moments::default();
    }

    fn value(&self) -> f64 {
        let Moments { count, squares, .. } = self.moments;
        if count < self.growth.shortest {
            return 0.0;
        }
        let degrees = count.saturating_sub(1) as f64;
        self.sides.fold(normal_score(squares, degrees))
    }

    fn threshold(&self) -> f64 {
        self.threshold
    }
}
