//! What a detector remembers between two samples.

use alloc::vec::Vec;

use serde::{Deserialize, Serialize};
use thiserror::Error;

use super::channel::ChannelState;

/// All that a [`Detector`](super::Detector) remembers: a value that passes through serde without
/// losing a bit, for a service that restarts. Thresholds, models and tags are those of the bank.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct DetectorState {
    /// Of the bank.
    pub(crate) fingerprint: u64,
    pub(crate) last_time_s: Option<f64>,
    pub(crate) generators: Vec<Vec<f64>>,
    pub(crate) channels: Vec<ChannelState>,
}

impl DetectorState {
    /// Time of the last sample in seconds; `None` before the first.
    pub fn last_time_s(&self) -> Option<f64> {
        self.last_time_s
    }
}

/// Why a detector cannot go on from a state.
#[derive(Debug, Clone, Copy, PartialEq, Error)]
pub enum ResumeError {
    /// The state is that of another bank: other tags, models, whitening or limits.
    #[error("state of the detector: expected that of this bank, found that of another")]
    Bank,
    /// The state is that of a bank with another number of parts.
    #[error("state of the detector, {what}: expected {expected}, found {found}")]
    Count {
        /// What is counted: generators or tests.
        what: &'static str,
        /// Those of this bank.
        expected: usize,
        /// Those of the state.
        found: usize,
    },
    /// A number is NaN or infinite.
    #[error("state of the detector, number {index}: expected a finite number, found {found}")]
    NotFinite {
        /// 0-based position.
        index: usize,
        /// The number found.
        found: f64,
    },
    /// The time of the last sample is NaN or infinite.
    #[error("state of the detector, last time: expected a finite number of seconds")]
    Time,
    /// A generator's state has another size than the model's, or is not finite.
    #[error(
        "state of the detector, generator {index}: expected a finite state of its model's size"
    )]
    Generator {
        /// 0-based position of the generator.
        index: usize,
    },
    /// The memory of a test is not of this test: another statistic, limit or whitening.
    #[error("state of the detector, test {index}: expected the memory of the bank's own statistic")]
    Test {
        /// 0-based position of the test.
        index: usize,
    },
}

impl ResumeError {
    pub(crate) fn check(what: &'static str, expected: usize, found: usize) -> Result<(), Self> {
        if expected == found {
            return Ok(());
        }
        Err(Self::Count {
            what,
            expected,
            found,
        })
    }
}
