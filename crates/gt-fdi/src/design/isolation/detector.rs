//! An isolator at work, sample by sample.

use super::isolator::Isolator;
use crate::FdiError;
use crate::runtime::{Clock, Core, Diagnosis, IsolationVerdict, StepError};

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

    /// What was said of the last sample.
    pub fn verdict(&self) -> &IsolationVerdict {
        self.core.verdict()
    }

    /// Forgets all samples.
    pub fn reset(&mut self) {
        self.clock.reset();
        self.core.reset();
    }
}
