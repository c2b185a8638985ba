//! How far a reading can be trusted.

use serde::{Deserialize, Serialize};

/// The quality of a reading, as in the topic `/plant/quality`.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Default, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Quality {
    /// As it should be.
    Good,
    /// The source has doubts; it is used.
    Uncertain,
    /// The last good value, held because the configuration asks for it.
    Interpolated,
    /// No usable value at this sample.
    #[default]
    Bad,
    /// No usable value for longer than the tag may be silent.
    Stale,
}

impl Quality {
    /// Whether the value is used.
    pub fn is_usable(self) -> bool {
        matches!(self, Self::Good | Self::Uncertain | Self::Interpolated)
    }
}

impl From<Quality> for gt_log::Quality {
    fn from(quality: Quality) -> Self {
        match quality {
            Quality::Good => Self::Good,
            Quality::Uncertain => Self::Uncertain,
            Quality::Interpolated => Self::Interpolated,
            Quality::Bad => Self::Bad,
            Quality::Stale => Self::Stale,
        }
    }
}
