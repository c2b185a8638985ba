//! From values above a limit to alarms: how long a run makes one, how long a silence ends it.

use serde::{Deserialize, Serialize};

/// How many samples an alarm waits for, and how many it outlives its cause.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Persistence {
    /// Samples above the limit in a row that make an alarm, at least 1.
    pub consecutive: usize,
    /// Samples within the limit in a row that end it, at least 1. A statistic with memory hovers
    /// round its limit: as long as it remembers, it is the same event.
    pub release: usize,
}

impl Persistence {
    /// The paper's eq. 26: an alarm with the first sample above the limit and until the first one
    /// that is not.
    pub const NONE: Self = Self {
        consecutive: 1,
        release: 1,
    };

    /// An alarm after so many samples in a row, and until the first sample within the limit.
    pub fn consecutive(consecutive: usize) -> Self {
        Self {
            consecutive,
            ..Self::NONE
        }
    }
}

/// The run of consecutive samples with a value above the limit that the newest sample belongs to,
/// and the alarm that it raises: the geometric test of the paper's eq. 26, with memory.
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ExceedanceRun {
    length: usize,
    first_s: f64,
    alarm: bool,
    /// Samples within the limit since the last one above it, while an alarm is up.
    within: usize,
}

impl ExceedanceRun {
    /// Takes the value at `time_s` into account; says whether it raised an alarm. A value that is
    /// NaN is within the limit.
    pub fn update(&mut self, time_s: f64, value: f64, limit: f64, wait: Persistence) -> bool {
        if value > limit {
            if self.length == 0 {
                self.first_s = time_s;
            }
            self.length = self.length.saturating_add(1);
            self.within = 0;
            let raised = !self.alarm && self.length >= wait.consecutive;
            self.alarm |= raised;
            return raised;
        }
        self.length = 0;
        if self.alarm {
            self.within = self.within.saturating_add(1);
            self.alarm = self.within < wait.release;
        }
        false
    }

    /// Ends the run and the alarm.
    pub fn clear(&mut self) {
        *self = Self::default();
    }

    /// Whether its time is a number.
    pub(crate) fn is_finite(&self) -> bool {
        self.first_s.is_finite()
    }

    /// Samples in the run.
    pub fn length(&self) -> usize {
        self.length
    }

    /// Whether an alarm is up.
    pub fn alarm(&self) -> bool {
        self.alarm
    }

    /// Time of the run's first sample in seconds; `None` outside a run.
    pub fn first_exceedance_s(&self) -> Option<f64> {
        (self.length > 0).then_some(self.first_s)
    }
}
