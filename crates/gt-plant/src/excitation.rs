//! Excitation: random levels of valve and speed reference with limited slew, and fuel dither.

use rand::{Rng, RngExt};
use rand_chacha::ChaCha12Rng;
use rand_distr::{Distribution, StandardNormal};
use serde::de::value::MapAccessDeserializer;
use serde::de::{Error, MapAccess, Visitor};
use serde::{Deserialize, Deserializer, Serialize};

use crate::random::{Purpose, stream};
use crate::{PlantError, SAMPLE_TIME_S};

/// How the plant is excited. In a file it is a name of [`Profile::NAMES`] or a table of fields;
/// fields that are left out are those of `standard`.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Profile {
    /// Levels of the valve are uniform within plus or minus this, degrees.
    pub valve_amplitude_deg: f64,
    /// Shortest and longest hold of a level of the valve, s.
    pub valve_hold_s: [f64; 2],
    /// Fastest motion of the valve, deg/s.
    pub valve_slew_deg_s: f64,
    /// Levels of the speed reference are uniform within plus or minus this share of design speed.
    pub speed_amplitude_fraction: f64,
    /// Shortest and longest hold of a level of the speed reference, s.
    pub speed_hold_s: [f64; 2],
    /// Fastest motion of the speed reference, share of design speed a second.
    pub speed_slew_fraction_s: f64,
    /// Stationary standard deviation of the fuel dither, share of the design fuel flow.
    pub dither_fraction: f64,
    /// Both poles of the filter that shapes the dither from white noise.
    pub dither_pole: f64,
}

/// The fields of a profile in a file.
#[derive(Deserialize)]
#[serde(deny_unknown_fields, default = "Profile::default", remote = "Profile")]
struct Fields {
    valve_amplitude_deg: f64,
    valve_hold_s: [f64; 2],
    valve_slew_deg_s: f64,
    speed_amplitude_fraction: f64,
    speed_hold_s: [f64; 2],
    speed_slew_fraction_s: f64,
    dither_fraction: f64,
    dither_pole: f64,
}

impl Profile {
    /// The named profiles, from none to wide.
    pub const NAMES: &[&str] = &["steady", "gentle", "standard", "lively", "wide"];

    /// A profile by name: `steady` excites nothing; `gentle`, `standard`, `lively` and `wide`
    /// move the valve within 0.75, 1.0, 1.5 and 2.5 degrees and the speed reference within 0.5,
    /// 0.67, 1 and 1 percent, and dither the fuel with a standard deviation of 2 percent.
    ///
    /// # Errors
    /// [`PlantError::UnknownName`].
    pub fn named(name: &str) -> Result<Self, PlantError> {
        let (valve_deg, speed_fraction, dither_fraction) = match name {
            "steady" => (0.0, 0.0, 0.0),
            "gentle" => (0.75, 0.005, 0.02),
            "standard" => return Ok(Self::default()),
            "lively" => (1.5, 0.01, 0.02),
            "wide" => (2.5, 0.01, 0.02),
            _ => {
                return Err(PlantError::UnknownName {
                    what: "profile",
                    expected: Self::NAMES,
                    found: name.to_owned(),
                });
            }
        };
        Ok(Self {
            valve_amplitude_deg: valve_deg,
            speed_amplitude_fraction: speed_fraction,
            dither_fraction,
            ..Self::default()
        })
    }

    /// Whether anything moves.
    pub fn excites(&self) -> bool {
        self.valve_amplitude_deg != 0.0
            || self.speed_amplitude_fraction != 0.0
            || self.dither_fraction != 0.0
    }

    /// Refuses numbers that make no sense.
    ///
    /// # Errors
    /// [`PlantError::Scenario`] with the first such number.
    pub fn validate(&self) -> Result<(), PlantError> {
        let within = |what, found: f64, low: f64, high: f64, expected| {
            if found >= low && found <= high {
                Ok(())
            } else {
                Err(PlantError::Scenario {
                    what,
                    expected,
                    found,
                })
            }
        };
        let least = f64::MIN_POSITIVE;
        let at_least_a_sample = "at least one sample time and finite";
        let ordered = "at least the shortest hold and finite";
        let [valve_low, valve_high] = self.valve_hold_s;
        let [speed_low, speed_high] = self.speed_hold_s;
        within(
            "valve_amplitude_deg",
            self.valve_amplitude_deg,
            0.0,
            20.0,
            "between 0 and 20",
        )?;
        within(
            "valve_hold_s",
            valve_low,
            SAMPLE_TIME_S,
            f64::MAX,
            at_least_a_sample,
        )?;
        within("valve_hold_s", valve_high, valve_low, f64::MAX, ordered)?;
        within(
            "valve_slew_deg_s",
            self.valve_slew_deg_s,
            least,
            f64::MAX,
            "above 0 and finite",
        )?;
        within(
            "speed_amplitude_fraction",
            self.speed_amplitude_fraction,
            0.0,
            0.1,
            "between 0 and 0.1",
        )?;
        within(
            "speed_hold_s",
            speed_low,
            SAMPLE_TIME_S,
            f64::MAX,
            at_least_a_sample,
        )?;
        within("speed_hold_s", speed_high, speed_low, f64::MAX, ordered)?;
        within(
            "speed_slew_fraction_s",
            self.speed_slew_fraction_s,
            least,
            f64::MAX,
            "above 0 and finite",
        )?;
        within(
            "dither_fraction",
            self.dither_fraction,
            0.0,
            0.2,
            "between 0 and 0.2",
        )?;
        within(
            "dither_pole",
            self.dither_pole,
            0.0,
            0.999,
            "between 0 and 0.999",
        )
    }
}

impl Default for Profile {
    /// `standard`.
    fn default() -> Self {
        Self {
            valve_amplitude_deg: 1.0,
            valve_hold_s: [3.0, 12.0],
            valve_slew_deg_s: 5.0,
            speed_amplitude_fraction: 0.0067,
            speed_hold_s: [4.0, 15.0],
            speed_slew_fraction_s: 0.01,
            dither_fraction: 0.02,
            dither_pole: 0.97,
        }
    }
}

impl<'de> Deserialize<'de> for Profile {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        struct NameOrFields;

        impl<'de> Visitor<'de> for NameOrFields {
            type Value = Profile;

            fn expecting(&self, formatter: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
                formatter.write_str("the name or the fields of an excitation profile")
            }

            fn visit_str<E: Error>(self, name: &str) -> Result<Profile, E> {
                Profile::named(name).map_err(E::custom)
            }

            fn visit_map<A: MapAccess<'de>>(self, map: A) -> Result<Profile, A::Error> {
                Fields::deserialize(MapAccessDeserializer::new(map))
            }
        }

        deserializer.deserialize_any(NameOrFields)
    }
}

/// Deviations from the design inputs during one sample.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Deviation {
    /// Of the valve angle, degrees.
    pub valve_deg: f64,
    /// Of the speed reference, share of design speed.
    pub speed_fraction: f64,
    /// Fuel dither, share of design fuel flow.
    pub dither_fraction: f64,
}

/// The excitation of one run; it depends on profile, seed and run index only.
#[derive(Debug, Clone)]
pub struct Excitation {
    valve: SteppedLevel,
    speed: SteppedLevel,
    dither: Dither,
}

impl Excitation {
    /// The excitation of the run `run_index` of `seed`, at rest before the first step.
    pub fn new(profile: &Profile, seed: u64, run_index: u64) -> Self {
        let level = |amplitude, hold_s, slew_per_s: f64, purpose| SteppedLevel {
            amplitude,
            hold_s,
            slew: slew_per_s * SAMPLE_TIME_S,
            target: 0.0,
            value: 0.0,
            samples_left: 0,
            generator: stream(seed, run_index, purpose),
        };
        Self {
            valve: level(
                profile.valve_amplitude_deg,
                profile.valve_hold_s,
                profile.valve_slew_deg_s,
                Purpose::Valve,
            ),
            speed: level(
                profile.speed_amplitude_fraction,
                profile.speed_hold_s,
                profile.speed_slew_fraction_s,
                Purpose::Speed,
            ),
            dither: Dither::new(
                profile.dither_fraction,
                profile.dither_pole,
                stream(seed, run_index, Purpose::Dither),
            ),
        }
    }

    /// The deviations of the next sample.
    pub fn step(&mut self) -> Deviation {
        Deviation {
            valve_deg: self.valve.step(),
            speed_fraction: self.speed.step(),
            dither_fraction: self.dither.step(),
        }
    }
}

/// Random levels, each held for a random time, reached with limited slew.
#[derive(Debug, Clone)]
struct SteppedLevel {
    amplitude: f64,
    hold_s: [f64; 2],
    /// Largest change a sample.
    slew: f64,
    target: f64,
    value: f64,
    samples_left: u64,
    generator: ChaCha12Rng,
}

impl SteppedLevel {
    fn step(&mut self) -> f64 {
        if self.samples_left == 0 {
            let [shortest, longest] = self.hold_s;
            let hold_s = shortest + (longest - shortest) * self.generator.random::<f64>();
            self.samples_left = samples(hold_s);
            self.target = self.amplitude * (2.0 * self.generator.random::<f64>() - 1.0);
        }
        self.samples_left -= 1;
        self.value += (self.target - self.value).clamp(-self.slew, self.slew);
        self.value
    }
}

/// A time as a number of samples, at least one; a float cast saturates.
#[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss)]
fn samples(time_s: f64) -> u64 {
    ((time_s / SAMPLE_TIME_S).round() as u64).max(1)
}

/// White noise through two equal poles; it begins at zero, like the plant.
#[derive(Debug, Clone)]
struct Dither {
    gain: f64,
    pole: f64,
    first: f64,
    second: f64,
    generator: ChaCha12Rng,
}

impl Dither {
    fn new(standard_deviation: f64, pole: f64, generator: ChaCha12Rng) -> Self {
        // Variance of white noise of variance 1 behind 1 / (1 - a/z)^2: (1 + a^2) / (1 - a^2)^3.
        let square = pole * pole;
        let gain = standard_deviation * ((1.0 - square).powi(3) / (1.0 + square)).sqrt();
        Self {
            gain,
            pole,
            first: 0.0,
            second: 0.0,
            generator,
        }
    }

    fn step(&mut self) -> f64 {
        self.first = self.pole * self.first + self.gain * standard_normal(&mut self.generator);
        self.second = self.pole * self.second + self.first;
        self.second
    }
}

/// A standard normal number.
pub(crate) fn standard_normal(generator: &mut impl Rng) -> f64 {
    StandardNormal.sample(generator)
}
