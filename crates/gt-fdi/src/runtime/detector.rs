//! The online detector: a bank of generators and tests, fed sample by sample.

use alloc::string::String;
use alloc::vec;
use alloc::vec::Vec;

use serde::{Deserialize, Serialize};

use super::channel::{Channel, ChannelVerdict};
use super::clock::{Clock, StepError};
use super::detector_state::{DetectorState, ResumeError};
use super::fingerprint::Fingerprint;
use super::{Generator, Update};

/// What the detector says of one sample.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Verdict {
    /// Time of the sample in seconds.
    pub time_s: f64,
    /// Whether samples are missing before this one, so that everything started afresh.
    pub gap: bool,
    /// Residuals in the order of [`Detector::outputs`], in their units; NaN where an input or the
    /// output is missing.
    pub residuals: Vec<f64>,
    /// One verdict a test, in the order of [`Detector::tests`].
    pub channels: Vec<ChannelVerdict>,
}

/// A generator with the place of its first output among all outputs.
#[derive(Debug, Clone)]
struct Source {
    generator: Generator,
    first: usize,
    last_update: Update,
}

/// A bank that takes samples as they come; made by `Detector::new(&bank)`.
///
/// Nothing is allocated by [`Detector::step`]. Broken samples are read the safe way:
///
/// - **Start.** Alarms are inhibited for the first `settle_samples` of each test: its residual is
///   reported with `settling`, and not judged.
/// - **Output not finite.** Its generator predicts without a correction (`x+ = A x + B u`): the
///   residual is NaN, the run above the limit ends and what reads the generator settles again,
///   while sums and windows keep what they have seen. A residual is coloured, so even one
///   correction left out leaves an error in the state that the limit was not set for, often many
///   times the limit. Where the model grows too fast to be predicted (`MAX_PREDICTED_RADIUS`), it is
///   as an input that is not finite.
/// - **Input not finite.** The generators that read it go back to their initial state, and all that
///   reads them starts afresh: a held or invented input would show as a fault of the output.
/// - **A gap in time** (more than 1.5 sample times): everything starts afresh and settles.
/// - **Absurd output.** A finite output more than 1e150 away from its operating point is judged,
///   and kept out of the state; any other overflow restarts the generator.
#[derive(Debug, Clone)]
pub struct Detector {
    inputs: Vec<String>,
    outputs: Vec<String>,
    tests: Vec<String>,
    clock: Clock,
    sources: Vec<Source>,
    channels: Vec<Channel>,
    verdict: Verdict,
}

/// What a [`Detector`] is made of.
pub(crate) struct Parts {
    pub(crate) inputs: Vec<String>,
    /// Tags of the outputs of all generators, one after the other.
    pub(crate) outputs: Vec<String>,
    /// Names of the channels.
    pub(crate) tests: Vec<String>,
    pub(crate) sample_time_s: f64,
    pub(crate) generators: Vec<Generator>,
    pub(crate) channels: Vec<Channel>,
}

impl Detector {
    /// A detector from its parts: as many outputs as the generators have, as many names as
    /// channels.
    pub(crate) fn from_parts(parts: Parts) -> Self {
        let mut first = 0;
        let sources = parts.generators.into_iter().map(|generator| {
            let start = first;
            first += generator.ny();
            Source {
                generator,
                first: start,
                last_update: Update::Restarted,
            }
        });
        let sources = sources.collect();
        let verdict = Verdict {
            time_s: f64::NAN,
            gap: false,
            residuals: vec![f64::NAN; first],
            channels: vec![ChannelVerdict::NONE; parts.channels.len()],
        };
        Self {
            inputs: parts.inputs,
            outputs: parts.outputs,
            tests: parts.tests,
            clock: Clock::new(parts.sample_time_s),
            sources,
            channels: parts.channels,
            verdict,
        }
    }

    /// Tags of the inputs, in the order that [`Detector::step`] expects.
    pub fn inputs(&self) -> &[String] {
        &self.inputs
    }

    /// Tags of the outputs, in the order that [`Detector::step`] expects.
    pub fn outputs(&self) -> &[String] {
        &self.outputs
    }

    /// Names of the tests, in the order of [`Verdict::channels`]: that of the output where a test
    /// watches one.
    pub fn tests(&self) -> &[String] {
        &self.tests
    }

    /// Sample time in seconds.
    pub fn sample_time_s(&self) -> f64 {
        self.clock.sample_time_s()
    }

    /// Takes the sample of time `t_s` (seconds): the inputs `u` and the outputs `y`, in the order
    /// of [`Detector::inputs`] and [`Detector::outputs`]. NaN means *no valid sample*.
    ///
    /// # Errors
    /// [`StepError`] when a size is wrong or the time does not advance; the detector is then as it
    /// was before the call.
    pub fn step(&mut self, t_s: f64, u: &[f64], y: &[f64]) -> Result<&Verdict, StepError> {
        StepError::check_sizes((self.inputs.len(), u.len()), (self.outputs.len(), y.len()))?;
        let gap = self.clock.advance(t_s)?;
        if gap {
            self.start_afresh();
        }
        self.verdict.time_s = t_s;
        self.verdict.gap = gap;
        for source in &mut self.sources {
            source.step(u, y, &mut self.verdict.residuals);
        }
        let verdicts = self.verdict.channels.iter_mut();
        for (channel, verdict) in self.channels.iter_mut().zip(verdicts) {
            let sources = channel.sources().iter();
            let updates = sources.filter_map(|&source| self.sources.get(source));
            let update = updates.fold(Update::Residual, |worst, source| {
                worst.max(source.last_update)
            });
            *verdict = channel.step(t_s, update, &self.verdict.residuals);
        }
        Ok(&self.verdict)
    }

    /// Forgets all samples: the next one may have any time, and everything settles again.
    pub fn reset(&mut self) {
        self.clock.reset();
        self.verdict.time_s = f64::NAN;
        self.verdict.gap = false;
        self.verdict.residuals.fill(f64::NAN);
        self.verdict.channels.fill(ChannelVerdict::NONE);
        self.start_afresh();
    }

    fn start_afresh(&mut self) {
        for source in &mut self.sources {
            source.generator.reset();
        }
        for channel in &mut self.channels {
            channel.start_afresh();
        }
    }

    /// All that the detector remembers, for [`Detector::resume`].
    pub fn state(&self) -> DetectorState {
        let generators = self.sources.iter();
        DetectorState {
            fingerprint: self.fingerprint(),
            last_time_s: self.clock.last_time_s(),
            generators: generators
                .map(|source| source.generator.state().to_vec())
                .collect(),
            channels: self.channels.iter().map(Channel::state).collect(),
        }
    }

    /// Of all that makes the bank: tags, tests, models, whitening and limits.
    fn fingerprint(&self) -> u64 {
        let mut print = Fingerprint::new();
        let tags = self.inputs.iter().chain(&self.outputs).chain(&self.tests);
        for tag in tags {
            print.add_text(tag);
        }
        print.add(self.clock.sample_time_s().to_bits());
        for source in &self.sources {
            source.generator.mark(&mut print);
        }
        for channel in &self.channels {
            channel.mark(&mut print);
        }
        print.value()
    }

    /// Goes on from the state of a detector of the same bank: from then on the verdicts are those
    /// that it would have given, bit for bit.
    ///
    /// # Errors
    /// [`ResumeError`] when the state is not one of this bank; the detector is then as it was.
    pub fn resume(&mut self, state: &DetectorState) -> Result<(), ResumeError> {
        if state.fingerprint != self.fingerprint() {
            return Err(ResumeError::Bank);
        }
        ResumeError::check("generators", self.sources.len(), state.generators.len())?;
        ResumeError::check("tests", self.channels.len(), state.channels.len())?;
        if state.last_time_s.is_some_and(|time_s| !time_s.is_finite()) {
            return Err(ResumeError::Time);
        }
        let mut resumed = self.clone();
        let states = resumed.sources.iter_mut().zip(&state.generators);
        for (index, (source, state)) in states.enumerate() {
            if !source.generator.set_state(state) {
                return Err(ResumeError::Generator { index });
            }
        }
        let states = resumed.channels.iter_mut().zip(&state.channels);
        for (index, (channel, state)) in states.enumerate() {
            if !channel.set_state(state) {
                return Err(ResumeError::Test { index });
            }
        }
        resumed.clock.set_last_time_s(state.last_time_s);
        *self = resumed;
        Ok(())
    }
}

impl Source {
    fn step(&mut self, u: &[f64], y: &[f64], residuals: &mut [f64]) {
        let own = self.first..self.first + self.generator.ny();
        // There is a place for every output's residual.
        if let Some(residuals) = residuals.get_mut(own) {
            self.last_update = self.generator.step(u, y, self.first, residuals);
        }
    }
}
