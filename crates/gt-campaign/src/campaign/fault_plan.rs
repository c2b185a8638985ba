//! Which faults a campaign draws.

use std::fmt;

use gtfdi::plant::{Exponential, Fault, FaultCase, Intermittent, Ramp, Shape, Step, Target};
use schemars::{JsonSchema, Schema, SchemaGenerator, json_schema};
use serde::de::{Error, Unexpected, Visitor};
use serde::{Deserialize, Deserializer, Serialize, Serializer};

/// Seconds of an hour, in which the plant counts its ramps.
const HOUR_S: f64 = 3600.0;

/// A fault with the range of its size.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct FaultPlan {
    /// Which of the plant's cases, by its number or its name.
    #[serde(deserialize_with = "case", serialize_with = "case_name")]
    #[schemars(schema_with = "case_schema")]
    pub case: FaultCase,
    /// The range of its size, in the case's unit.
    pub size: SizeRange,
    /// Its sign; only the thermocouple of case 2 drifts both ways.
    #[serde(default)]
    pub sign: Sign,
    /// How it goes with time.
    #[serde(default)]
    pub shape: FaultShape,
}

/// A range with the distribution within it.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum SizeRange {
    /// Every size is as likely as any other.
    Uniform([f64; 2]),
    /// Every ratio is as likely as any other.
    LogUniform([f64; 2]),
}

/// The sign of a fault.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum Sign {
    /// As the size.
    #[default]
    Positive,
    /// Against it.
    Negative,
    /// One or the other, as likely.
    Both,
}

/// How a fault goes with time.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case", deny_unknown_fields)]
pub enum FaultShape {
    /// Its size at once.
    #[default]
    Step,
    /// A straight line from zero to its size, which it then holds.
    Ramp {
        /// When it is there after the onset, in seconds.
        rise_s: f64,
    },
    /// `size (1 - exp(-t / time_constant))`.
    Exponential {
        /// After this time 63 % are reached, in seconds.
        time_constant_s: f64,
    },
    /// Its size during the first `on_s` of every period.
    Intermittent {
        /// From one beginning to the next, in seconds.
        period_s: f64,
        /// For how long it is on each time, in seconds.
        on_s: f64,
    },
}

impl SizeRange {
    /// The smallest and the largest size.
    pub fn ends(&self) -> [f64; 2] {
        match *self {
            Self::Uniform(ends) | Self::LogUniform(ends) => ends,
        }
    }

    /// The size below which a share of the sizes lies.
    pub fn at(&self, share: f64) -> f64 {
        let [low, high] = self.ends();
        let size = match self {
            Self::Uniform(_) => low + share * (high - low),
            Self::LogUniform(_) => low * (share * (high / low).ln()).exp(),
        };
        size.clamp(low, high)
    }
}

impl FaultShape {
    /// The name, as in a file.
    pub fn name(&self) -> &'static str {
        match self {
            Self::Step => "step",
            Self::Ramp { .. } => "ramp",
            Self::Exponential { .. } => "exponential",
            Self::Intermittent { .. } => "intermittent",
        }
    }

    /// The plant's shape with a size.
    fn with(&self, size: f64) -> Shape {
        match *self {
            Self::Step => Shape::Step(Step { size }),
            Self::Ramp { rise_s } => Shape::Ramp(Ramp {
                rate_per_h: size / rise_s * HOUR_S,
                limit: Some(size.abs()),
            }),
            Self::Exponential { time_constant_s } => Shape::Exponential(Exponential {
                size,
                time_constant_s,
            }),
            Self::Intermittent { period_s, on_s } => Shape::Intermittent(Intermittent {
                size,
                period_s,
                on_s,
            }),
        }
    }
}

impl FaultPlan {
    /// The plant's fault of a size with its sign.
    pub fn fault(&self, onset_s: f64, signed_size: f64) -> Fault {
        Fault::new(
            Target::Case(self.case),
            onset_s,
            self.shape.with(signed_size),
        )
    }
}

/// Reads a case by its number or its name.
fn case<'de, D: Deserializer<'de>>(from: D) -> Result<FaultCase, D::Error> {
    struct NumberOrName;

    impl Visitor<'_> for NumberOrName {
        type Value = FaultCase;

        fn expecting(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
            write!(
                formatter,
                "a case from 1 to 4 or one of {}",
                FaultCase::NAMES.join(", ")
            )
        }

        fn visit_i64<E: Error>(self, number: i64) -> Result<FaultCase, E> {
            let place = usize::try_from(number)
                .ok()
                .and_then(|number| number.checked_sub(1));
            let case = place.and_then(|place| FaultCase::ALL.get(place).copied());
            case.ok_or_else(|| E::invalid_value(Unexpected::Signed(number), &self))
        }

        fn visit_str<E: Error>(self, name: &str) -> Result<FaultCase, E> {
            name.parse()
                .map_err(|_| E::invalid_value(Unexpected::Str(name), &self))
        }
    }

    from.deserialize_any(NumberOrName)
}

/// A number or a name.
fn case_schema(_: &mut SchemaGenerator) -> Schema {
    let last = FaultCase::ALL.len();
    json_schema!({
        "anyOf": [{"type": "integer", "minimum": 1, "maximum": last}, {"enum": FaultCase::NAMES}]
    })
}

#[expect(
    clippy::trivially_copy_pass_by_ref,
    reason = "the signature that serde calls"
)]
fn case_name<S: Serializer>(case: &FaultCase, to: S) -> Result<S::Ok, S::Error> {
    to.serialize_str(case.name())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sizes_keep_their_range_and_spacing() {
        let even = SizeRange::Uniform([1.0, 3.0]);
        let ratio = SizeRange::LogUniform([0.1, 10.0]);
        // A logarithm and an exponential.
        let close = |found: f64, expected: f64| (found - expected).abs() < 1e-14 * expected;
        assert!(close(even.at(0.5), 2.0) && close(ratio.at(0.5), 1.0));
        for range in [even, ratio] {
            let [low, high] = range.ends();
            assert!(close(range.at(0.0), low) && close(range.at(1.0), high));
            assert!((0..=1000).all(|k| (low..=high).contains(&range.at(f64::from(k) / 1000.0))));
        }
    }

    #[test]
    fn a_ramp_holds_what_it_reaches_and_keeps_its_sign() {
        let plan = FaultPlan {
            case: FaultCase::ThermocoupleDrift,
            size: SizeRange::Uniform([0.1, 0.2]),
            sign: Sign::Both,
            shape: FaultShape::Ramp { rise_s: 20.0 },
        };
        let fault = plan.fault(10.0, -0.15);
        for (time_s, magnitude) in [(10.0, 0.0), (20.0, -0.075), (30.0, -0.15), (90.0, -0.15)] {
            let found = fault.magnitude(time_s);
            // A quotient by and a product with 3600.
            assert!((found - magnitude).abs() < 1e-15, "{time_s} s: {found}");
        }
    }
}
