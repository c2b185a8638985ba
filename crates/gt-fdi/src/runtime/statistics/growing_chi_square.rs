//! The energy of a residual since the window began.

use serde::{Deserialize, Serialize};

use super::growth::LARGEST_SUM;
use super::normal_score::normal_score;
use super::statistic::Statistic;
use super::{Growth, Sides, StatisticError, check_state, check_threshold};

/// The sum of the squares of all `n` residuals since the window began: chi-square with `n` degrees
/// of freedom while they are healthy and white. The value is its normal score
/// `((sum / n)^(1/3) - (1 - v)) / sqrt(v)`, `v = 2 / (9 n)` (Wilson and Hilferty, *Proceedings of the
/// National Academy of Sciences* 17, 1931), folded to the sides that count; 0 while the window is
/// shorter than the shortest that is looked at.
///
/// # What the threshold means
///
/// At any one length of the window, a healthy residual is above the threshold `c` with the
/// probability that a standard normal variable is (`1 - Phi(c)`; twice that with both sides): the
/// threshold does not depend on the length. Looked at again and again, the window has more chances:
/// lengths that differ by a factor of a few are nearly independent looks, so that the probability of
/// a false alarm up to the length `n` grows with `ln(n / shortest)`. A window that grows for ever
/// has an alarm in the end, by the law of the iterated logarithm, but for `c` above 1 after a time
/// whose mean is infinite. A finite mean time between false alarms needs a longest window; then
/// [`SimulatedRuns`](crate::design::SimulatedRuns) measures it.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(try_from = "Unchecked")]
pub struct GrowingChiSquare {
    growth: Growth,
    threshold: f64,
    sides: Sides,
    count: u64,
    sum: f64,
}

/// The fields of a [`GrowingChiSquare`] as they come from a file.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Unchecked {
    growth: Growth,
    threshold: f64,
    sides: Sides,
    count: u64,
    sum: f64,
}

impl TryFrom<Unchecked> for GrowingChiSquare {
    type Error = StatisticError;

    fn try_from(raw: Unchecked) -> Result<Self, StatisticError> {
        let made = Self::new(raw.growth, raw.threshold, raw.sides)?;
        check_state("count", raw.count as f64, 0.0, raw.growth.longest as f64)?;
        let largest = if raw.count > 0 { LARGEST_SUM } else { 0.0 };
        check_state("sum", raw.sum, 0.0, largest)?;
        Ok(Self {
            count: raw.count,
            sum: raw.sum,
            ..made
        })
    }
}

impl GrowingChiSquare {
    /// A window without samples that is looked at from `growth.shortest` samples (1 or more) on and
    /// begins anew after `growth.longest`, with the `threshold` (above 0) on the normal score, in
    /// standard deviations of a standard normal variable. [`Sides::Upper`] looks for an energy that
    /// is too large.
    ///
    /// # Errors
    /// [`StatisticError::Growth`] or [`StatisticError::Threshold`].
    pub fn new(growth: Growth, threshold: f64, sides: Sides) -> Result<Self, StatisticError> {
        growth.check(1)?;
        check_threshold(threshold)?;
        Ok(Self {
            growth,
            threshold,
            sides,
            count: 0,
            sum: 0.0,
        })
    }

    /// Samples in the window.
    pub fn count(&self) -> u64 {
        self.count
    }

    /// The sum of their squares, which has no unit.
    pub fn sum(&self) -> f64 {
        self.sum
    }
}

impl Statistic for GrowingChiSquare {
    fn take(&mut self, r: f64) {
        if self.count >= self.growth.longest {
            self.reset();
        }
        self.count += 1;
        self.sum += r * r;
    }

    fn reset(&mut self) {
        self.count = 0;
        self.sum = 0.0;
    }

    fn value(&self) -> f64 {
        if self.count < self.growth.shortest {
            return 0.0;
        }
        self.sides.fold(normal_score(self.sum, self.count as f64))
    }

    fn threshold(&self) -> f64 {
        self.threshold
    }
}
