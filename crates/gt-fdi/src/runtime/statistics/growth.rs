//! How far a window grows.

use serde::{Deserialize, Serialize};

use super::StatisticError;

/// Above the sum of the squares of as many of the largest samples as can be counted.
pub(super) const LARGEST_SUM: f64 = 1e220;

/// A window that grows with each sample, is looked at from `shortest` samples on, and begins anew
/// after `longest`.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Growth {
    /// Samples from which on the window is looked at.
    pub shortest: u64,
    /// Samples after which the next one begins a new window; `u64::MAX` for a window that begins
    /// anew when it is told to only.
    pub longest: u64,
}

impl Growth {
    /// Refuses a shortest window below `least` samples and a longest one below the shortest.
    pub(super) fn check(self, least: u64) -> Result<(), StatisticError> {
        let Self { shortest, longest } = self;
        if least <= shortest && shortest <= longest {
            return Ok(());
        }
        Err(StatisticError::Growth {
            least,
            shortest,
            longest,
        })
    }
}
