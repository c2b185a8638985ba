//! The online detector: a bank of generators and thresholds, fed sample by sample.

use alloc::string::String;
use alloc::vec::Vec;

use serde::Serialize;
use thiserror::Error;

use super::{ExceedanceRun, Generator, Update};

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

/// What the detector says of one output at one sample.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
#[allow(clippy::struct_excessive_bools)] // four independent answers, read by name
pub struct ChannelVerdict {
    /// The residual in the output's unit; NaN when an input or the output is missing.
    pub residual: f64,
    /// Whether `|residual|` is above the limit; `false` while settling.
    pub exceeds: bool,
    /// Samples above the limit in a row, this one included.
    pub run_length: usize,
    /// Whether an alarm is up.
    pub alarm: bool,
    /// Whether the alarm came up with this sample.
    pub new_alarm: bool,
    /// Time of the first sample of the present run above the limit, in seconds: the onset estimate
    /// of an alarm. `None` outside a run.
    pub first_exceedance_s: Option<f64>,
    /// Whether the generator has not yet forgotten its initial state, so that nothing is judged.
    pub settling: bool,
}

impl ChannelVerdict {
    const NONE: Self = Self {
        residual: f64::NAN,
        exceeds: false,
        run_length: 0,
        alarm: false,
        new_alarm: false,
        first_exceedance_s: None,
        settling: true,
    };
}

/// What the detector says of one sample.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Verdict {
    /// Time of the sample in seconds.
    pub time_s: f64,
    /// Whether samples are missing before this one, so that every generator started afresh.
    pub gap: bool,
    /// One verdict an output, in the order of [`Detector::outputs`].
    pub channels: Vec<ChannelVerdict>,
}

/// One output's generator, threshold and memory.
#[derive(Debug, Clone)]
pub(crate) struct Channel {
    generator: Generator,
    limit: f64,
    consecutive: usize,
    settle_samples: usize,
    /// Corrected samples still to come before the residual is judged.
    settling_left: usize,
    run: ExceedanceRun,
}

impl Channel {
    pub(crate) fn new(
        generator: Generator,
        limit: f64,
        consecutive: usize,
        settle_samples: usize,
    ) -> Self {
        let run = ExceedanceRun::default();
        let settling_left = settle_samples;
        Self {
            generator,
            limit,
            consecutive,
            settle_samples,
            settling_left,
            run,
        }
    }

    fn restart(&mut self) {
        self.generator.reset();
        self.settle_again();
    }

    fn settle_again(&mut self) {
        self.settling_left = self.settle_samples;
        self.run.clear();
    }

    fn step(&mut self, time_s: f64, u: &[f64], y: f64) -> ChannelVerdict {
        match self.generator.step(u, y) {
            Update::Residual(residual) => {
                let settling = self.settling_left > 0;
                if settling {
                    self.settling_left -= 1;
                    return ChannelVerdict {
                        residual,
                        ..ChannelVerdict::NONE
                    };
                }
                let run_length = self.run.update(time_s, residual, self.limit);
                ChannelVerdict {
                    residual,
                    exceeds: run_length > 0,
                    run_length,
                    alarm: run_length >= self.consecutive,
                    new_alarm: run_length == self.consecutive,
                    first_exceedance_s: self.run.first_exceedance_s(),
                    settling,
                }
            }
            Update::NoOutput => {
                self.settle_again();
                ChannelVerdict {
                    settling: self.settling_left > 0,
                    ..ChannelVerdict::NONE
                }
            }
            Update::Restarted => {
                self.restart();
                ChannelVerdict {
                    settling: self.settling_left > 0,
                    ..ChannelVerdict::NONE
                }
            }
        }
    }
}

/// A bank that takes samples as they come; made by `Detector::new(&bank)`.
///
/// Nothing is allocated by [`Detector::step`]. Broken samples are read the safe way:
///
/// - **Start.** Alarms are inhibited for the first `settle_samples` of each generator: its
///   residual is reported with `settling`, and not judged.
/// - **Output not finite.** Its generator predicts without a correction (`x+ = A x + B u`): the
///   residual is NaN, the run above the limit ends and the generator settles again. A residual is
///   coloured, so even one correction left out leaves an error in the state that the limit was not
///   set for, often many times the limit.
/// - **Input not finite.** The generators that read it go back to their initial state and settle
///   again: a held or invented input would show as a fault of the output.
/// - **A gap in time** (more than 1.5 sample times): every generator starts afresh and settles.
/// - **Absurd output.** A finite output more than 1e150 away from its operating point is judged,
///   and kept out of the state; any other overflow restarts the generator.
#[derive(Debug, Clone)]
pub struct Detector {
    inputs: Vec<String>,
    outputs: Vec<String>,
    sample_time_s: f64,
    channels: Vec<Channel>,
    last_time_s: Option<f64>,
    verdict: Verdict,
}

impl Detector {
    /// A detector from its parts: as many channels as outputs.
    pub(crate) fn from_parts(
        inputs: Vec<String>,
        outputs: Vec<String>,
        sample_time_s: f64,
        channels: Vec<Channel>,
    ) -> Self {
        let verdicts = channels.iter().map(|_| ChannelVerdict::NONE).collect();
        let verdict = Verdict {
            time_s: f64::NAN,
            gap: false,
            channels: verdicts,
        };
        Self {
            inputs,
            outputs,
            sample_time_s,
            channels,
            last_time_s: None,
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

    /// Sample time in seconds.
    pub fn sample_time_s(&self) -> f64 {
        self.sample_time_s
    }

    /// Takes the sample of time `t_s` (seconds): the inputs `u` and the outputs `y`, in the order
    /// of [`Detector::inputs`] and [`Detector::outputs`]. NaN means *no valid sample*.
    ///
    /// # Errors
    /// [`StepError`] when a size is wrong or the time does not advance; the detector is then as it
    /// was before the call.
    pub fn step(&mut self, t_s: f64, u: &[f64], y: &[f64]) -> Result<&Verdict, StepError> {
        if u.len() != self.inputs.len() {
            return Err(StepError::InputCount {
                expected: self.inputs.len(),
                found: u.len(),
            });
        }
        if y.len() != self.channels.len() {
            return Err(StepError::OutputCount {
                expected: self.channels.len(),
                found: y.len(),
            });
        }
        let gap = self.check_time(t_s)?;
        self.last_time_s = Some(t_s);
        self.verdict.time_s = t_s;
        self.verdict.gap = gap;
        let verdicts = self.verdict.channels.iter_mut();
        for ((channel, verdict), &y) in self.channels.iter_mut().zip(verdicts).zip(y) {
            if gap {
                channel.restart();
            }
            *verdict = channel.step(t_s, u, y);
        }
        Ok(&self.verdict)
    }

    /// Whether samples are missing before `t_s`.
    fn check_time(&self, t_s: f64) -> Result<bool, StepError> {
        if !t_s.is_finite() {
            return Err(StepError::TimeNotFinite { found_s: t_s });
        }
        let Some(previous_s) = self.last_time_s else {
            return Ok(false);
        };
        let advance = (t_s - previous_s) / self.sample_time_s;
        if advance < EARLIEST_ADVANCE {
            let sample_time_s = self.sample_time_s;
            return Err(StepError::TimeNotAdvancing {
                previous_s,
                found_s: t_s,
                sample_time_s,
            });
        }
        Ok(advance > LATEST_ADVANCE)
    }

    /// Forgets all samples: the next one may have any time, and every generator settles again.
    pub fn reset(&mut self) {
        self.last_time_s = None;
        self.verdict.time_s = f64::NAN;
        self.verdict.gap = false;
        self.verdict.channels.fill(ChannelVerdict::NONE);
        for channel in &mut self.channels {
            channel.restart();
        }
    }
}
