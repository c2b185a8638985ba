//! What a fault acts on, and how.

use std::fmt;
use std::str::FromStr;

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::FaultCase;
use crate::PlantError;
use crate::channel::Channel;

/// Spikes an hour where a file says nothing: one a minute.
pub(super) const SPIKES_PER_H: f64 = 60.0;

/// A lag is shorter than this, s: far beyond any record.
const LONGEST_LAG_S: f64 = 1e6;
/// An error of gain is smaller than this, percent.
const LARGEST_GAIN_PERCENT: f64 = 1e6;
/// Every other size is smaller than this, in the unit of its channel: readings stay finite.
const LARGEST_SIZE: f64 = 1e12;

/// What a fault acts on.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Target {
    /// One of the paper's cases.
    Case(FaultCase),
    /// The sensor of a recorded channel: the measured record alone.
    Sensor {
        /// Which channel, input or output.
        channel: Channel,
        /// What is wrong with it.
        mode: Mode,
    },
    /// An actuator: what the plant receives, between its mechanical stops. The record keeps the
    /// demand of fuel and valve; of the guide vanes it holds the position.
    Actuator {
        /// Which actuator.
        actuator: ActuatorId,
        /// What is wrong with it.
        mode: Mode,
    },
}

impl Target {
    /// The name of a fault: the case; or channel and mode, `t3_bias`; or actuator and mode,
    /// `a_v_actuator_lag`.
    pub fn name(&self) -> String {
        match self {
            Self::Case(case) => case.name().to_owned(),
            Self::Sensor { channel, mode } => format!("{channel}_{}", mode.name()),
            Self::Actuator { actuator, mode } => format!("{actuator}_actuator_{}", mode.name()),
        }
    }

    /// Unit of the magnitude; empty for a magnitude that is 0 or 1.
    pub fn unit(&self) -> &'static str {
        let (own, mode) = match self {
            Self::Case(case) => return case.unit(),
            Self::Sensor { channel, mode } => (channel.unit(), mode),
            Self::Actuator { actuator, mode } => (actuator.unit(), mode),
        };
        match mode {
            Mode::Bias | Mode::Drift | Mode::Spike { .. } | Mode::Noise => own,
            Mode::Gain => "%",
            Mode::Stuck | Mode::Dropout => "",
            Mode::Lag => "s",
        }
    }

    /// Whether it changes what the plant does, and not only what the sensors say.
    pub fn reaches_plant(&self) -> bool {
        !matches!(
            self,
            Self::Sensor { .. } | Self::Case(FaultCase::ThermocoupleDrift)
        )
    }

    /// The mode; `None` for a case.
    pub(super) fn mode(&self) -> Option<Mode> {
        match *self {
            Self::Case(_) => None,
            Self::Sensor { mode, .. } | Self::Actuator { mode, .. } => Some(mode),
        }
    }

    /// Whether a negative magnitude makes sense.
    pub(super) fn takes_negative(&self) -> bool {
        match self {
            Self::Case(case) => *case == FaultCase::ThermocoupleDrift,
            Self::Sensor { mode, .. } | Self::Actuator { mode, .. } => matches!(
                mode,
                Mode::Bias | Mode::Drift | Mode::Gain | Mode::Spike { .. }
            ),
        }
    }

    /// A size of this target and its range, in words.
    pub(super) fn size_words(&self) -> (&'static str, &'static str) {
        match self {
            Self::Case(case) if case.unit() == "%" => {
                ("size of a fault [%]", "between -100 and 100")
            }
            Self::Case(_) => ("size of a fault [s]", "below 1e6"),
            Self::Sensor { mode, .. } | Self::Actuator { mode, .. } => match mode {
                Mode::Lag => ("size of a fault [s]", "below 1e6"),
                Mode::Gain => ("size of a fault [%]", "between -1e6 and 1e6"),
                _ => ("size of a fault", "between -1e12 and 1e12"),
            },
        }
    }

    /// A ramp's limit and its range, in words.
    pub(super) fn limit_words(&self) -> (&'static str, &'static str) {
        match self {
            Self::Case(case) if case.unit() == "%" => ("limit of a fault [%]", "below 100"),
            Self::Case(_) => ("limit of a fault [s]", "below 1e6"),
            Self::Sensor { mode, .. } | Self::Actuator { mode, .. } => match mode {
                Mode::Lag => ("limit of a fault [s]", "below 1e6"),
                Mode::Gain => ("limit of a fault [%]", "below 1e6"),
                _ => ("limit of a fault", "below 1e12"),
            },
        }
    }

    /// What a magnitude of this target must stay below.
    pub(super) fn bound(&self) -> f64 {
        let mode = match self {
            Self::Case(case) if case.unit() == "%" => return 100.0,
            Self::Case(_) => return LONGEST_LAG_S,
            Self::Sensor { mode, .. } | Self::Actuator { mode, .. } => mode,
        };
        match mode {
            Mode::Lag => LONGEST_LAG_S,
            Mode::Gain => LARGEST_GAIN_PERCENT,
            _ => LARGEST_SIZE,
        }
    }
}

/// What is wrong with a sensor or an actuator; the magnitude is that of the fault's
/// [`Shape`](super::Shape).
///
/// A sensor is read in this order: the true value, lag, gain, then bias and spikes, noise of the
/// sensor and of the fault, resolution, stuck, dropout. An actuator goes from the demand through
/// gain, then bias, spikes and noise, stuck, to lag. Spikes, noise, stuck and dropout change at
/// samples only; everything else is a continuous function of time.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Mode {
    /// The magnitude is added; in the unit of the channel.
    Bias,
    /// The same effect as [`Mode::Bias`] under the name that a ramp usually has; a name of its own
    /// because it becomes the label of the record.
    Drift,
    /// The reading or the demand is too large by the magnitude; in percent.
    Gain,
    /// It stays where it was; magnitude 1. A sensor repeats its whole reading of the sample at
    /// which it sticks, noise included, so that it is exactly constant. An actuator stays in the
    /// position of the moment before.
    Stuck,
    /// Single samples are off by the magnitude; in the unit of the channel.
    Spike {
        /// How often: each sample of the active fault has the same share of this, independently.
        spikes_per_h: f64,
    },
    /// Nothing arrives; magnitude 1. A sensor reads NaN. An actuator stays in its last position,
    /// which is the effect of [`Mode::Stuck`].
    Dropout,
    /// White normal noise is added, to that of the sensor if any; the magnitude is its standard
    /// deviation in the unit of the channel.
    Noise,
    /// A first-order lag; the magnitude is its time constant in s. A sensor's lag is exact for a
    /// signal that is linear between samples.
    Lag,
}

impl Mode {
    /// The names, as in a file.
    pub const NAMES: &[&str] = &[
        "bias", "drift", "gain", "stuck", "spike", "dropout", "noise", "lag",
    ];

    /// The name, as in a file.
    pub fn name(&self) -> &'static str {
        Self::NAMES[match self {
            Self::Bias => 0,
            Self::Drift => 1,
            Self::Gain => 2,
            Self::Stuck => 3,
            Self::Spike { .. } => 4,
            Self::Dropout => 5,
            Self::Noise => 6,
            Self::Lag => 7,
        }]
    }

    /// Whether the magnitude is 0 or 1 and nothing between.
    pub fn is_switch(&self) -> bool {
        matches!(self, Self::Stuck | Self::Dropout)
    }
}

impl fmt::Display for Mode {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        formatter.pad(self.name())
    }
}

impl FromStr for Mode {
    type Err = PlantError;

    /// The mode of a name; spikes come once a minute.
    fn from_str(name: &str) -> Result<Self, PlantError> {
        Ok(match name {
            "bias" => Self::Bias,
            "drift" => Self::Drift,
            "gain" => Self::Gain,
            "stuck" => Self::Stuck,
            "spike" => Self::Spike {
                spikes_per_h: SPIKES_PER_H,
            },
            "dropout" => Self::Dropout,
            "noise" => Self::Noise,
            "lag" => Self::Lag,
            _ => {
                return Err(PlantError::UnknownName {
                    what: "mode",
                    expected: Self::NAMES,
                    found: name.to_owned(),
                });
            }
        })
    }
}

/// An actuator. In a file it is the name of its demand: `M_f`, `a_v`, `IGV`.
#[derive(
    Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize, JsonSchema,
)]
#[serde(try_from = "String", into = "String")]
pub enum ActuatorId {
    /// The fuel valve, kg/s.
    Fuel,
    /// The pressurising valve, degrees.
    Valve,
    /// The inlet guide vanes, degrees.
    GuideVanes,
}

impl ActuatorId {
    /// All actuators, in the order of [`FaultSizes`](super::FaultSizes).
    pub const ALL: [Self; 3] = [Self::Fuel, Self::Valve, Self::GuideVanes];

    /// The names, in the same order.
    pub const NAMES: &[&str] = &["M_f", "a_v", "IGV"];

    /// The name, as in a file.
    pub fn name(self) -> &'static str {
        Self::NAMES[self.index()]
    }

    /// Unit of demand and position.
    pub fn unit(self) -> &'static str {
        match self {
            Self::Fuel => "kg/s",
            Self::Valve | Self::GuideVanes => "deg",
        }
    }

    /// Place in [`ActuatorId::ALL`].
    pub(super) fn index(self) -> usize {
        match self {
            Self::Fuel => 0,
            Self::Valve => 1,
            Self::GuideVanes => 2,
        }
    }
}

impl fmt::Display for ActuatorId {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        formatter.pad(self.name())
    }
}

impl FromStr for ActuatorId {
    type Err = PlantError;

    fn from_str(name: &str) -> Result<Self, PlantError> {
        Self::ALL
            .into_iter()
            .find(|actuator| actuator.name() == name)
            .ok_or_else(|| PlantError::UnknownName {
                what: "actuator",
                expected: Self::NAMES,
                found: name.to_owned(),
            })
    }
}

impl TryFrom<String> for ActuatorId {
    type Error = PlantError;

    fn try_from(name: String) -> Result<Self, PlantError> {
        name.parse()
    }
}

impl From<ActuatorId> for String {
    fn from(actuator: ActuatorId) -> Self {
        actuator.name().to_owned()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_come_back() {
        for name in Mode::NAMES {
            let mode: Mode = name.parse().unwrap();
            assert_eq!(mode.to_string(), *name);
        }
        for (index, actuator) in ActuatorId::ALL.into_iter().enumerate() {
            assert_eq!(actuator.index(), index);
            assert_eq!(actuator.name().parse(), Ok(actuator));
        }
        assert_eq!(
            "leak".parse::<Mode>().unwrap_err().to_string(),
            "mode: expected one of bias, drift, gain, stuck, spike, dropout, noise, lag, found \
             `leak`"
        );
        assert_eq!(
            "IGW".parse::<ActuatorId>().unwrap_err().to_string(),
            "actuator: expected one of M_f, a_v, IGV, found `IGW`"
        );
    }
}
