//! Average run length of a limit, and of samples in a row beyond it.

use super::normal::tail;
use super::root::increasing_root;
use super::{check, check_finite, check_run_length};
use crate::FdiError;
use crate::runtime::Sides;

/// The longest row of samples beyond the limit.
pub const MAX_CONSECUTIVE: usize = 1_000_000;
/// A normal variable beyond this many standard deviations has a probability of 1e-300.
const FARTHEST_LIMIT: f64 = 37.0;

/// The average run length of an alarm at the `consecutive`-th sample in a row beyond a limit, on
/// residuals that are independent and normal with standard deviation 1; `consecutive = 1` is the
/// plain threshold.
///
/// With the probability `p` of a sample beyond the limit, the mean waiting time for `n` in a row is
/// `(p^-n - 1) / (1 - p)` (Feller, *An Introduction to Probability Theory and Its Applications*
/// 1, XIII.7, eq. 7.7). With [`Sides::Both`] samples beyond either limit count, in any order.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ExceedanceRunLength {
    limit: f64,
    consecutive: usize,
    sides: Sides,
}

impl ExceedanceRunLength {
    /// For the `limit` (0 or above, in standard deviations) and `consecutive` samples beyond it, 1
    /// to [`MAX_CONSECUTIVE`].
    ///
    /// # Errors
    /// [`FdiError::Option`] for a limit or a number of samples out of range.
    pub fn new(limit: f64, consecutive: usize, sides: Sides) -> Result<Self, FdiError> {
        let fits = limit.is_finite() && limit >= 0.0;
        check("limit", "a finite number not below 0", limit, fits)?;
        check(
            "consecutive",
            "1 to 1000000 samples",
            consecutive as f64,
            (1..=MAX_CONSECUTIVE).contains(&consecutive),
        )?;
        Ok(Self {
            limit,
            consecutive,
            sides,
        })
    }

    /// Average run length in samples when the residual's mean is `shift` standard deviations;
    /// infinite beyond the range of doubles.
    ///
    /// # Errors
    /// [`FdiError::Option`] for a shift that is not finite.
    pub fn samples(&self, shift: f64) -> Result<f64, FdiError> {
        check_finite("shift", shift)?;
        Ok(self.unchecked(shift))
    }

    /// The limit at which the average run length without a shift is `run_length` samples.
    ///
    /// # Errors
    /// [`FdiError::Option`] for a bad `consecutive`; [`FdiError::RunLength`] when `run_length` is
    /// below that of the limit 0 or above [`MAX_RUN_LENGTH`](super::MAX_RUN_LENGTH).
    pub fn limit_for(consecutive: usize, sides: Sides, run_length: f64) -> Result<f64, FdiError> {
        let lowest = Self::new(0.0, consecutive, sides)?;
        check_run_length(run_length, lowest.unchecked(0.0))?;
        increasing_root((0.0, FARTHEST_LIMIT), |limit| {
            let rule = Self { limit, ..lowest };
            Ok((rule.unchecked(0.0) / run_length).ln())
        })
    }

    fn unchecked(&self, shift: f64) -> f64 {
        let (above, below) = (tail(self.limit - shift), tail(self.limit + shift));
        let (beyond, within) = match self.sides {
            Sides::Upper => (above, tail(shift - self.limit)),
            Sides::Lower => (below, tail(-shift - self.limit)),
            Sides::Both => (above + below, within(self.limit, shift)),
        };
        let count = self.consecutive as f64;
        if within <= 0.0 {
            return count;
        }
        (-count * beyond.ln()).exp_m1() / within
    }
}

/// `P(|X + shift| <= limit)`, as a difference of the two tails on the farther side.
fn within(limit: f64, shift: f64) -> f64 {
    let shift = shift.abs();
    tail(shift - limit) - tail(shift + limit)
}
