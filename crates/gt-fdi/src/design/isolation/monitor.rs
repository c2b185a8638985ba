//! Alarms and names as they come.

use serde::{Deserialize, Serialize};

use super::detector::{IsolationDetector, IsolationState};
use super::isolator::Isolator;
use crate::FdiError;
use crate::runtime::{Diagnosis, Finding, IsolationVerdict, ResumeError, StepError};

/// Seconds between diagnoses while an alarm has no name, and after it has one.
const UNNAMED_S: f64 = 0.4;
const NAMED_S: f64 = 5.0;
/// Diagnoses in a row that must agree before a name is given, and contradict one before another is.
const AGREEING: usize = 2;
const CONTRARY: usize = 3;

/// What happened at a sample.
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

/// A detector that diagnoses while an alarm is up: every 0.4 s until a fault is named, and every 5 s
/// from then on. A fault is named when two diagnoses in a row agree, and a name that was given is
/// changed when three in a row contradict it.
#[derive(Debug, Clone)]
pub struct IsolationMonitor {
    detector: IsolationDetector,
    limits: Vec<f64>,
    events: Vec<IsolationEvent>,
    up: bool,
    name: Finding,
    due_s: f64,
    contrary: usize,
    last: Option<(f64, Diagnosis)>,
}

/// All that an [`IsolationMonitor`] remembers.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct MonitorState {
    detector: IsolationState,
    /// The name that stands while an alarm is up.
    name: Option<Finding>,
    due_s: Option<f64>,
    contrary: usize,
    last: Option<(f64, Diagnosis)>,
}

impl MonitorState {
    /// Time of the last sample in seconds; `None` before the first.
    pub fn last_time_s(&self) -> Option<f64> {
        self.detector.last_time_s()
    }
}

impl IsolationMonitor {
    /// A monitor in its initial state.
    ///
    /// # Errors
    /// None after construction of the isolator.
    pub fn new(isolator: &Isolator) -> Result<Self, FdiError> {
        Ok(Self {
            detector: IsolationDetector::new(isolator)?,
            limits: isolator.limits().to_vec(),
            events: Vec::new(),
            up: false,
            name: Finding::Undecided,
            due_s: f64::INFINITY,
            contrary: 0,
            last: None,
        })
    }

    /// Takes a sample, as [`IsolationDetector::step`], and gives what happened at it, mostly nothing.
    /// A diagnosis takes some milliseconds and allocates.
    ///
    /// # Errors
    /// As [`IsolationDetector::step`].
    pub fn step(&mut self, t_s: f64, u: &[f64], y: &[f64]) -> Result<&[IsolationEvent], StepError> {
        self.events.clear();
        let verdict = self.detector.step(t_s, u, y)?;
        let (time_s, alarm) = (verdict.time_s, verdict.alarm);
        if verdict.new_alarm {
            let leading = verdict.leading.unwrap_or(0);
            self.events.push(IsolationEvent::Alarm {
                time_s,
                leading,
                statistic: verdict.statistics[leading],
                limit: self.limits[leading],
            });
            (self.up, self.name, self.due_s) = (true, Finding::Undecided, time_s);
            self.contrary = 0;
        } else if self.up && !alarm {
            self.events.push(IsolationEvent::End { time_s });
            (self.up, self.due_s) = (false, f64::INFINITY);
        }
        // Times are sums of sample times.
        if time_s >= self.due_s - 1e-9 {
            self.diagnose();
        }
        Ok(&self.events)
    }

    /// Diagnoses at once if an alarm is up, as at the end of a record; gives what that changed.
    pub fn conclude(&mut self) -> &[IsolationEvent] {
        self.events.clear();
        let fresh = |(time_s, _): &(f64, Diagnosis)| *time_s >= self.verdict().time_s;
        if self.up && !self.last.as_ref().is_some_and(fresh) {
            self.diagnose();
        }
        &self.events
    }

    fn diagnose(&mut self) {
        let time_s = self.detector.verdict().time_s;
        let diagnosis = self.detector.diagnose();
        let finding = diagnosis.finding;
        if finding == self.name || finding == Finding::Undecided {
            self.contrary = 0;
        } else {
            let before = self.last.as_ref().map(|(_, last)| last.finding);
            let (wanted, goes_on) = if self.name == Finding::Undecided {
                (AGREEING, before == Some(finding))
            } else {
                (CONTRARY, true)
            };
            self.contrary = if goes_on { self.contrary + 1 } else { 1 };
            if self.contrary >= wanted {
                self.name = finding;
                self.contrary = 0;
                self.events.push(IsolationEvent::Name { time_s, finding });
            }
        }
        let wait_s = if self.name == Finding::Undecided {
            UNNAMED_S
        } else {
            NAMED_S
        };
        self.due_s = time_s + wait_s;
        self.last = Some((time_s, diagnosis));
    }

    /// All that it remembers.
    pub fn state(&self) -> MonitorState {
        MonitorState {
            detector: self.detector.state(),
            name: self.name(),
            due_s: self.due_s.is_finite().then_some(self.due_s),
            contrary: self.contrary,
            last: self.last.clone(),
        }
    }

    /// Goes on from the state of a monitor of the same isolator, bit for bit: an alarm that was up
    /// stays up, and is not raised again.
    ///
    /// # Errors
    /// As [`IsolationDetector::resume`].
    pub fn resume(&mut self, state: &MonitorState) -> Result<(), ResumeError> {
        self.detector.resume(&state.detector)?;
        self.events.clear();
        self.up = state.name.is_some();
        self.name = state.name.unwrap_or(Finding::Undecided);
        self.due_s = state.due_s.unwrap_or(f64::INFINITY);
        self.contrary = state.contrary.min(CONTRARY.max(AGREEING));
        self.last.clone_from(&state.last);
        Ok(())
    }

    /// What was said of the last sample.
    pub fn verdict(&self) -> &IsolationVerdict {
        self.detector.verdict()
    }

    /// As [`IsolationDetector::residuals`].
    pub fn residuals(&self) -> &[f64] {
        self.detector.residuals()
    }

    /// Forgets all samples; an alarm that was up is no longer, without an event.
    pub fn reset(&mut self) {
        self.detector.reset();
        self.events.clear();
        (self.up, self.name, self.due_s) = (false, Finding::Undecided, f64::INFINITY);
        self.contrary = 0;
        self.last = None;
    }

    /// The name that stands while an alarm is up.
    pub fn name(&self) -> Option<Finding> {
        self.up.then_some(self.name)
    }

    /// The last diagnosis, with its time in seconds.
    pub fn diagnosis(&self) -> Option<&(f64, Diagnosis)> {
        self.last.as_ref()
    }
}
