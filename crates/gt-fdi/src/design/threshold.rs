//! Fixed thresholds and the rules that set them.

use serde::{Deserialize, Serialize};

use crate::FdiError;

/// How a fixed threshold is set from healthy residuals. An alarm needs `consecutive` samples above
/// the limit in a row.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(tag = "kind", rename_all = "snake_case", deny_unknown_fields)]
pub enum ThresholdRule {
    /// The smallest limit that at most `share` of the healthy samples exceed.
    Exceedance {
        /// Share of the samples, in (0, 1).
        share: f64,
        /// Samples above the limit in a row that make an alarm, at least 1.
        consecutive: usize,
    },
    /// `factor` times the largest healthy `|r|`.
    Margin {
        /// The factor, above 0.
        factor: f64,
        /// Samples above the limit in a row that make an alarm, at least 1.
        consecutive: usize,
    },
    /// The smallest limit such that it and every higher one leave at least `hours` of clear running
    /// for each alarm event on the healthy records.
    ///
    /// Clear running is the time without an alarm. It is counted, not the whole time, because the
    /// number of events alone does not rise as the limit falls: a limit of 0 gives one event, which
    /// never ends.
    MeanTimeBetweenFalseAlarms {
        /// Mean time between false alarms in hours, above 0.
        hours: f64,
        /// Samples above the limit in a row that make an alarm, at least 1.
        consecutive: usize,
    },
}

impl ThresholdRule {
    /// The margin above the largest healthy residual where nobody asks for a rule: residuals of
    /// identified models are coloured, so a limit by the share of samples above it would alarm
    /// many times an hour.
    pub const DEFAULT_MARGIN: f64 = 1.2;

    /// Samples above the limit in a row that make an alarm.
    pub fn consecutive(&self) -> usize {
        match *self {
            Self::Exceedance { consecutive, .. }
            | Self::Margin { consecutive, .. }
            | Self::MeanTimeBetweenFalseAlarms { consecutive, .. } => consecutive,
        }
    }

    /// Refuses parameters that are out of range.
    ///
    /// # Errors
    /// [`FdiError::Option`] with the option, its range and the value found.
    pub fn validate(&self) -> Result<(), FdiError> {
        let (option, found, fits, expected) = match *self {
            Self::Exceedance { share, .. } => (
                "share",
                share,
                share > 0.0 && share < 1.0,
                "a share above 0 and below 1",
            ),
            Self::Margin { factor, .. } => (
                "factor",
                factor,
                factor > 0.0 && factor.is_finite(),
                "a finite factor above 0",
            ),
            Self::MeanTimeBetweenFalseAlarms { hours, .. } => (
                "hours",
                hours,
                hours > 0.0 && hours.is_finite(),
                "a finite number above 0",
            ),
        };
        if !fits {
            return Err(FdiError::Option {
                option,
                expected,
                found,
            });
        }
        check_consecutive(self.consecutive())
    }
}

/// An alarm rises when `|r| > limit` for `consecutive` samples in a row (the paper's eq. 26 with
/// `consecutive = 1`); the first of them is the estimate of the onset.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct FixedThreshold {
    /// The limit on `|r|`, in the output's unit.
    pub limit: f64,
    /// Samples above the limit in a row that make an alarm.
    pub consecutive: usize,
    /// The rule that set the limit.
    pub rule: ThresholdRule,
}

impl FixedThreshold {
    /// Refuses a limit that is negative or not finite, no consecutive samples, and a bad rule.
    ///
    /// # Errors
    /// [`FdiError::Limit`] or [`FdiError::Option`].
    pub fn validate(&self) -> Result<(), FdiError> {
        if !(self.limit.is_finite() && self.limit >= 0.0) {
            return Err(FdiError::Limit { found: self.limit });
        }
        check_consecutive(self.consecutive)?;
        self.rule.validate()
    }
}

fn check_consecutive(consecutive: usize) -> Result<(), FdiError> {
    if consecutive > 0 {
        return Ok(());
    }
    let expected = "at least 1 sample";
    Err(FdiError::Option {
        option: "consecutive",
        expected,
        found: 0.0,
    })
}
