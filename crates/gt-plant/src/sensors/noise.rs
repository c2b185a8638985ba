//! Noise and resolution of all sensors.

use std::borrow::Cow;
use std::collections::BTreeMap;
use std::fmt;
use std::str::FromStr;

use schemars::{JsonSchema, Schema, SchemaGenerator, json_schema};
use serde::de::value::MapAccessDeserializer;
use serde::de::{Error, MapAccess, Visitor};
use serde::{Deserialize, Deserializer, Serialize, Serializer};

use super::{NoiseLevel, NoiseScale};
use crate::PlantError;
use crate::channel::Channel;

/// Largest deviation, share and resolution: far beyond any channel, far below what overflows.
const LARGEST: f64 = 1e12;

/// Noise and resolution of the sensors: a level, and channels that differ from it. Every channel
/// draws from a stream of its own, so that a change of one changes no other.
///
/// In a file it is the name of a level or a table:
///
/// ```toml
/// [noise]
/// level = "low"                # none when left out
///
/// [noise.channels.t3]
/// deviation = 0.5              # K
/// pole = 0.9
/// resolution = 0.1             # K
/// ```
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Noise {
    /// The level of all channels that are not named.
    pub level: NoiseLevel,
    /// Inputs and outputs that differ from the level.
    pub channels: BTreeMap<Channel, ChannelNoise>,
}

/// Noise and resolution of one sensor. What is left out is that of the level: white, and exact.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct ChannelNoise {
    /// Standard deviation of the noise in the channel's unit, instead of the level's.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub deviation: Option<f64>,
    /// Standard deviation of the noise as a share of the healthy signal's, instead of the level's;
    /// see [`NoiseScale::SignalShare`].
    #[serde(skip_serializing_if = "Option::is_none")]
    pub share: Option<f64>,
    /// Pole of a first-order autoregression that colours the noise; its standard deviation stays.
    /// 0 is white.
    #[serde(skip_serializing_if = "is_zero")]
    pub pole: f64,
    /// Readings are multiples of this, rounded after the noise, in the channel's unit; 0 is exact.
    #[serde(skip_serializing_if = "is_zero")]
    pub resolution: f64,
}

#[expect(clippy::trivially_copy_pass_by_ref, reason = "serde wants it")]
fn is_zero(value: &f64) -> bool {
    *value == 0.0
}

impl Noise {
    /// The noise of a channel.
    pub fn scale(&self, channel: Channel) -> NoiseScale {
        match self.channel(channel) {
            ChannelNoise {
                deviation: Some(deviation),
                ..
            } => NoiseScale::Unit(deviation),
            ChannelNoise {
                share: Some(share), ..
            } => NoiseScale::SignalShare(share),
            _ => self.level.scale(channel.quantity()),
        }
    }

    /// What a channel has of its own; by default nothing.
    pub fn channel(&self, channel: Channel) -> ChannelNoise {
        self.channels.get(&channel).copied().unwrap_or_default()
    }

    /// Whether any channel's noise is a share of what its signal does.
    pub fn is_share_of_signals(&self) -> bool {
        Channel::all().any(
            |channel| matches!(self.scale(channel), NoiseScale::SignalShare(share) if share > 0.0),
        )
    }

    /// Whether any channel's noise is a share of its value at the design point.
    pub fn is_share_of_design(&self) -> bool {
        Channel::all().any(|channel| matches!(self.scale(channel), NoiseScale::DesignShare(_)))
    }

    /// Refuses numbers that make no sense.
    ///
    /// # Errors
    /// [`PlantError::Noise`] and [`PlantError::NoiseTwice`] with the channel: deviation, share and
    /// resolution lie between 0 and 1e12, the pole lies between -1 and 1, and deviation and
    /// share exclude each other.
    pub fn validate(&self) -> Result<(), PlantError> {
        for (&channel, noise) in &self.channels {
            let check = |option, found: f64, holds: bool, expected| {
                if found.is_finite() && holds {
                    return Ok(());
                }
                Err(PlantError::Noise {
                    channel,
                    option,
                    expected,
                    found,
                })
            };
            let small = "a number from 0 to 1e12";
            for (option, found) in [
                ("deviation", noise.deviation.unwrap_or(0.0)),
                ("share", noise.share.unwrap_or(0.0)),
                ("resolution", noise.resolution),
            ] {
                check(option, found, (0.0..=LARGEST).contains(&found), small)?;
            }
            let inside = noise.pole.abs() < 1.0;
            check("pole", noise.pole, inside, "a number between -1 and 1")?;
            if noise.deviation.is_some() && noise.share.is_some() {
                return Err(PlantError::NoiseTwice { channel });
            }
        }
        Ok(())
    }
}

impl From<NoiseLevel> for Noise {
    fn from(level: NoiseLevel) -> Self {
        Self {
            level,
            channels: BTreeMap::new(),
        }
    }
}

impl FromStr for Noise {
    type Err = PlantError;

    /// The noise of a level's name.
    fn from_str(name: &str) -> Result<Self, PlantError> {
        name.parse().map(NoiseLevel::into)
    }
}

/// The keys of the table.
#[derive(Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
struct Fields {
    #[serde(default)]
    level: NoiseLevel,
    #[serde(default)]
    channels: BTreeMap<Channel, ChannelNoise>,
}

impl Serialize for Noise {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        if self.channels.is_empty() {
            return self.level.serialize(serializer);
        }
        Fields {
            level: self.level,
            channels: self.channels.clone(),
        }
        .serialize(serializer)
    }
}

impl JsonSchema for Noise {
    fn schema_name() -> Cow<'static, str> {
        "Noise".into()
    }

    /// A name or a table.
    fn json_schema(generator: &mut SchemaGenerator) -> Schema {
        let level = generator.subschema_for::<NoiseLevel>();
        let fields = generator.subschema_for::<Fields>();
        json_schema!({"description": "Sensor noise.", "anyOf": [level, fields]})
    }
}

impl<'de> Deserialize<'de> for Noise {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        struct NameOrFields;

        impl<'de> Visitor<'de> for NameOrFields {
            type Value = Noise;

            fn expecting(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
                formatter.write_str("the name of a noise level or a table with level and channels")
            }

            fn visit_str<E: Error>(self, name: &str) -> Result<Noise, E> {
                name.parse().map_err(E::custom)
            }

            fn visit_map<A: MapAccess<'de>>(self, map: A) -> Result<Noise, A::Error> {
                let Fields { level, channels } =
                    Fields::deserialize(MapAccessDeserializer::new(map))?;
                Ok(Noise { level, channels })
            }
        }

        deserializer.deserialize_any(NameOrFields)
    }
}
