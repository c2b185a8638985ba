//! The energy of a residual in a sliding window.

use serde::{Deserialize, Serialize};

use super::sliding_sum::SlidingSum;
use super::statistic::Statistic;
use super::{StatisticError, check_threshold};

/// The sum of the squares of the last `window` residuals: chi-square with `window` degrees of
/// freedom while the residuals are healthy and white, larger when their mean or variance grows.
///
/// Neighbouring windows overlap, so the time between false alarms is not that of independent
/// draws; [`SimulatedRuns`](crate::design::SimulatedRuns) measures it.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(try_from = "Unchecked")]
pub struct WindowedChiSquare {
    threshold: f64,
    squares: SlidingSum,
}

/// The fields of a [`WindowedChiSquare`] as they come from a file.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Unchecked {
    threshold: f64,
    squares: SlidingSum,
}

impl TryFrom<Unchecked> for WindowedChiSquare {
    type Error = StatisticError;

    fn try_from(raw: Unchecked) -> Result<Self, StatisticError> {
        check_threshold(raw.threshold)?;
        raw.squares.check_not_negative()?;
        Ok(Self {
            threshold: raw.threshold,
            squares: raw.squares,
        })
    }
}

impl WindowedChiSquare {
    /// A window over `window` zeros, 1 to [`MAX_WINDOW`](super::MAX_WINDOW), with the `threshold`
    /// (above 0) on the sum of squares, which has no unit.
    ///
    /// # Errors
    /// [`StatisticError::Window`] or [`StatisticError::Threshold`].
    pub fn new(window: usize, threshold: f64) -> Result<Self, StatisticError> {
        let squares = SlidingSum::new(window)?;
        check_threshold(threshold)?;
        Ok(Self { threshold, squares })
    }

    /// Samples in the window.
    pub fn window(&self) -> usize {
        self.squares.width()
    }
}

impl Statistic for WindowedChiSquare {
    fn take(&mut self, r: f64) {
        self.squares.push(r * r);
    }

    fn reset(&mut self) {
        self.squares.reset();
    }

    fn value(&self) -> f64 {
        self.squares.sum()
    }

    fn threshold(&self) -> f64 {
        self.threshold
    }
}
