//! The threshold on a moving average.

use serde::{Deserialize, Serialize};

use super::sliding_sum::SlidingSum;
use super::statistic::Statistic;
use super::{Sides, StatisticError, check_threshold};

/// The mean of the last `window` residuals, on the sides that count: its value is the mean, its
/// negative or its modulus, in standard deviations of the residual.
///
/// The mean of healthy white residuals has the standard deviation `1 / sqrt(window)`.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(try_from = "Unchecked")]
pub struct MovingAverage {
    threshold: f64,
    sides: Sides,
    sum: SlidingSum,
}

/// The fields of a [`MovingAverage`] as they come from a file.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Unchecked {
    threshold: f64,
    sides: Sides,
    sum: SlidingSum,
}

impl TryFrom<Unchecked> for MovingAverage {
    type Error = StatisticError;

    fn try_from(raw: Unchecked) -> Result<Self, StatisticError> {
        check_threshold(raw.threshold)?;
        Ok(Self {
            threshold: raw.threshold,
            sides: raw.sides,
            sum: raw.sum,
        })
    }
}

impl MovingAverage {
    /// A moving average over `window` zeros, 1 to [`MAX_WINDOW`](super::MAX_WINDOW), with the
    /// `threshold` (above 0) on the mean, in standard deviations of the residual.
    ///
    /// # Errors
    /// [`StatisticError::Window`] or [`StatisticError::Threshold`].
    pub fn new(window: usize, threshold: f64, sides: Sides) -> Result<Self, StatisticError> {
        let sum = SlidingSum::new(window)?;
        check_threshold(threshold)?;
        Ok(Self {
            threshold,
            sides,
            sum,
        })
    }

    /// Samples in the window.
    pub fn window(&self) -> usize {
        self.sum.width()
    }

    /// The mean with its sign.
    pub fn mean(&self) -> f64 {
        self.sum.sum() / self.window() as f64
    }
}

impl Statistic for MovingAverage {
    fn take(&mut self, r: f64) {
        self.sum.push(r);
    }

    fn reset(&mut self) {
        self.sum.reset();
    }

    fn value(&self) -> f64 {
        self.sides.fold(self.mean())
    }

    fn threshold(&self) -> f64 {
        self.threshold
    }
}
