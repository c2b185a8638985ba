//! The embedded turbine.

use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::thread;
use std::time::{Duration, Instant};

use gtfdi::plant::{Fault, LivePlant, PlantError, SAMPLE_TIME_S, Scenario, Variant};
use serde::{Deserialize, Serialize};

use crate::clock::now_ns;
use crate::config::PlantConfig;
use crate::error::ServeError;
use crate::hub::{Batch, Hub};
use crate::pipeline::{Quality, Reading};

/// The scenario of the turbine, with the noise of its sensors in their units;
/// `cargo run --release -p gt-serve --example embedded_turbine crates/gt-serve/assets` makes it.
const TURBINE_SCENARIO: &str = include_str!("../../assets/turbine_scenario.json");
/// How often a sleeping plant looks whether to stop.
const PATIENCE: Duration = Duration::from_millis(50);

/// The embedded turbine with its faults, for who runs it and who injects them.
pub struct EmbeddedPlant {
    /// Place of its machine.
    pub machine: usize,
    speed: f64,
    scenario: Scenario,
    turbine: Mutex<Turbine>,
}

struct Turbine {
    live: LivePlant,
    /// Time of its sample at 0 s, ns.
    origin_ns: i64,
    /// Whether it has left the range in which its model means something.
    stands_still: bool,
}

/// A fault that is active or will be.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct ActiveFault {
    /// Its name.
    pub case: String,
    /// When it began, in milliseconds since 1970.
    pub onset_ms: i64,
    /// Its size now.
    pub size: f64,
    /// Unit of the size.
    pub unit: String,
}

impl EmbeddedPlant {
    /// The turbine before its first sample: compressor maps and noise of the paper.
    ///
    /// # Errors
    /// [`ServeError`] when it cannot be started.
    pub fn new(machine: usize, config: &PlantConfig) -> Result<Self, ServeError> {
        let mut scenario: Scenario =
            serde_json::from_str(TURBINE_SCENARIO).map_err(|cause| ServeError::Config {
                path: "the built-in scenario".into(),
                cause: cause.to_string(),
            })?;
        scenario.seed = config.seed;
        Ok(Self {
            machine,
            speed: config.speed,
            turbine: Mutex::new(Turbine {
                live: LivePlant::start(&scenario)?,
                origin_ns: now_ns(),
                stands_still: false,
            }),
            scenario,
        })
    }

    fn lock(&self) -> MutexGuard<'_, Turbine> {
        self.turbine.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// The faults that there are.
    pub fn faults(&self) -> Vec<ActiveFault> {
        let turbine = self.lock();
        let now_s = turbine.live.next_time_s();
        let faults = turbine.live.faults().iter();
        faults
            .map(|fault| ActiveFault {
                case: fault.target.name(),
                #[allow(clippy::cast_possible_truncation)] // saturates
                onset_ms: (turbine.origin_ns as f64 / 1e6 + fault.onset_s * 1e3) as i64,
                size: fault.magnitude(now_s),
                unit: fault.unit().to_owned(),
            })
            .collect()
    }

    /// Adds a fault whose onset is so many seconds of the plant from its next sample.
    ///
    /// # Errors
    /// [`PlantError`] when it makes no sense beside the others; nothing is changed then.
    pub fn inject(&self, mut fault: Fault) -> Result<(), PlantError> {
        let live = &mut self.lock().live;
        let now_s = live.next_time_s();
        fault.onset_s += now_s;
        fault.end_s = fault.end_s.map(|end_s| end_s + now_s);
        let mut faults = live.faults().to_vec();
        faults.push(fault);
        live.set_faults(faults)
    }

    /// Takes all faults away, and starts a turbine again that they have brought to a stand.
    ///
    /// # Errors
    /// [`PlantError`] when it cannot be started.
    pub fn repair(&self) -> Result<(), PlantError> {
        let turbine = &mut *self.lock();
        if turbine.stands_still {
            turbine.live = LivePlant::start(&self.scenario)?;
            turbine.stands_still = false;
        }
        turbine.live.set_faults(Vec::new())
    }

    /// Runs it in the time of the clock until the service stops. A plant that leaves the range in
    /// which its model means something stands still, which the page shows as silence, until its
    /// faults are taken away: then it is started again.
    pub fn run(self: &Arc<Self>, hub: &Arc<Hub>) {
        let Some(cell) = hub.cells.get(self.machine) else {
            return;
        };
        let variant = Variant::Prototype;
        let names = variant
            .input_channels()
            .iter()
            .chain(variant.output_channels());
        let places: Vec<Option<usize>> = names.map(|channel| cell.place(channel.0)).collect();
        let period_s = SAMPLE_TIME_S / self.speed;
        let started = Instant::now();
        let origin_ns = now_ns();
        let mut k = 0.0;
        while !hub.is_stopping() {
            let due = Duration::from_secs_f64(k * period_s);
            let early = due.saturating_sub(started.elapsed());
            if !early.is_zero() {
                thread::sleep(early.min(PATIENCE));
                continue;
            }
            // The samples of the plant keep their own period: a plant that runs faster lives in a
            // time of its own that begins now.
            let since_ns = |seconds: f64| {
                #[allow(clippy::cast_possible_truncation)] // of a time since 1970
                let ns = (seconds * 1e9).round() as i64;
                ns
            };
            let time_ns = origin_ns + since_ns(k * SAMPLE_TIME_S);
            let mut readings = Vec::with_capacity(places.len());
            {
                let turbine = &mut *self.lock();
                match turbine.live.sample() {
                    Ok(sample) => {
                        turbine.origin_ns = time_ns - since_ns(sample.time_s);
                        let values = sample.u.iter().chain(&sample.y);
                        for (place, value) in places.iter().zip(values) {
                            if let Some(tag) = *place {
                                readings.push(Reading {
                                    tag,
                                    time_ns,
                                    value: *value,
                                    quality: Quality::Good,
                                });
                            }
                        }
                    }
                    Err(cause) => {
                        if !turbine.stands_still {
                            tracing::warn!(%cause, "the embedded turbine stands still");
                        }
                        turbine.stands_still = true;
                    }
                }
            }
            k += 1.0;
            let batch = Batch {
                machine: self.machine,
                arrived_ns: now_ns(),
                readings,
            };
            if !batch.readings.is_empty() && !hub.offer(batch) {
                return;
            }
        }
    }
}
