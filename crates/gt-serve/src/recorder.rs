//! Logs of all that comes and is said, a folder a machine.

use std::path::PathBuf;
use std::sync::Arc;
use std::time::{Duration, Instant};

use gt_log::{
    JsonTopicHead, LogError, LogHead, RotatingLog, RotationOptions, RunMetadata, TopicHead,
    recover_parts,
};
use gtfdi::core::Signal;
use serde_json::json;

use crate::clock::now_ns;
use crate::config::RecorderConfig;
use crate::error::ServeError;
use crate::hub::{Cell, Hub, Recorded};
use crate::metrics::count;
use crate::pipeline::{AlarmEvent, Machine, Quality, Sample};
use crate::queue::Popped;

/// How often logs are flushed and old ones removed.
const FLUSH: Duration = Duration::from_secs(5);
/// How often the time of the last flush is looked at.
const PATIENCE: Duration = Duration::from_millis(500);
/// How the names of all logs begin.
const STEM: &str = "machine";
/// Failed writes that are shown; all are counted.
const SHOWN: u32 = 10;

/// Numbers of the topics of a machine's log.
const MEASURED: usize = 0;
const RESIDUAL: usize = 1;
const STATISTIC: usize = 2;
/// The only one of its kind.
const QUALITY: usize = 0;
const ALARMS: usize = 0;
/// Qualities are repeated this often, so that a reader who starts in the middle finds them, ns.
const REPEAT_NS: i64 = 60_000_000_000;

/// The logs of all machines.
pub struct Recorder {
    logs: Vec<RotatingLog>,
    folders: Vec<PathBuf>,
    /// What was last said of the qualities of each machine, and when.
    qualities: Vec<(Vec<Quality>, i64)>,
    shown: u32,
}

impl Recorder {
    /// Logs below the folder of the configuration, which is made where it is not there.
    ///
    /// # Errors
    /// [`ServeError`] when a folder cannot be made or an option makes no sense.
    pub fn new(hub: &Hub, config: &RecorderConfig) -> Result<Self, ServeError> {
        let mut logs = Vec::new();
        let mut folders = Vec::new();
        for cell in &hub.cells {
            let folder = config.folder.join(&cell.name);
            std::fs::create_dir_all(&folder)
                .map_err(|cause| ServeError::io("make", &folder, &cause))?;
            let head = log_head(cell, &cell.lock());
            let options = RotationOptions {
                stem: STEM.to_owned(),
                span_s: config.span_s,
                max_bytes: config.max_bytes,
                keep_s: config.keep_s,
                keep_bytes: config.keep_bytes,
                ..RotationOptions::new(&folder)
            };
            folders.push(folder);
            logs.push(RotatingLog::create(options, head)?);
        }
        Ok(Self {
            qualities: vec![(Vec::new(), 0); logs.len()],
            logs,
            folders,
            shown: 0,
        })
    }

    /// Makes whole what a service that was killed left behind, so that it can be read and, in its
    /// time, be removed.
    fn recover_parts(&self) {
        for folder in &self.folders {
            let found = match recover_parts(folder, STEM) {
                Ok(found) => found,
                Err(error) => {
                    tracing::error!(%error, "the recorder");
                    continue;
                }
            };
            for own in found {
                let part = own.part.display();
                match own.outcome {
                    Ok(recovery) => {
                        tracing::info!(%part, messages = recovery.messages, "recovered");
                    }
                    Err(error) => tracing::error!(%part, %error, "not recovered"),
                }
            }
        }
    }

    /// Writes what comes until the queue is closed and empty.
    pub fn run(mut self, hub: &Arc<Hub>) {
        let Some(queue) = &hub.recorder else {
            return;
        };
        self.recover_parts();
        let mut flushed = Instant::now();
        loop {
            match queue.pop(PATIENCE) {
                Popped::Item(Recorded::Sample {
                    machine,
                    sample,
                    residuals,
                    statistics,
                }) => {
                    let written = self.sample(machine, &sample, &residuals, &statistics);
                    self.note(hub, written);
                }
                Popped::Item(Recorded::Detector { machine, head }) => {
                    // The new file has them from its beginning.
                    if let Some((qualities, _)) = self.qualities.get_mut(machine) {
                        qualities.clear();
                    }
                    let begun = self.logs.get_mut(machine).map(|log| log.begin_with(*head));
                    self.note(hub, begun.unwrap_or(Ok(())));
                }
                Popped::Item(Recorded::Event { machine, event }) => {
                    let written = self.event(machine, &event);
                    self.note(hub, written);
                }
                Popped::Nothing => {}
                Popped::Closed => break,
            }
            if flushed.elapsed() >= FLUSH {
                flushed = Instant::now();
                let now_ns = u64::try_from(now_ns()).unwrap_or(0);
                for machine in 0..self.logs.len() {
                    let ticked = self.logs[machine].tick(now_ns);
                    self.note(hub, ticked);
                }
            }
        }
        for log in std::mem::take(&mut self.logs) {
            let finished = log.finish();
            self.note(hub, finished);
        }
    }

    fn sample(
        &mut self,
        machine: usize,
        sample: &Sample,
        residuals: &[f64],
        statistics: &[f64],
    ) -> Result<(), LogError> {
        let Some(log) = self.logs.get_mut(machine) else {
            return Ok(());
        };
        let time_ns = u64::try_from(sample.time_ns).unwrap_or(0);
        let values = |of: &[f64]| of.iter().copied().map(Some).collect::<Vec<_>>();
        log.write(MEASURED, time_ns, &values(&sample.values))?;
        let (qualities, said_ns) = &mut self.qualities[machine];
        let is_due = sample.time_ns.abs_diff(*said_ns) >= REPEAT_NS.unsigned_abs();
        if is_due || *qualities != sample.qualities {
            qualities.clone_from(&sample.qualities);
            *said_ns = sample.time_ns;
            log.write_quality(QUALITY, time_ns, qualities)?;
        }
        log.write(RESIDUAL, time_ns, &values(residuals))?;
        log.write(STATISTIC, time_ns, &values(statistics))
    }

    fn event(&mut self, machine: usize, event: &AlarmEvent) -> Result<(), LogError> {
        let time_ns = u64::try_from(event.time_ms.saturating_mul(1_000_000)).unwrap_or(0);
        let log = self.logs.get_mut(machine);
        log.map_or(Ok(()), |log| log.write_json(ALARMS, time_ns, event))
    }

    /// A failed write is counted and shown; the service goes on.
    fn note(&mut self, hub: &Hub, written: Result<(), LogError>) {
        if let Err(error) = written {
            count(&hub.metrics.recorder_errors);
            self.shown += 1;
            if self.shown <= SHOWN {
                tracing::error!(%error, "the recorder");
            }
        }
    }
}

/// What the log of a machine, which is locked, begins with: its topics, and its detector.
pub fn log_head(cell: &Cell, machine: &Machine) -> LogHead {
    let watch = machine.watch();
    let period_s = watch.sample_time_s();
    let inputs = watch.inputs().iter();
    let signals: Vec<Signal> = inputs.chain(watch.outputs()).cloned().collect();
    let topic = |topic: String, message: &str, fields: Vec<Signal>| TopicHead {
        topic,
        message: message.to_owned(),
        fields,
        sample_period_s: period_s,
        asset: cell.name.clone(),
    };
    let tags: Vec<&str> = signals.iter().map(|signal| signal.name.as_str()).collect();
    let tags = Signal::named(&tags);
    let fdi = |what: &str| format!("/fdi/{}/{what}", watch.name());
    let statistics = Signal::named(watch.statistic_names());
    LogHead {
        run: RunMetadata::default(),
        attachments: vec![(
            format!("models/{}.json", watch.name()),
            "application/json".to_owned(),
            cell.detector_text().to_vec(),
        )],
        topics: vec![
            topic("/plant/measured".to_owned(), "Measured", signals),
            topic(fdi("residual"), "Residual", watch.outputs().to_vec()),
            topic(fdi("statistic"), "Statistic", statistics),
        ],
        quality_topics: vec![topic("/plant/quality".to_owned(), "Quality", tags)],
        json_topics: vec![JsonTopicHead {
            topic: "/alarms".to_owned(),
            message: "AlarmEvent".to_owned(),
            schema: json!({"type": "object"}),
            asset: cell.name.clone(),
        }],
    }
}
