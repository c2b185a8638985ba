//! Which deviations count.

use serde::{Deserialize, Serialize};

/// The sides of zero on which a residual's deviation is looked for.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Sides {
    /// Residuals that rise.
    Upper,
    /// Residuals that fall.
    Lower,
    /// Either.
    Both,
}

impl Sides {
    /// How far `value` lies on a side that counts: negative on the other.
    pub(crate) fn fold(self, value: f64) -> f64 {
        match self {
            Self::Upper => value,
            Self::Lower => -value,
            Self::Both => value.abs(),
        }
    }
}
