//! The run sum of zone scores.

use serde::{Deserialize, Serialize};

use super::statistic::Statistic;
use super::{Sides, StatisticError, check_option, check_state, check_threshold};

/// The sum of the scores of residuals in a row on one side of zero, where a residual's score is that
/// of the zone in which it lies: `0..w`, `w..2w`, `2w..3w` and from `3w` on, with `w` the width of a
/// zone. A residual on the other side ends the run: its score begins that side's sum, and the first
/// side's is 0. A residual of exactly 0 lies on neither side and changes nothing.
///
/// Run sums are due to Roberts (*Technometrics* 8, 1966) and Reynolds (*Journal of Quality
/// Technology* 3, 1971); Champ and Rigdon (*Journal of Quality Technology* 29, 1997) treat them with
/// any scores. The zone control chart of Jaehn (1987) is the one with [`RunSum::ZONE_SCORES`],
/// zones one standard deviation wide and an alarm at a score of 8, that is above the threshold 7
/// (Davis, Homer and Woodall, *Communications in Statistics: Theory and Methods* 19, 1990).
///
/// Sums are whole numbers, and thresholds between two of them are alike; it is the width of the
/// zones that sets the mean time between false alarms.
/// [`RunSumRunLength`](crate::design::RunSumRunLength) finds it.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(try_from = "Unchecked")]
pub struct RunSum {
    width: f64,
    scores: [u32; 4],
    threshold: f64,
    sides: Sides,
    upper: u64,
    lower: u64,
}

/// The fields of a [`RunSum`] as they come from a file.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Unchecked {
    width: f64,
    scores: [u32; 4],
    threshold: f64,
    sides: Sides,
    upper: u64,
    lower: u64,
}

impl TryFrom<Unchecked> for RunSum {
    type Error = StatisticError;

    fn try_from(raw: Unchecked) -> Result<Self, StatisticError> {
        let made = Self::new(raw.width, raw.scores, raw.threshold, raw.sides)?;
        for (sum, other, idle) in [
            (raw.upper, raw.lower, raw.sides == Sides::Lower),
            (raw.lower, raw.upper, raw.sides == Sides::Upper),
        ] {
            let largest = if idle || other > 0 {
                0.0
            } else {
                u64::MAX as f64
            };
            check_state("sum", sum as f64, 0.0, largest)?;
        }
        Ok(Self {
            upper: raw.upper,
            lower: raw.lower,
            ..made
        })
    }
}

impl RunSum {
    /// The scores of the zone control chart.
    pub const ZONE_SCORES: [u32; 4] = [0, 2, 4, 8];

    /// A run sum at 0 with zones of the `width` (above 0, in standard deviations), the `scores` of
    /// the zones from zero outwards, which do not fall and end above 0, and the `threshold` (above
    /// 0) on the sum.
    ///
    /// # Errors
    /// [`StatisticError::Option`] for the width or the scores, [`StatisticError::Threshold`].
    pub fn new(
        width: f64,
        scores: [u32; 4],
        threshold: f64,
        sides: Sides,
    ) -> Result<Self, StatisticError> {
        let fits = width > 0.0 && width.is_finite();
        check_option("width", "a positive finite number", width, fits)?;
        for (inner, outer) in scores.iter().zip(scores.iter().skip(1)) {
            let expected = "a score not below that of the zone inside";
            check_option("scores", expected, f64::from(*outer), inner <= outer)?;
        }
        let [.., last] = scores;
        let expected = "a score above 0 in the outermost zone";
        check_option("scores", expected, f64::from(last), last > 0)?;
        check_threshold(threshold)?;
        Ok(Self {
            width,
            scores,
            threshold,
            sides,
            upper: 0,
            lower: 0,
        })
    }

    /// The sum of the run above zero; 0 with [`Sides::Lower`].
    pub fn upper(&self) -> u64 {
        self.upper
    }

    /// The sum of the run below zero; 0 with [`Sides::Upper`].
    pub fn lower(&self) -> u64 {
        self.lower
    }

    /// The score of a residual `|r|` away from zero.
    fn score(&self, r: f64) -> u64 {
        let [first, others @ ..] = self.scores;
        let mut score = first;
        for (zone, outer) in (1_u32..).zip(others) {
            if r.abs() >= f64::from(zone) * self.width {
                score = outer;
            }
        }
        u64::from(score)
    }
}

impl Statistic for RunSum {
    fn take(&mut self, r: f64) {
        let score = self.score(r);
        if r > 0.0 {
            self.lower = 0;
            if self.sides != Sides::Lower {
                self.upper = self.upper.saturating_add(score);
            }
        } else if r < 0.0 {
            self.upper = 0;
            if self.sides != Sides::Upper {
                self.lower = self.lower.saturating_add(score);
            }
        }
    }

    fn reset(&mut self) {
        self.upper = 0;
        self.lower = 0;
    }

    fn value(&self) -> f64 {
        self.upper.max(self.lower) as f64
    }

    fn threshold(&self) -> f64 {
        self.threshold
    }
}
