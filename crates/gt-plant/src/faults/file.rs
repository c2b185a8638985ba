//! A fault as a table of a file.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::target::SPIKES_PER_H;
use super::{
    ActuatorId, Exponential, Fault, FaultCase, Intermittent, Mode, Ramp, Shape, Step, Target,
};
use crate::PlantError;
use crate::channel::Channel;

/// The keys of a fault; see [`Fault`].
#[derive(Debug, Clone, Default, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub(super) struct FaultTable {
    #[serde(skip_serializing_if = "Option::is_none")]
    case: Option<FaultCase>,
    #[serde(skip_serializing_if = "Option::is_none")]
    sensor: Option<Channel>,
    #[serde(skip_serializing_if = "Option::is_none")]
    actuator: Option<ActuatorId>,
    #[serde(skip_serializing_if = "Option::is_none")]
    mode: Option<String>,
    #[serde(skip_serializing_if = "Option::is_none")]
    spikes_per_h: Option<f64>,
    onset_s: f64,
    #[serde(skip_serializing_if = "Option::is_none")]
    end_s: Option<f64>,
    #[serde(skip_serializing_if = "Option::is_none")]
    step: Option<Step>,
    #[serde(skip_serializing_if = "Option::is_none")]
    ramp: Option<Ramp>,
    #[serde(skip_serializing_if = "Option::is_none")]
    exponential: Option<Exponential>,
    #[serde(skip_serializing_if = "Option::is_none")]
    intermittent: Option<Intermittent>,
    // The flat ramp of a case; never written.
    #[serde(skip_serializing)]
    rate_percent_per_h: Option<f64>,
    #[serde(skip_serializing)]
    limit_percent: Option<f64>,
    #[serde(skip_serializing)]
    rate_s_per_h: Option<f64>,
    #[serde(skip_serializing)]
    limit_s: Option<f64>,
}

/// The names of the keys that are there.
fn present(keys: &[(&'static str, bool)]) -> String {
    let names: Vec<&str> = keys
        .iter()
        .filter(|(_, is_there)| *is_there)
        .map(|(name, _)| *name)
        .collect();
    if names.is_empty() {
        "none".to_owned()
    } else {
        names.join(" and ")
    }
}

fn refuse<T>(expected: &'static str, found: String) -> Result<T, PlantError> {
    Err(PlantError::FaultTable { expected, found })
}

impl FaultTable {
    fn target(&self) -> Result<Target, PlantError> {
        match (self.case, self.sensor, self.actuator) {
            (Some(case), None, None) => {
                let extra = [
                    ("mode", self.mode.is_some()),
                    ("spikes_per_h", self.spikes_per_h.is_some()),
                ];
                match extra.iter().find(|(_, is_there)| *is_there) {
                    Some((name, _)) => refuse("no mode beside a case", (*name).to_owned()),
                    None => Ok(Target::Case(case)),
                }
            }
            (None, Some(channel), None) => Ok(Target::Sensor {
                channel,
                mode: self.mode()?,
            }),
            (None, None, Some(actuator)) => Ok(Target::Actuator {
                actuator,
                mode: self.mode()?,
            }),
            (case, sensor, actuator) => refuse(
                "exactly one of the keys case, sensor, actuator",
                present(&[
                    ("case", case.is_some()),
                    ("sensor", sensor.is_some()),
                    ("actuator", actuator.is_some()),
                ]),
            ),
        }
    }

    fn mode(&self) -> Result<Mode, PlantError> {
        let Some(name) = &self.mode else {
            return refuse("a mode for a sensor or an actuator", "none".to_owned());
        };
        match (name.parse()?, self.spikes_per_h) {
            (Mode::Spike { .. }, rate) => Ok(Mode::Spike {
                spikes_per_h: rate.unwrap_or(SPIKES_PER_H),
            }),
            (mode, None) => Ok(mode),
            (mode, Some(_)) => refuse("spikes_per_h with mode spike only", mode.to_string()),
        }
    }

    /// The ramp of a case by its flat keys.
    fn flat_ramp(&self, target: &Target) -> Result<Option<Shape>, PlantError> {
        let keys = [
            ("rate_percent_per_h", self.rate_percent_per_h.is_some()),
            ("limit_percent", self.limit_percent.is_some()),
            ("rate_s_per_h", self.rate_s_per_h.is_some()),
            ("limit_s", self.limit_s.is_some()),
        ];
        if keys.iter().all(|(_, is_there)| !is_there) {
            return Ok(None);
        }
        let Target::Case(case) = target else {
            let expected = "a table step, ramp, exponential or intermittent for a sensor or an \
                            actuator";
            return refuse(expected, present(&keys));
        };
        let percent = (self.rate_percent_per_h, self.limit_percent);
        let seconds = (self.rate_s_per_h, self.limit_s);
        let (own, other, expected) = if *case == FaultCase::FuelActuatorLag {
            (seconds, percent, "rate_s_per_h, and limit_s or no limit")
        } else {
            let expected = "rate_percent_per_h, and limit_percent or no limit";
            (percent, seconds, expected)
        };
        match (own, other) {
            ((Some(rate_per_h), limit), (None, None)) => {
                Ok(Some(Shape::Ramp(Ramp { rate_per_h, limit })))
            }
            _ => refuse(expected, present(&keys)),
        }
    }

    fn shape(&self, target: &Target) -> Result<Shape, PlantError> {
        let shapes = [
            self.step.map(Shape::Step),
            self.ramp.map(Shape::Ramp),
            self.exponential.map(Shape::Exponential),
            self.intermittent.map(Shape::Intermittent),
            self.flat_ramp(target)?,
        ];
        let mut given = shapes.iter().flatten();
        match (given.next(), given.next()) {
            (Some(shape), None) => Ok(*shape),
            (None, _) if target.mode().is_some_and(|mode| mode.is_switch()) => {
                Ok(Shape::Step(Step { size: 1.0 }))
            }
            _ => refuse(
                "exactly one of step, ramp, exponential, intermittent, or for a case \
                 rate_percent_per_h (rate_s_per_h for fuel_actuator_lag)",
                present(&[
                    ("step", self.step.is_some()),
                    ("ramp", self.ramp.is_some()),
                    ("exponential", self.exponential.is_some()),
                    ("intermittent", self.intermittent.is_some()),
                    ("rate_percent_per_h", self.rate_percent_per_h.is_some()),
                    ("rate_s_per_h", self.rate_s_per_h.is_some()),
                ]),
            ),
        }
    }
}

impl TryFrom<FaultTable> for Fault {
    type Error = PlantError;

    fn try_from(table: FaultTable) -> Result<Self, PlantError> {
        let target = table.target()?;
        Ok(Self {
            target,
            onset_s: table.onset_s,
            end_s: table.end_s,
            shape: table.shape(&target)?,
        })
    }
}

impl From<Fault> for FaultTable {
    fn from(fault: Fault) -> Self {
        let mut table = Self {
            onset_s: fault.onset_s,
            end_s: fault.end_s,
            ..Self::default()
        };
        match fault.target {
            Target::Case(case) => table.case = Some(case),
            Target::Sensor { channel, .. } => table.sensor = Some(channel),
            Target::Actuator { actuator, .. } => table.actuator = Some(actuator),
        }
        if let Some(mode) = fault.target.mode() {
            table.mode = Some(mode.to_string());
            if let Mode::Spike { spikes_per_h } = mode {
                table.spikes_per_h = Some(spikes_per_h);
            }
        }
        match fault.shape {
            Shape::Step(step) => table.step = Some(step),
            Shape::Ramp(ramp) => table.ramp = Some(ramp),
            Shape::Exponential(exponential) => table.exponential = Some(exponential),
            Shape::Intermittent(intermittent) => table.intermittent = Some(intermittent),
        }
        table
    }
}
