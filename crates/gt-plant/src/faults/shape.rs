//! How a fault's magnitude goes with time.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::PlantError;

const SECONDS_PER_HOUR: f64 = 3600.0;

/// Edges are taken this much early, s: sample times `k Ts` carry rounding errors, and an edge that
/// is meant to lie on a sample must not miss it by one.
pub(super) const EDGE_S: f64 = 1e-9;

/// How the magnitude goes with the time since the onset. Sizes are in the unit of the fault's
/// magnitude, see [`Target::unit`](super::Target::unit).
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Shape {
    /// `size` at once.
    Step(Step),
    /// A ramp from zero that may end at a limit.
    Ramp(Ramp),
    /// `size (1 - exp(-t / time_constant))`.
    Exponential(Exponential),
    /// `size` during the first `on_s` of every period.
    Intermittent(Intermittent),
}

/// See [`Shape::Step`].
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Step {
    /// The magnitude.
    pub size: f64,
}

/// See [`Shape::Ramp`].
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Ramp {
    /// How fast the magnitude grows, per hour; negative for one that falls.
    pub rate_per_h: f64,
    /// The absolute value at which it stops; nowhere when absent.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub limit: Option<f64>,
}

/// See [`Shape::Exponential`].
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Exponential {
    /// The magnitude that is approached.
    pub size: f64,
    /// After this time 63 % of it are reached, s.
    pub time_constant_s: f64,
}

/// See [`Shape::Intermittent`].
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Intermittent {
    /// The magnitude while it is on.
    pub size: f64,
    /// Time from one beginning to the next, s.
    pub period_s: f64,
    /// For how long it is on each time, s; shorter than the period.
    pub on_s: f64,
}

impl Shape {
    /// The name, as in a file.
    pub fn name(&self) -> &'static str {
        match self {
            Self::Step(_) => "step",
            Self::Ramp(_) => "ramp",
            Self::Exponential(_) => "exponential",
            Self::Intermittent(_) => "intermittent",
        }
    }

    /// The magnitude `elapsed_s` seconds after the onset; never before it.
    pub fn magnitude(&self, elapsed_s: f64) -> f64 {
        match *self {
            Self::Step(Step { size }) => size,
            Self::Ramp(Ramp { rate_per_h, limit }) => {
                // An infinite time on a zero rate would be NaN, and a falling ramp begins at -0.
                if elapsed_s <= 0.0 || rate_per_h == 0.0 {
                    return 0.0;
                }
                let ramp = rate_per_h * elapsed_s / SECONDS_PER_HOUR;
                limit.map_or(ramp, |limit| ramp.max(-limit).min(limit))
            }
            Self::Exponential(Exponential {
                size,
                time_constant_s,
            }) => -size * (-elapsed_s / time_constant_s).exp_m1(),
            Self::Intermittent(Intermittent {
                size,
                period_s,
                on_s,
            }) => {
                if (elapsed_s + EDGE_S) % period_s < on_s {
                    size
                } else {
                    0.0
                }
            }
        }
    }

    /// The largest absolute magnitude within the first `elapsed_s` seconds, or a bound on it.
    pub fn largest(&self, elapsed_s: f64) -> f64 {
        match *self {
            Self::Ramp(_) => self.magnitude(elapsed_s).abs(),
            Self::Step(Step { size })
            | Self::Exponential(Exponential { size, .. })
            | Self::Intermittent(Intermittent { size, .. }) => size.abs(),
        }
    }

    /// Size or rate: what gives the magnitude its sign.
    pub(super) fn amplitude(&self) -> f64 {
        match *self {
            Self::Ramp(Ramp { rate_per_h, .. }) => rate_per_h,
            Self::Step(Step { size })
            | Self::Exponential(Exponential { size, .. })
            | Self::Intermittent(Intermittent { size, .. }) => size,
        }
    }

    /// Refuses times that make no sense.
    pub(super) fn validate_times(&self) -> Result<(), PlantError> {
        let check = |what, found: f64, holds: bool, expected| {
            if found.is_finite() && holds {
                return Ok(());
            }
            Err(PlantError::Scenario {
                what,
                expected,
                found,
            })
        };
        let positive = "a finite number above 0";
        match *self {
            Self::Step(_) | Self::Ramp(_) => Ok(()),
            Self::Exponential(Exponential {
                time_constant_s: found,
                ..
            }) => check(
                "exponential.time_constant_s of a fault",
                found,
                found > 0.0,
                positive,
            ),
            Self::Intermittent(Intermittent { period_s, on_s, .. }) => {
                check(
                    "intermittent.period_s of a fault",
                    period_s,
                    period_s > 0.0,
                    positive,
                )?;
                check(
                    "intermittent.on_s of a fault",
                    on_s,
                    on_s > 0.0 && on_s < period_s,
                    "a number above 0 and below period_s",
                )
            }
        }
    }
}

#[cfg(test)]
mod tests {
    #![expect(clippy::float_cmp, reason = "these values are exact")]

    use super::*;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn prop_exponential_is_a_first_order_response(
            size in -1e3..1e3f64, time_constant_s in 0.1..1e4f64, t in 0.0..1e4f64, h in 0.0..1e3f64
        ) {
            let shape = Shape::Exponential(Exponential { size, time_constant_s });
            // What is left decays by exp(-h / tau) in every time h.
            let left = |t: f64| size - shape.magnitude(t);
            let expected = left(t) * (-h / time_constant_s).exp();
            prop_assert!((left(t + h) - expected).abs() <= 1e-12 * size.abs());
            prop_assert_eq!(shape.magnitude(0.0), 0.0);
            prop_assert!(shape.magnitude(t).abs() <= shape.largest(t));
        }

        #[test]
        fn prop_intermittent_repeats_and_its_edges_lie_on_samples(
            size in -1e3..1e3f64, on in 1..50u32, off in 1..50u32, k in 0..100_000u32
        ) {
            let period = on + off;
            let shape = Shape::Intermittent(Intermittent {
                size, period_s: f64::from(period) * 0.08, on_s: f64::from(on) * 0.08,
            });
            let expected = if k % period < on { size } else { 0.0 };
            prop_assert_eq!(shape.magnitude(f64::from(k) * 0.08), expected);
        }

        #[test]
        fn prop_ramp_is_linear_then_constant(
            rate in -1e3..1e3f64, limit in 0.0..50.0f64, t in 0.0..1e5f64
        ) {
            let shape = Shape::Ramp(Ramp { rate_per_h: rate, limit: Some(limit) });
            let expected = (rate.abs() * t / 3600.0).min(limit) * rate.signum();
            prop_assert!((shape.magnitude(t) - expected).abs() <= 1e-12 * limit);
            prop_assert!(shape.largest(t) <= limit);
        }
    }

    #[test]
    fn a_step_is_its_size() {
        let shape = Shape::Step(Step { size: -2.5 });
        assert_eq!((shape.magnitude(0.0), shape.magnitude(1e9)), (-2.5, -2.5));
        assert_eq!(shape.largest(1.0), 2.5);
    }
}
