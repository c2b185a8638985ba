//! The sequential probability ratio test.

use serde::{Deserialize, Serialize};

use super::statistic::Statistic;
use super::{StatisticError, check_state};

/// Wald's test of a mean of 0 against a mean of `shift`: the logarithm of the likelihood ratio
/// `L + shift r - shift^2 / 2`, which starts at 0, until it reaches a bound (*Annals of Mathematical
/// Statistics* 16, 1945).
///
/// For the probability `a` of a false alarm and `b` of a miss, Wald's bounds are `ln(b / (1 - a))`
/// and `ln((1 - b) / a)`. A test that has decided takes no more samples until it is reset: it
/// answers one question. For a fault that may begin at any time, take a [`Cusum`](super::Cusum).
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(try_from = "Unchecked")]
pub struct Sprt {
    shift: f64,
    accept: f64,
    reject: f64,
    value: f64,
}

/// What the test has decided.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum SprtDecision {
    /// Nothing yet.
    Undecided,
    /// The mean is 0.
    Healthy,
    /// The mean is the shift.
    Faulty,
}

/// The fields of a [`Sprt`] as they come from a file.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Unchecked {
    shift: f64,
    accept: f64,
    reject: f64,
    value: f64,
}

impl TryFrom<Unchecked> for Sprt {
    type Error = StatisticError;

    fn try_from(raw: Unchecked) -> Result<Self, StatisticError> {
        let made = Self::new(raw.shift, raw.accept, raw.reject)?;
        check_state("value", raw.value, -f64::MAX, f64::MAX)?;
        Ok(Self {
            value: raw.value,
            ..made
        })
    }
}

impl Sprt {
    /// A test for a mean of `shift` standard deviations (of either sign) that decides for healthy
    /// at or below `accept` (below 0) and for faulty above `reject` (above 0), both on the
    /// logarithm of the likelihood ratio.
    ///
    /// # Errors
    /// [`StatisticError::Shift`] or [`StatisticError::Bounds`].
    pub fn new(shift: f64, accept: f64, reject: f64) -> Result<Self, StatisticError> {
        if !shift.is_finite() || shift == 0.0 {
            return Err(StatisticError::Shift { found: shift });
        }
        if !(accept < 0.0 && accept.is_finite() && reject > 0.0 && reject.is_finite()) {
            return Err(StatisticError::Bounds { accept, reject });
        }
        Ok(Self {
            shift,
            accept,
            reject,
            value: 0.0,
        })
    }

    /// What the samples so far have decided.
    pub fn decision(&self) -> SprtDecision {
        if self.value > self.reject {
            SprtDecision::Faulty
        } else if self.value <= self.accept {
            SprtDecision::Healthy
        } else {
            SprtDecision::Undecided
        }
    }
}

impl Statistic for Sprt {
    fn take(&mut self, r: f64) {
        if self.decision() == SprtDecision::Undecided {
            let value = self.value + self.shift * (r - 0.5 * self.shift);
            self.value = value.clamp(-f64::MAX, f64::MAX);
        }
    }

    fn reset(&mut self) {
        self.value = 0.0;
    }

    fn value(&self) -> f64 {
        self.value
    }

    fn threshold(&self) -> f64 {
        self.reject
    }
}
