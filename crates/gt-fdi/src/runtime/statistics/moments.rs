//! Mean and spread of a set of samples, which grows by a sample or by another set.

use serde::{Deserialize, Serialize};

/// The number of samples, their mean and the sum of their squared deviations from it.
///
/// Nothing large is subtracted from anything large, so that the spread keeps its digits however far
/// the mean is from zero, and is never negative.
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct Moments {
    pub(super) count: u64,
    pub(super) mean: f64,
    /// `sum (r - mean)^2`.
    pub(super) squares: f64,
}

impl Moments {
    /// With one sample more (Welford, *Technometrics* 4, 1962).
    pub(super) fn with(self, r: f64) -> Self {
        let count = self.count.saturating_add(1);
        let before = r - self.mean;
        let mean = self.mean + before / count as f64;
        Self {
            count,
            mean,
            // Of one sign, or one of them is zero.
            squares: self.squares + before * (r - mean),
        }
    }

    /// Of both sets together (Chan and others, *The American Statistician* 37, 1983).
    pub(super) fn join(self, other: Self) -> Self {
        let count = self.count.saturating_add(other.count);
        if other.count == 0 {
            return self;
        }
        let share = other.count as f64 / count as f64;
        let apart = other.mean - self.mean;
        let between = apart * apart * share * self.count as f64;
        Self {
            count,
            mean: self.mean + apart * share,
            squares: self.squares + other.squares + between,
        }
    }
}
