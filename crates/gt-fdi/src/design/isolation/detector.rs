//! An isolator at work, sample by sample.

use serde::{Deserialize, Serialize};

use super::isolator::Isolator;
use crate::FdiError;
use crate::runtime::{Clock, Core, Diagnosis, IsolationVerdict, Recall, ResumeError, StepError};

/// An isolator that takes samples as they come.
///
/// - **Start.** Nothing is judged until the generators have settled.
/// - **A missing input or output** (not finite): there is no evidence until the generators that read
///   it have settled again; what was gathered before stays.
/// - **A gap in time**: everything starts afresh.
#[derive(Debug, Clone)]
pub struct IsolationDetector {
    core: Core,
    clock: Clock,
    sizes: (usize, usize),
    fingerprint: u64,
}

/// All that an [`IsolationDetector`] remembers: a value that passes through serde without losing a
/// bit, for a service that restarts. Generators, hypotheses and limits are those of the isolator.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct IsolationState {
    /// Of the isolator.
    fingerprint: u64,
    last_time_s: Option<f64>,
    numbers: Vec<f64>,
}

impl IsolationState {
    /// Time of the last sample in seconds; `None` before the first.
    pub fn last_time_s(&self) -> Option<f64> {
        self.last_time_s
    }
}

impl IsolationDetector {
    /// A detector in its initial state.
    ///
    /// # Errors
    /// None after construction of the isolator.
    pub fn new(isolator: &Isolator) -> Result<Self, FdiError> {
        Ok(Self {
            core: isolator.core()?,
            clock: Clock::new(isolator.sample_time_s()),
            sizes: (isolator.inputs().len(), isolator.outputs().len()),
            fingerprint: isolator.fingerprint(),
        })
    }

    /// Takes the sample of time `t_s` (seconds): the inputs `u` and outputs `y` in the order of
    /// [`Isolator::inputs`] and [`Isolator::outputs`]. NaN means *no valid sample*. Nothing is
    /// allocated.
    ///
    /// # Errors
    /// [`StepError`] when a size is wrong or the time does not advance; the detector is then as it
    /// was.
    pub fn step(&mut self, t_s: f64, u: &[f64], y: &[f64]) -> Result<&IsolationVerdict, StepError> {
        StepError::check_sizes((self.sizes.0, u.len()), (self.sizes.1, y.len()))?;
        if self.clock.advance(t_s)? {
            self.core.reset();
        }
        Ok(self.core.step(t_s, u, y))
    }

    /// The probabilities of all hypotheses by what has been seen, given that there is a fault; takes
    /// some milliseconds.
    pub fn diagnose(&mut self) -> Diagnosis {
        self.core.diagnose()
    }

    /// All that it remembers.
    pub fn state(&self) -> IsolationState {
        let mut numbers = Vec::new();
        self.core
            .clone()
            .recall(&mut |number| numbers.push(*number));
        IsolationState {
            fingerprint: self.fingerprint,
            last_time_s: self.clock.last_time_s(),
            numbers,
        }
    }

    /// Goes on from the state of a detector of the same isolator: from then on it says what that one
    /// would have said, bit for bit.
    ///
    /// # Errors
    /// [`ResumeError`] when the state is not one of this isolator; the detector is then as it was.
    pub fn resume(&mut self, state: &IsolationState) -> Result<(), ResumeError> {
        if state.fingerprint != self.fingerprint {
            return Err(ResumeError::Bank);
        }
        if state.last_time_s.is_some_and(|time_s| !time_s.is_finite()) {
            return Err(ResumeError::Time);
        }
        let mut expected = 0;
        self.core.clone().recall(&mut |_| expected += 1);
        ResumeError::check("numbers", expected, state.numbers.len())?;
        let mut finite = state.numbers.iter().enumerate();
        if let Some((index, &found)) = finite.find(|(_, number)| !number.is_finite()) {
            return Err(ResumeError::NotFinite { index, found });
        }
        let mut numbers = state.numbers.iter();
        self.core.recall(&mut |number| {
            if let Some(own) = numbers.next() {
                *number = *own;
            }
        });
        self.core.set_time_s(state.last_time_s.unwrap_or(f64::NAN));
        self.clock.set_last_time_s(state.last_time_s);
        Ok(())
    }

    /// What was said of the last sample.
    pub fn verdict(&self) -> &IsolationVerdict {
        self.core.verdict()
    }

    /// The residuals of the last sample, in the order of [`Isolator::outputs`] and in their units;
    /// NaN where an input or the output was missing.
    pub fn residuals(&self) -> &[f64] {
        self.core.residuals()
    }

    /// Forgets all samples.
    pub fn reset(&mut self) {
        self.clock.reset();
        self.core.reset();
    }
}
