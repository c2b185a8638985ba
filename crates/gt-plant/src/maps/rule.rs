//! What was expected of a number of a map.

use std::fmt;

/// What would have made sense.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum MapRule {
    /// Above zero or one and not absurdly large; also what a NaN breaks.
    Range {
        /// The lower limit, itself not allowed.
        low: f64,
        /// The upper limit, itself allowed.
        high: f64,
    },
    /// Above the value before it.
    Above {
        /// The value before it.
        limit: f64,
        /// Why.
        reason: &'static str,
    },
    /// Not below a value.
    AtLeast {
        /// The smallest value that is accepted.
        limit: f64,
        /// Why.
        reason: &'static str,
    },
    /// Below the value before it.
    Below {
        /// The value before it.
        limit: f64,
        /// Why.
        reason: &'static str,
    },
}

impl fmt::Display for MapRule {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Range { low, high } => write!(formatter, "above {low} and at most {high}"),
            Self::Above { limit, reason } => write!(formatter, "above {limit} ({reason})"),
            Self::AtLeast { limit, reason } => write!(formatter, "at least {limit} ({reason})"),
            Self::Below { limit, reason } => write!(formatter, "below {limit} ({reason})"),
        }
    }
}
