//! One test of a detector: from residuals to a verdict.

use alloc::boxed::Box;
use alloc::vec::Vec;

use serde::{Deserialize, Serialize};

use super::fingerprint::Fingerprint;
use super::whitener::Whitener;
use super::{Evaluator, ExceedanceRun, Persistence, Statistic, Update};

/// Multiple of its limit beyond which an accumulated statistic does not grow.
const CEILING: f64 = 2.0;

/// What a test says of one sample.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[allow(clippy::struct_excessive_bools)] // four independent answers, read by name
pub struct ChannelVerdict {
    /// The residual: in the output's unit where the test watches one output as it is, in standard
    /// deviations where it is whitened, the norm of the whitened residuals where it watches
    /// several; NaN when one is missing.
    pub residual: f64,
    /// The statistic, in its own unit, which is compared with the limit; NaN while settling or
    /// without a residual.
    pub statistic: f64,
    /// Whether the statistic is above the limit; `false` while settling.
    pub exceeds: bool,
    /// Samples above the limit in a row, this one included.
    pub run_length: usize,
    /// Whether an alarm is up.
    pub alarm: bool,
    /// Whether the alarm came up with this sample.
    pub new_alarm: bool,
    /// Time of the first sample of the present run above the limit, in seconds. `None` outside a
    /// run.
    pub first_exceedance_s: Option<f64>,
    /// Samples since the likeliest onset, the newest included, where the statistic tells.
    pub onset_age: Option<u64>,
    /// The likeliest deviation of the residual's mean now, with its sign, in the output's unit,
    /// where the statistic tells.
    pub deviation: Option<f64>,
    /// Whether the generators have not yet forgotten their initial states, so that nothing is
    /// judged.
    pub settling: bool,
}

impl ChannelVerdict {
    pub(crate) const NONE: Self = Self {
        residual: f64::NAN,
        statistic: f64::NAN,
        exceeds: false,
        run_length: 0,
        alarm: false,
        new_alarm: false,
        first_exceedance_s: None,
        onset_age: None,
        deviation: None,
        settling: true,
    };
}

/// What a [`Channel`] is made of.
#[derive(Debug, Clone)]
pub(crate) struct ChannelParts {
    /// The generators that it reads.
    pub(crate) sources: Vec<usize>,
    /// Where its residuals stand among those of all outputs.
    pub(crate) places: Vec<usize>,
    /// `None`: one residual, as it is.
    pub(crate) whitener: Option<Whitener>,
    pub(crate) evaluator: Evaluator,
    /// Units of the output for a standard deviation of the whitened residual that lasts.
    pub(crate) unit: f64,
    pub(crate) limit: f64,
    pub(crate) persistence: Persistence,
    pub(crate) settle_samples: usize,
}

/// Whitening, statistic, limit and memory of one test.
#[derive(Debug, Clone)]
pub(crate) struct Channel {
    parts: ChannelParts,
    /// Corrected samples still to come before the residual is judged.
    settling_left: usize,
    run: ExceedanceRun,
}

/// What a [`Channel`] remembers.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct ChannelState {
    settling_left: usize,
    run: ExceedanceRun,
    /// The past of the whitened residuals.
    past: Box<[f64]>,
    evaluator: Evaluator,
}

impl Channel {
    pub(crate) fn new(parts: ChannelParts) -> Self {
        Self {
            settling_left: parts.settle_samples,
            run: ExceedanceRun::default(),
            parts,
        }
    }

    /// The generators that it reads.
    pub(crate) fn sources(&self) -> &[usize] {
        &self.parts.sources
    }

    /// Forgets all samples.
    pub(crate) fn start_afresh(&mut self) {
        self.parts.evaluator.reset();
        self.settle_again();
    }

    fn settle_again(&mut self) {
        self.settling_left = self.parts.settle_samples;
        self.run.clear();
        if let Some(whitener) = &mut self.parts.whitener {
            whitener.reset();
        }
    }

    /// Takes the residuals of all outputs; `update` is the worst of its generators.
    pub(crate) fn step(
        &mut self,
        time_s: f64,
        update: Update,
        residuals: &[f64],
    ) -> ChannelVerdict {
        match update {
            Update::Residual => {}
            Update::NoOutput => return self.unjudged(),
            Update::Restarted => {
                self.parts.evaluator.reset();
                return self.unjudged();
            }
        }
        let residual = self.residual(residuals);
        if self.settling_left > 0 {
            self.settling_left -= 1;
            return ChannelVerdict {
                residual,
                ..ChannelVerdict::NONE
            };
        }
        let parts = &mut self.parts;
        let statistic = parts.evaluator.step(residual).value;
        let new_alarm = self
            .run
            .update(time_s, statistic, parts.limit, parts.persistence);
        let run_length = self.run.length();
        let estimate = if run_length > 0 {
            parts.evaluator.cap(CEILING * parts.limit);
            parts.evaluator.estimate()
        } else {
            None
        };
        ChannelVerdict {
            residual,
            statistic,
            exceeds: run_length > 0,
            run_length,
            alarm: self.run.alarm(),
            new_alarm,
            first_exceedance_s: self.run.first_exceedance_s(),
            onset_age: estimate.map(|estimate| estimate.age),
            deviation: estimate.map(|estimate| estimate.deviation * parts.unit),
            settling: false,
        }
    }

    fn residual(&mut self, residuals: &[f64]) -> f64 {
        let parts = &mut self.parts;
        match &mut parts.whitener {
            Some(whitener) => whitener.step(residuals, &parts.places),
            None => parts
                .places
                .first()
                .and_then(|&place| residuals.get(place).copied())
                .unwrap_or(f64::NAN),
        }
    }

    fn unjudged(&mut self) -> ChannelVerdict {
        self.settle_again();
        ChannelVerdict {
            settling: self.settling_left > 0,
            ..ChannelVerdict::NONE
        }
    }

    /// Adds all that makes this test what it is to a fingerprint.
    pub(crate) fn mark(&self, print: &mut Fingerprint) {
        let parts = &self.parts;
        for &place in parts.places.iter().chain(&parts.sources) {
            print.add(place as u64);
        }
        print.add(parts.limit.to_bits());
        print.add(parts.unit.to_bits());
        print.add(parts.persistence.consecutive as u64);
        print.add(parts.persistence.release as u64);
        print.add(parts.settle_samples as u64);
        if let Some(whitener) = &parts.whitener {
            whitener.mark(print);
        }
    }

    pub(crate) fn state(&self) -> ChannelState {
        let whitener = self.parts.whitener.as_ref();
        ChannelState {
            settling_left: self.settling_left,
            run: self.run,
            past: whitener.map_or_else(Box::default, |whitener| whitener.past().collect()),
            evaluator: self.parts.evaluator.clone(),
        }
    }

    /// Takes a state that [`Channel::state`] gave; says whether it fits. What was taken before a
    /// misfit stays.
    pub(crate) fn set_state(&mut self, state: &ChannelState) -> bool {
        let parts = &mut self.parts;
        // Two statistics are set alike when they are equal once they have forgotten all samples.
        let (mut own, mut other) = (parts.evaluator.clone(), state.evaluator.clone());
        own.reset();
        other.reset();
        let same = own == other && state.run.is_finite();
        let past = match &mut parts.whitener {
            Some(whitener) => whitener.set_past(&state.past),
            None => state.past.is_empty(),
        };
        parts.evaluator.clone_from(&state.evaluator);
        self.settling_left = state.settling_left;
        self.run = state.run;
        same && past && state.settling_left <= self.parts.settle_samples
    }
}
