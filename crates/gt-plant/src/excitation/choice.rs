//! A profile as a file gives it: a name or a table of fields, either of which means something for
//! one variant only.

use schemars::JsonSchema;
use serde::de::value::MapAccessDeserializer;
use serde::de::{Error, MapAccess, Visitor};
use serde::{Deserialize, Deserializer};

use super::profile::Profile;
use crate::{PlantError, Variant};

/// A name of [`Profile::names`], or fields that replace those of `standard`.
#[derive(Debug, Clone, JsonSchema)]
#[schemars(untagged)]
pub(crate) enum ProfileChoice {
    Name(String),
    Fields(Box<Fields>),
}

/// The fields of a profile in a file.
#[derive(Debug, Clone, Default, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub(crate) struct Fields {
    valve_amplitude_deg: Given<f64>,
    valve_hold_s: Given<[f64; 2]>,
    valve_slew_deg_s: Given<f64>,
    speed_amplitude_fraction: Given<f64>,
    speed_hold_s: Given<[f64; 2]>,
    speed_slew_fraction_s: Given<f64>,
    fuel_amplitude_fraction: Given<f64>,
    fuel_hold_s: Given<[f64; 2]>,
    fuel_slew_fraction_s: Given<f64>,
    fuel_schedule: Given<Vec<[f64; 2]>>,
    dither_fraction: Given<f64>,
    dither_pole: Given<f64>,
}

impl ProfileChoice {
    /// The profile that the choice means for a variant.
    ///
    /// # Errors
    /// [`PlantError::UnknownName`].
    pub(crate) fn resolve(self, variant: Variant) -> Result<Profile, PlantError> {
        let fields = match self {
            Self::Name(name) => return Profile::named(variant, &name),
            Self::Fields(fields) => *fields,
        };
        let standard = Profile::standard(variant);
        Ok(Profile {
            valve_amplitude_deg: fields.valve_amplitude_deg.or(standard.valve_amplitude_deg),
            valve_hold_s: fields.valve_hold_s.or(standard.valve_hold_s),
            valve_slew_deg_s: fields.valve_slew_deg_s.or(standard.valve_slew_deg_s),
            speed_amplitude_fraction: fields
                .speed_amplitude_fraction
                .or(standard.speed_amplitude_fraction),
            speed_hold_s: fields.speed_hold_s.or(standard.speed_hold_s),
            speed_slew_fraction_s: fields
                .speed_slew_fraction_s
                .or(standard.speed_slew_fraction_s),
            fuel_amplitude_fraction: fields
                .fuel_amplitude_fraction
                .or(standard.fuel_amplitude_fraction),
            fuel_hold_s: fields.fuel_hold_s.or(standard.fuel_hold_s),
            fuel_slew_fraction_s: fields
                .fuel_slew_fraction_s
                .or(standard.fuel_slew_fraction_s),
            fuel_schedule: fields.fuel_schedule.or(standard.fuel_schedule),
            dither_fraction: fields.dither_fraction.or(standard.dither_fraction),
            dither_pole: fields.dither_pole.or(standard.dither_pole),
        })
    }
}

impl Default for ProfileChoice {
    /// `standard`.
    fn default() -> Self {
        Self::Fields(Box::default())
    }
}

impl<'de> Deserialize<'de> for ProfileChoice {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        struct NameOrFields;

        impl<'de> Visitor<'de> for NameOrFields {
            type Value = ProfileChoice;

            fn expecting(&self, formatter: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
                formatter.write_str("the name or the fields of an excitation profile")
            }

            fn visit_str<E: Error>(self, name: &str) -> Result<ProfileChoice, E> {
                Ok(ProfileChoice::Name(name.to_owned()))
            }

            fn visit_map<A: MapAccess<'de>>(self, map: A) -> Result<ProfileChoice, A::Error> {
                let fields = Fields::deserialize(MapAccessDeserializer::new(map))?;
                Ok(ProfileChoice::Fields(Box::new(fields)))
            }
        }

        deserializer.deserialize_any(NameOrFields)
    }
}

/// A field that may be left out, but not be null.
#[derive(Debug, Clone, Copy, JsonSchema)]
struct Given<T>(Option<T>);

impl<T> Given<T> {
    fn or(self, standard: T) -> T {
        self.0.unwrap_or(standard)
    }
}

impl<T> Default for Given<T> {
    fn default() -> Self {
        Self(None)
    }
}

impl<'de, T: Deserialize<'de>> Deserialize<'de> for Given<T> {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        T::deserialize(deserializer).map(|value| Self(Some(value)))
    }
}
