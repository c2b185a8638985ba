//! The Shiryaev-Roberts procedure.

use serde::{Deserialize, Serialize};

use super::statistic::Statistic;
use super::{Sides, StatisticError, check_option, check_state, check_threshold};

/// The sum of the likelihood ratios of a step of known size over all onsets:
/// `R = (1 + R) exp(d r - d^2 / 2)` from `R = 0` (Shiryaev, *Theory of Probability and its
/// Applications* 8, 1963; Roberts, *Technometrics* 8, 1966). Its value is `ln(1 + R)`: it starts at
/// 0, and logarithms do not overflow.
///
/// Among the procedures with the same mean time between false alarms it has the shortest mean delay
/// to a step that comes after a long healthy time and many false alarms (Pollak and Tartakovsky,
/// *Statistica Sinica* 19, 2009), where a [`Cusum`](super::Cusum) is best in the worst case.
///
/// With both sides, `R` is the mean of those of a rise and of a fall. On healthy residuals `R - n`
/// after `n` samples has the mean 0, so that the mean time between false alarms is that of `R` at
/// the alarm: at least `exp(threshold) - 1` samples, with either number of sides (Pollak, *Annals of
/// Statistics* 15, 1987). [`ShiryaevRoberts::safe_threshold`] relies on that;
/// [`ShiryaevRobertsRunLength`](crate::design::ShiryaevRobertsRunLength) finds the lower threshold
/// that just reaches the time.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(try_from = "Unchecked")]
pub struct ShiryaevRoberts {
    shift: f64,
    threshold: f64,
    sides: Sides,
    /// `ln(1 + R)` of a rise.
    upper: f64,
    /// `ln(1 + R)` of a fall.
    lower: f64,
}

/// The fields of a [`ShiryaevRoberts`] as they come from a file.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Unchecked {
    shift: f64,
    threshold: f64,
    sides: Sides,
    upper: f64,
    lower: f64,
}

impl TryFrom<Unchecked> for ShiryaevRoberts {
    type Error = StatisticError;

    fn try_from(raw: Unchecked) -> Result<Self, StatisticError> {
        let made = Self::new(raw.shift, raw.threshold, raw.sides)?;
        for (value, idle) in [
            (raw.upper, raw.sides == Sides::Lower),
            (raw.lower, raw.sides == Sides::Upper),
        ] {
            check_state("value", value, 0.0, if idle { 0.0 } else { f64::MAX })?;
        }
        Ok(Self {
            upper: raw.upper,
            lower: raw.lower,
            ..made
        })
    }
}

impl ShiryaevRoberts {
    /// A procedure at `R = 0` for a step of `shift` standard deviations (above 0) to the `sides`
    /// that count, with the `threshold` (above 0) on `ln(1 + R)`, which has no unit.
    ///
    /// # Errors
    /// [`StatisticError::Option`] for the shift, [`StatisticError::Threshold`].
    pub fn new(shift: f64, threshold: f64, sides: Sides) -> Result<Self, StatisticError> {
        let fits = shift > 0.0 && shift.is_finite();
        check_option("shift", "a positive finite number", shift, fits)?;
        check_threshold(threshold)?;
        Ok(Self {
            shift,
            threshold,
            sides,
            upper: 0.0,
            lower: 0.0,
        })
    }

    /// The threshold `ln(1 + run_length)`, at which the mean time between false alarms is
    /// `run_length` samples (above 0) or more, whatever the shift and the sides. It is more by about
    /// `exp(0.583 shift)`, the mean overshoot of `R` for small shifts.
    ///
    /// # Errors
    /// [`StatisticError::Option`] for a run length that is not positive and finite.
    pub fn safe_threshold(run_length: f64) -> Result<f64, StatisticError> {
        let fits = run_length > 0.0 && run_length.is_finite();
        check_option("run_length", "a positive finite number", run_length, fits)?;
        Ok(libm::log1p(run_length))
    }

    /// `ln(1 + R)` of a rise; 0 with [`Sides::Lower`].
    pub fn upper(&self) -> f64 {
        self.upper
    }

    /// `ln(1 + R)` of a fall; 0 with [`Sides::Upper`].
    pub fn lower(&self) -> f64 {
        self.lower
    }

    /// Lets neither value stand above `ceiling`.
    pub(crate) fn cap(&mut self, ceiling: f64) {
        self.upper = self.upper.min(ceiling);
        self.lower = self.lower.min(ceiling);
    }

    /// `ln(1 + R)` after a residual that deviates by `r` to the side of the step, from `before`.
    fn advance(&self, before: f64, r: f64) -> f64 {
        let ratio = self.shift * (r - 0.5 * self.shift);
        log_sum_exp(0.0, (before + ratio).clamp(-f64::MAX, f64::MAX))
    }
}

impl Statistic for ShiryaevRoberts {
    fn take(&mut self, r: f64) {
        if self.sides != Sides::Lower {
            self.upper = self.advance(self.upper, r);
        }
        if self.sides != Sides::Upper {
            self.lower = self.advance(self.lower, -r);
        }
    }

    fn reset(&mut self) {
        self.upper = 0.0;
        self.lower = 0.0;
    }

    fn value(&self) -> f64 {
        match self.sides {
            Sides::Upper => self.upper,
            Sides::Lower => self.lower,
            // 1 + (R+ + R-) / 2 = ((1 + R+) + (1 + R-)) / 2, never below 0 for rounding.
            Sides::Both => (log_sum_exp(self.upper, self.lower) - core::f64::consts::LN_2).max(0.0),
        }
    }

    fn threshold(&self) -> f64 {
        self.threshold
    }
}

/// `ln(e^a + e^b)` without overflow.
fn log_sum_exp(a: f64, b: f64) -> f64 {
    a.max(b) + libm::log1p(libm::exp(-(a - b).abs()))
}
