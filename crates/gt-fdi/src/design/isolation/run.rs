//! What an isolator says of a record.

use gt_core::{Dataset, Never, Stop};
use serde::Serialize;

use super::isolator::Isolator;
use super::monitor::{IsolationEvent, IsolationMonitor};
use crate::FdiError;
use crate::design::channels::Channels;
use crate::runtime::{Diagnosis, Finding, IsolationVerdict};

/// An alarm with what was found.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct IsolationAlarm {
    /// When it came up, in seconds.
    pub time_s: f64,
    /// When it ended, in seconds; `None` while it is up.
    pub end_s: Option<f64>,
    /// Position of the statistic that was furthest above its limit; one past the hypotheses for a
    /// change in any direction.
    pub leading: usize,
    /// That statistic.
    pub statistic: f64,
    /// Its limit.
    pub limit: f64,
    /// When the name that stands was given, in seconds.
    pub named_s: Option<f64>,
    /// The name that stands.
    pub finding: Finding,
    /// When the last diagnosis was made, in seconds.
    pub diagnosed_s: f64,
    /// The last diagnosis of this alarm.
    pub diagnosis: Diagnosis,
}

/// What an isolator says of a record.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct IsolationRun {
    /// In order of time.
    pub events: Vec<IsolationEvent>,
    /// In order of time.
    pub alarms: Vec<IsolationAlarm>,
    /// Samples that were judged.
    pub judged: usize,
    /// The largest ratio of a statistic to its limit, in each [`IsolationRun::PART_S`] seconds of
    /// the record.
    pub peaks: Vec<f64>,
}

impl IsolationRun {
    /// Length of the parts of [`IsolationRun::peaks`] in seconds.
    pub const PART_S: f64 = 1.0;

    /// Takes what happened at a sample.
    fn take(&mut self, events: &[IsolationEvent], diagnosis: Option<&(f64, Diagnosis)>) {
        for event in events {
            match *event {
                IsolationEvent::Alarm {
                    time_s,
                    leading,
                    statistic,
                    limit,
                } => {
                    if let Some((diagnosed_s, diagnosis)) = diagnosis {
                        self.alarms.push(IsolationAlarm {
                            time_s,
                            end_s: None,
                            leading,
                            statistic,
                            limit,
                            named_s: None,
                            finding: Finding::Undecided,
                            diagnosed_s: *diagnosed_s,
                            diagnosis: diagnosis.clone(),
                        });
                    }
                }
                IsolationEvent::Name { time_s, finding } => {
                    if let Some(alarm) = self.alarms.last_mut() {
                        (alarm.named_s, alarm.finding) = (Some(time_s), finding);
                    }
                }
                IsolationEvent::End { time_s } => {
                    if let Some(alarm) = self.alarms.last_mut() {
                        alarm.end_s = Some(time_s);
                    }
                }
            }
        }
        if let (Some(alarm), Some((diagnosed_s, diagnosis))) = (self.alarms.last_mut(), diagnosis)
            && *diagnosed_s > alarm.diagnosed_s
        {
            alarm.diagnosed_s = *diagnosed_s;
            alarm.diagnosis.clone_from(diagnosis);
        }
        self.events.extend_from_slice(events);
    }
}

impl Isolator {
    /// Runs an [`IsolationMonitor`] over a record that has the tags, by name, in any order and among
    /// others.
    ///
    /// # Errors
    /// [`FdiError::MissingTags`] and [`FdiError::SampleTime`] when the record does not fit.
    pub fn run(&self, data: &Dataset) -> Result<IsolationRun, FdiError> {
        self.run_with(data, |_| {})
    }

    /// The same, and shows every sample's verdict to `watch`.
    ///
    /// # Errors
    /// As [`Isolator::run`].
    pub fn run_with(
        &self,
        data: &Dataset,
        watch: impl FnMut(&IsolationVerdict),
    ) -> Result<IsolationRun, FdiError> {
        self.run_until(data, &Never, watch)
    }

    /// The same, until `stop` wants it to end; it is asked at every sample.
    ///
    /// # Errors
    /// As [`Isolator::run`]; [`FdiError::Stopped`].
    pub fn run_until(
        &self,
        data: &Dataset,
        stop: &dyn Stop,
        mut watch: impl FnMut(&IsolationVerdict),
    ) -> Result<IsolationRun, FdiError> {
        let (inputs, outputs) = (self.inputs(), self.outputs());
        let mut channels = Channels::of(data, self.sample_time_s(), &inputs, &outputs)?;
        let mut monitor = IsolationMonitor::new(self)?;
        let mut run = IsolationRun {
            events: Vec::new(),
            alarms: Vec::new(),
            judged: 0,
            peaks: Vec::new(),
        };
        let start_s = data.time_s(0);
        for sample in 0..data.len() {
            stop.check()?;
            let (u, y) = channels.at(sample);
            let events = monitor.step(data.time_s(sample), u, y)?.to_vec();
            run.take(&events, monitor.diagnosis());
            let verdict = monitor.verdict();
            watch(verdict);
            run.judged += usize::from(!verdict.settling);
            let ratio = verdict.worst_ratio(self.limits());
            #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)] // saturates
            let part = ((verdict.time_s - start_s) / IsolationRun::PART_S) as usize;
            if run.peaks.len() <= part {
                run.peaks.resize(part + 1, 0.0);
            }
            run.peaks[part] = ratio.max(run.peaks[part]);
        }
        let events = monitor.conclude().to_vec();
        run.take(&events, monitor.diagnosis());
        Ok(run)
    }
}
