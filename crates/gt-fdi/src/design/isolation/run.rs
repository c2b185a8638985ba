//! An isolator at work: sample by sample, and over a record.

use gt_core::Dataset;
use serde::Serialize;

use super::isolator::Isolator;
use crate::FdiError;
use crate::design::channels::Channels;
use crate::runtime::{Clock, Core, Diagnosis, Finding, IsolationVerdict, StepError};

/// Seconds between diagnoses while an alarm has no name, and after it has one.
const UNNAMED_S: f64 = 0.4;
const NAMED_S: f64 = 5.0;
/// Diagnoses in a row that must contradict a name before another is given.
const CONTRARY: usize = 3;

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

    /// Forgets all samples.
    pub fn reset(&mut self) {
        self.clock.reset();
        self.core.reset();
    }
}

/// What happened in a run.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[serde(tag = "event", rename_all = "snake_case")]
pub enum IsolationEvent {
    /// An alarm came up.
    Alarm {
        /// When, in seconds.
        time_s: f64,
        /// Position of the statistic furthest above its limit; one past the hypotheses for a change
        /// in any direction.
        leading: usize,
        /// That statistic.
        statistic: f64,
        /// Its limit.
        limit: f64,
    },
    /// A fault was named, or another than before.
    Name {
        /// When, in seconds.
        time_s: f64,
        /// What was found.
        finding: Finding,
    },
    /// The alarm ended.
    End {
        /// When, in seconds.
        time_s: f64,
    },
}

/// What an isolator says of a record.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct IsolationRun {
    /// In order of time.
    pub events: Vec<IsolationEvent>,
    /// The last diagnosis, with its time in seconds; `None` without an alarm.
    pub last: Option<(f64, Diagnosis)>,
    /// Samples that were judged.
    pub judged: usize,
    /// The largest ratio of a statistic to its limit, in each [`IsolationRun::PART_S`] seconds of
    /// the record.
    pub peaks: Vec<f64>,
}

impl IsolationRun {
    /// Length of the parts of [`IsolationRun::peaks`] in seconds.
    pub const PART_S: f64 = 1.0;
}

impl Isolator {
    /// Runs over a record that has the tags, by name, in any order and among others. While an alarm
    /// is up there is a diagnosis every 0.4 s until a fault is named, and every 5 s from then on; a
    /// name that was given is changed when three of those in a row contradict it.
    ///
    /// # Errors
    /// [`FdiError::MissingTags`] and [`FdiError::SampleTime`] when the record does not fit.
    pub fn run(&self, data: &Dataset) -> Result<IsolationRun, FdiError> {
        let (inputs, outputs) = (self.inputs(), self.outputs());
        let mut channels = Channels::of(data, self.sample_time_s(), &inputs, &outputs)?;
        let mut detector = IsolationDetector::new(self)?;
        let mut run = IsolationRun {
            events: Vec::new(),
            last: None,
            judged: 0,
            peaks: Vec::new(),
        };
        let (mut up, mut name, mut due_s) = (false, Finding::Undecided, f64::INFINITY);
        let mut contrary = 0;
        let start_s = data.time_s(0);
        for sample in 0..data.len() {
            let (u, y) = channels.at(sample);
            let verdict = detector.step(data.time_s(sample), u, y)?;
            let time_s = verdict.time_s;
            run.judged += usize::from(!verdict.settling);
            let ratios = verdict.statistics.iter().zip(self.limits());
            let ratio = ratios.map(|(own, limit)| own / limit).fold(0.0, f64::max);
            #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)] // saturates
            let part = ((time_s - start_s) / IsolationRun::PART_S) as usize;
            if run.peaks.len() <= part {
                run.peaks.resize(part + 1, 0.0);
            }
            run.peaks[part] = ratio.max(run.peaks[part]);
            if verdict.new_alarm {
                let leading = verdict.leading.unwrap_or(0);
                run.events.push(IsolationEvent::Alarm {
                    time_s,
                    leading,
                    statistic: verdict.statistics[leading],
                    limit: self.limits()[leading],
                });
                (up, name, due_s) = (true, Finding::Undecided, time_s);
            } else if up && !verdict.alarm {
                run.events.push(IsolationEvent::End { time_s });
                (up, due_s) = (false, f64::INFINITY);
            }
            let last = up && sample + 1 == data.len();
            if time_s >= due_s - 1e-9 || last {
                let diagnosis = detector.diagnose();
                let finding = diagnosis.finding;
                if finding == name || finding == Finding::Undecided {
                    contrary = 0;
                } else {
                    contrary += 1;
                    if name == Finding::Undecided || contrary >= CONTRARY {
                        name = finding;
                        contrary = 0;
                        run.events.push(IsolationEvent::Name { time_s, finding });
                    }
                }
                due_s = time_s
                    + if name == Finding::Undecided {
                        UNNAMED_S
                    } else {
                        NAMED_S
                    };
                run.last = Some((time_s, diagnosis));
            }
        }
        Ok(run)
    }
}
