//! Records that are played.

use std::sync::Arc;
use std::thread;
use std::time::{Duration, Instant};

use gt_log::{Selection, read_dataset};
use gtfdi::core::{Dataset, Signal};
use gtfdi::ident::Missing;

use crate::clock::now_ns;
use crate::config::ReplayConfig;
use crate::error::ServeError;
use crate::hub::{Batch, Hub};
use crate::pipeline::{Quality, Reading};

/// Samples that are offered together where there is no clock to follow.
const AT_ONCE: usize = 32;

/// A record that is read and ready to be played.
pub struct Replay {
    machine: usize,
    speed: f64,
    /// Time of the first sample in nanoseconds since 1970.
    start_ns: i64,
    data: Dataset,
}

impl Replay {
    /// Reads the tags of the machine from the file.
    ///
    /// # Errors
    /// [`ServeError`] when the file cannot be read or lacks a tag.
    pub fn read(hub: &Hub, config: &ReplayConfig) -> Result<Self, ServeError> {
        let machine = hub.machine(&config.machine).unwrap_or(0);
        let (inputs, outputs) = {
            let machine = hub.cells[machine].lock();
            let names = |signals: &[Signal]| {
                let names = signals.iter().map(|signal| signal.name.clone());
                names.collect::<Vec<String>>()
            };
            let watch = machine.watch();
            (names(watch.inputs()), names(watch.outputs()))
        };
        let selection = Selection {
            inputs,
            outputs,
            missing: Missing::Break,
            ..Selection::default()
        };
        // As `detect` reads it: what is missing is NaN.
        let imported = read_dataset(&config.file, &selection)?;
        let start_ns = imported.start_unix_ns;
        let data = imported.filled(&config.file)?.dataset;
        let own_s = hub.cells[machine].lock().watch().sample_time_s();
        let found_s = data.sample_time_s();
        if (found_s - own_s).abs() > 1e-6 * own_s {
            return Err(ServeError::option(
                format!("replay.file {}", config.file.display()),
                format!(
                    "a sample every {own_s} s, as the detector of `{}`",
                    config.machine
                ),
                format!("every {found_s} s"),
            ));
        }
        #[allow(clippy::cast_possible_truncation)] // saturates
        let relative_ns = (data.time_s(0) * 1e9).round() as i64;
        let start_ns = start_ns.and_then(|start_ns| i64::try_from(start_ns).ok());
        Ok(Self {
            machine,
            speed: config.speed,
            start_ns: start_ns.unwrap_or(relative_ns),
            data,
        })
    }

    /// Plays it to its end, or until the service stops. Times are those of the record.
    pub fn play(&self, hub: &Arc<Hub>) {
        let started = Instant::now();
        let data = &self.data;
        let mut sample = 0;
        while sample < data.len() && !hub.is_stopping() {
            let count = if self.speed > 0.0 {
                let due_s = (data.time_s(sample) - data.time_s(0)) / self.speed;
                let early = Duration::from_secs_f64(due_s).saturating_sub(started.elapsed());
                if !early.is_zero() {
                    thread::sleep(early.min(Duration::from_millis(50)));
                    continue;
                }
                1
            } else {
                AT_ONCE
            };
            let end = (sample + count).min(data.len());
            let readings = (sample..end).flat_map(|k| {
                #[allow(clippy::cast_possible_truncation)] // saturates
                let after_ns = (k as f64 * data.sample_time_s() * 1e9).round() as i64;
                let time_ns = self.start_ns.saturating_add(after_ns);
                let (u, y) = (data.u().column(k), data.y().column(k));
                let values: Vec<f64> = u.iter().chain(y.iter()).copied().collect();
                values
                    .into_iter()
                    .enumerate()
                    .map(move |(tag, value)| Reading {
                        tag,
                        time_ns,
                        value,
                        quality: Quality::Good,
                    })
            });
            let batch = Batch {
                machine: self.machine,
                arrived_ns: now_ns(),
                readings: readings.collect(),
            };
            if !hub.offer(batch) {
                return;
            }
            sample = end;
        }
    }
}
