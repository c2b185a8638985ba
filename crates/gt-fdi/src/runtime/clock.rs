//! The times of samples, and samples that are refused.

use thiserror::Error;

/// A sample earlier than this share of the sample time after the one before is refused.
const EARLIEST_ADVANCE: f64 = 0.5;
/// A sample later than this multiple of the sample time after the one before follows a gap.
const LATEST_ADVANCE: f64 = 1.5;

/// A sample that the detector refuses; its state is as it was before.
#[derive(Debug, Clone, Copy, PartialEq, Error)]
pub enum StepError {
    /// Another number of inputs than the detector's.
    #[error("inputs of the sample: expected {expected}, found {found}")]
    InputCount {
        /// Inputs of the detector.
        expected: usize,
        /// Inputs in the sample.
        found: usize,
    },
    /// Another number of outputs than the detector's.
    #[error("outputs of the sample: expected {expected}, found {found}")]
    OutputCount {
        /// Outputs of the detector.
        expected: usize,
        /// Outputs in the sample.
        found: usize,
    },
    /// The time is NaN or infinite.
    #[error("time of the sample: expected a finite number of seconds, found {found_s}")]
    TimeNotFinite {
        /// The time found, in seconds.
        found_s: f64,
    },
    /// The time goes back, stands still or advances by less than half a sample time.
    #[error(
        "time of the sample: expected about {sample_time_s} s after {previous_s} s, \
         found {found_s} s"
    )]
    TimeNotAdvancing {
        /// Time of the sample before, in seconds.
        previous_s: f64,
        /// The time found, in seconds.
        found_s: f64,
        /// The detector's sample time, in seconds.
        sample_time_s: f64,
    },
}

impl StepError {
    /// Refuses other numbers of inputs or outputs; each expected, then found.
    pub(crate) fn check_sizes(inputs: (usize, usize), outputs: (usize, usize)) -> Result<(), Self> {
        let (expected, found) = inputs;
        if expected != found {
            return Err(Self::InputCount { expected, found });
        }
        let (expected, found) = outputs;
        if expected != found {
            return Err(Self::OutputCount { expected, found });
        }
        Ok(())
    }
}

/// The time of the last sample.
#[derive(Debug, Clone)]
pub(crate) struct Clock {
    sample_time_s: f64,
    last_time_s: Option<f64>,
}

impl Clock {
    pub(crate) fn new(sample_time_s: f64) -> Self {
        Self {
            sample_time_s,
            last_time_s: None,
        }
    }

    pub(crate) fn sample_time_s(&self) -> f64 {
        self.sample_time_s
    }

    pub(crate) fn last_time_s(&self) -> Option<f64> {
        self.last_time_s
    }

    pub(crate) fn set_last_time_s(&mut self, time_s: Option<f64>) {
        self.last_time_s = time_s;
    }

    pub(crate) fn reset(&mut self) {
        self.last_time_s = None;
    }

    /// Takes the time of a sample; says whether samples are missing before it.
    pub(crate) fn advance(&mut self, t_s: f64) -> Result<bool, StepError> {
        if !t_s.is_finite() {
            return Err(StepError::TimeNotFinite { found_s: t_s });
        }
        let gap = match self.last_time_s {
            None => false,
            Some(previous_s) => {
                let advance = (t_s - previous_s) / self.sample_time_s;
                if advance < EARLIEST_ADVANCE {
                    return Err(StepError::TimeNotAdvancing {
                        previous_s,
                        found_s: t_s,
                        sample_time_s: self.sample_time_s,
                    });
                }
                advance > LATEST_ADVANCE
            }
        };
        self.last_time_s = Some(t_s);
        Ok(gap)
    }
}
