//! The cumulative sum.

use serde::{Deserialize, Serialize};

use super::statistic::Statistic;
use super::{Sides, StatisticError, check_state, check_threshold};

/// The sum of what exceeds an allowance, on the sides that count:
/// `S+ = max(0, S+ + r - k)`, `S- = max(0, S- - r - k)` (Page, *Biometrika* 41, 1954). Its value is
/// the larger of the two, in standard deviations.
///
/// For a step of known size `d` in white normal residuals, `k = d / 2` finds it faster than any
/// other detector with the same mean time between false alarms (Moustakides, *Annals of Statistics*
/// 14, 1986). [`CusumRunLength`](crate::design::CusumRunLength) sets the threshold.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(try_from = "Unchecked")]
pub struct Cusum {
    allowance: f64,
    threshold: f64,
    sides: Sides,
    upper: Sum,
    lower: Sum,
}

/// One side's sum.
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct Sum {
    value: f64,
    /// Samples since the sum was last zero, the newest included.
    age: u64,
    /// What they exceeded the allowance by in all, which no ceiling lowers.
    total: f64,
}

/// The fields of a [`Cusum`] as they come from a file.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Unchecked {
    allowance: f64,
    threshold: f64,
    sides: Sides,
    upper: Sum,
    lower: Sum,
}

impl TryFrom<Unchecked> for Cusum {
    type Error = StatisticError;

    fn try_from(raw: Unchecked) -> Result<Self, StatisticError> {
        let made = Self::new(raw.allowance, raw.threshold, raw.sides)?;
        for (sum, idle) in [
            (raw.upper, raw.sides == Sides::Lower),
            (raw.lower, raw.sides == Sides::Upper),
        ] {
            check_state("sum", sum.value, 0.0, if idle { 0.0 } else { f64::MAX })?;
            let (youngest, oldest) = if sum.value > 0.0 {
                (1.0, u64::MAX as f64)
            } else {
                (0.0, 0.0)
            };
            check_state("age", sum.age as f64, youngest, oldest)?;
            check_state("total", sum.total, sum.value, f64::MAX)?;
        }
        Ok(Self {
            upper: raw.upper,
            lower: raw.lower,
            ..made
        })
    }
}

impl Cusum {
    /// A CUSUM at zero with the `allowance` `k` (0 or above) and the `threshold` (above 0), both in
    /// standard deviations.
    ///
    /// # Errors
    /// [`StatisticError::Allowance`] or [`StatisticError::Threshold`].
    pub fn new(allowance: f64, threshold: f64, sides: Sides) -> Result<Self, StatisticError> {
        if !(allowance.is_finite() && allowance >= 0.0) {
            return Err(StatisticError::Allowance { found: allowance });
        }
        check_threshold(threshold)?;
        Ok(Self {
            allowance,
            threshold,
            sides,
            upper: Sum::default(),
            lower: Sum::default(),
        })
    }

    /// The allowance in standard deviations.
    pub fn allowance(&self) -> f64 {
        self.allowance
    }

    /// The sides that count.
    pub fn sides(&self) -> Sides {
        self.sides
    }

    /// The sum of what rises; 0 with [`Sides::Lower`].
    pub fn upper(&self) -> f64 {
        self.upper.value
    }

    /// The sum of what falls; 0 with [`Sides::Upper`].
    pub fn lower(&self) -> f64 {
        self.lower.value
    }

    /// The estimate of the fault's onset: samples since the larger sum was last zero, the newest
    /// included (the maximum-likelihood estimate for a step of twice the allowance); 0 while both
    /// are zero.
    pub fn onset_age(&self) -> u64 {
        if self.upper.value >= self.lower.value {
            self.upper.age
        } else {
            self.lower.age
        }
    }
}

impl Cusum {
    /// The likeliest step: the samples since its onset, as [`Cusum::onset_age`], and its size with
    /// its sign in standard deviations, the allowance and the mean of what exceeded it; `None`
    /// while both sums are zero.
    pub fn change(&self) -> Option<(u64, f64)> {
        let (sum, sign) = if self.upper.value >= self.lower.value {
            (self.upper, 1.0)
        } else {
            (self.lower, -1.0)
        };
        (sum.age > 0).then(|| {
            (
                sum.age,
                sign * (self.allowance + sum.total / sum.age as f64),
            )
        })
    }

    /// Lets neither sum stand above `ceiling`.
    pub(crate) fn cap(&mut self, ceiling: f64) {
        self.upper.value = self.upper.value.min(ceiling);
        self.lower.value = self.lower.value.min(ceiling);
    }
}

impl Sum {
    fn add(&mut self, excess: f64) {
        // The upper end is never reached by samples in range within any life time; it keeps the
        // state finite.
        let value = (self.value + excess).min(f64::MAX);
        let total = (self.total + excess).min(f64::MAX).max(value);
        // All ones where the value is above 0, else all zeros, from the sign of its negative: in
        // healthy running nobody could guess a branch, and of a comparison the compiler makes one.
        let kept = ((0.0 - value).to_bits().cast_signed() >> 63).cast_unsigned();
        *self = Self {
            value: value.max(0.0),
            age: self.age.saturating_add(1) & kept,
            total: f64::from_bits(total.to_bits() & kept),
        };
    }
}

impl Statistic for Cusum {
    fn take(&mut self, r: f64) {
        if self.sides != Sides::Lower {
            self.upper.add(r - self.allowance);
        }
        if self.sides != Sides::Upper {
            self.lower.add(-r - self.allowance);
        }
    }

    fn reset(&mut self) {
        self.upper = Sum::default();
        self.lower = Sum::default();
    }

    fn value(&self) -> f64 {
        self.upper.value.max(self.lower.value)
    }

    fn threshold(&self) -> f64 {
        self.threshold
    }
}
