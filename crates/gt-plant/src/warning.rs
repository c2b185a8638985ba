//! What a run did that a reader of its record should know.

use std::fmt;

use serde::Serialize;

use crate::components::governor::FuelLimit;

/// A remark on a run that is no error.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[serde(tag = "kind", rename_all = "snake_case")]
pub enum Warning {
    /// The governor's demand was at its lower limit.
    FuelAtMinimum {
        /// Time of the first such sample, s.
        first_s: f64,
        /// Number of such samples.
        samples: usize,
    },
    /// The governor's demand was at its upper limit.
    FuelAtMaximum {
        /// Time of the first such sample, s.
        first_s: f64,
        /// Number of such samples.
        samples: usize,
    },
    /// Noise was asked for, but nothing moves, and noise is a share of what moves.
    NoNoise,
}

impl fmt::Display for Warning {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::FuelAtMinimum { first_s, samples } => write!(
                formatter,
                "the fuel demand was at its lower limit in {samples} samples, first at {first_s:.2} s"
            ),
            Self::FuelAtMaximum { first_s, samples } => write!(
                formatter,
                "the fuel demand was at its upper limit in {samples} samples, first at {first_s:.2} s"
            ),
            Self::NoNoise => formatter.write_str(
                "no noise: it is proportional to the signals' deviations, and nothing is excited",
            ),
        }
    }
}

/// Counts the samples at each limit.
#[derive(Debug, Clone, Default)]
pub(crate) struct LimitCounter {
    minimum: Option<(f64, usize)>,
    maximum: Option<(f64, usize)>,
}

impl LimitCounter {
    pub(crate) fn see(&mut self, limit: Option<FuelLimit>, time_s: f64) {
        let entry = match limit {
            None => return,
            Some(FuelLimit::Minimum) => &mut self.minimum,
            Some(FuelLimit::Maximum) => &mut self.maximum,
        };
        entry.get_or_insert((time_s, 0)).1 += 1;
    }

    pub(crate) fn warnings(&self) -> Vec<Warning> {
        let minimum = self
            .minimum
            .map(|(first_s, samples)| Warning::FuelAtMinimum { first_s, samples });
        let maximum = self
            .maximum
            .map(|(first_s, samples)| Warning::FuelAtMaximum { first_s, samples });
        minimum.into_iter().chain(maximum).collect()
    }
}
