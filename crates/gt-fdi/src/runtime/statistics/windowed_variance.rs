//! The variance of a residual in a sliding window.

use alloc::vec::Vec;

use serde::{Deserialize, Serialize};

use super::moments::Moments;
use super::normal_score::normal_score;
use super::sliding_moments::SlidingMoments;
use super::statistic::{LARGEST_SAMPLE, Statistic};
use super::{MAX_WINDOW, Sides, StatisticError, check_state, check_threshold};

/// The variance of the last `window` residuals about their own mean, so that a shift of the mean
/// does not count: noise that grows, or that is gone because a sensor stands still.
///
/// With the sample variance `s^2 = sum (r - mean)^2 / (window - 1)`, the sum over the healthy
/// variance 1 is chi-square with `window - 1` degrees of freedom. The value is its normal score
/// `(s^(2/3) - (1 - v)) / sqrt(v)`, `v = 2 / (9 (window - 1))` (Wilson and Hilferty, *Proceedings of
/// the National Academy of Sciences* 17, 1931), folded to the sides that count: standard deviations
/// of a standard normal variable, with the same meaning above as below. It is 0 until the window is
/// full.
///
/// Neighbouring windows overlap, so the time between false alarms is not that of independent
/// draws; [`SimulatedRuns`](crate::design::SimulatedRuns) measures it.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(try_from = "Saved", into = "Saved")]
pub struct WindowedVariance {
    threshold: f64,
    sides: Sides,
    moments: SlidingMoments,
    value: f64,
}

/// What of a [`WindowedVariance`] is saved: all else follows from it.
#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct Saved {
    window: usize,
    threshold: f64,
    sides: Sides,
    samples: Vec<f64>,
}

impl From<WindowedVariance> for Saved {
    fn from(variance: WindowedVariance) -> Self {
        Self {
            window: variance.window(),
            threshold: variance.threshold,
            sides: variance.sides,
            samples: variance.moments.samples().collect(),
        }
    }
}

impl TryFrom<Saved> for WindowedVariance {
    type Error = StatisticError;

    fn try_from(saved: Saved) -> Result<Self, StatisticError> {
        let mut variance = Self::new(saved.window, saved.threshold, saved.sides)?;
        let expected = 2 * saved.window - 1;
        let found = saved.samples.len();
        if found > expected {
            return Err(StatisticError::Length {
                what: "samples",
                expected,
                found,
            });
        }
        for &r in &saved.samples {
            check_state("sample", r, -LARGEST_SAMPLE, LARGEST_SAMPLE)?;
            variance.moments.push(r);
        }
        variance.judge();
        Ok(variance)
    }
}

impl WindowedVariance {
    /// A window without samples for `window` of them, 2 to [`MAX_WINDOW`], with the `threshold`
    /// (above 0) on the normal score, in standard deviations of a standard normal variable.
    /// [`Sides::Upper`] looks for a variance that grows.
    ///
    /// # Errors
    /// [`StatisticError::WindowRange`] or [`StatisticError::Threshold`].
    pub fn new(window: usize, threshold: f64, sides: Sides) -> Result<Self, StatisticError> {
        if !(2..=MAX_WINDOW).contains(&window) {
            return Err(StatisticError::WindowRange {
                shortest: 2,
                longest: MAX_WINDOW,
                found: window,
            });
        }
        check_threshold(threshold)?;
        Ok(Self {
            threshold,
            sides,
            moments: SlidingMoments::new(window),
            value: 0.0,
        })
    }

    /// Samples in the window.
    pub fn window(&self) -> usize {
        self.moments.width()
    }

    /// The sample variance in units of the healthy variance; `None` until the window is full.
    pub fn variance(&self) -> Option<f64> {
        self.moments
            .window()
            .map(|moments| moments.squares / self.degrees())
    }

    fn degrees(&self) -> f64 {
        (self.window() - 1) as f64
    }

    fn judge(&mut self) {
        let score = |moments: Moments| normal_score(moments.squares, self.degrees());
        let window = self.moments.window();
        self.value = window.map_or(0.0, |moments| self.sides.fold(score(moments)));
    }
}

impl Statistic for WindowedVariance {
    fn take(&mut self, r: f64) {
        self.moments.push(r);
        self.judge();
    }

    fn reset(&mut self) {
        self.moments.reset();
        self.judge();
    }

    fn value(&self) -> f64 {
        self.value
    }

    fn threshold(&self) -> f64 {
        self.threshold
    }
}
