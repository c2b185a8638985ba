//! The course of one quantity.

use std::f64::consts::TAU;

use rand_chacha::ChaCha12Rng;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::fluctuation::{Fluctuation, OrnsteinUhlenbeck};
use crate::interval::within;
use crate::{PlantError, SAMPLE_TIME_S};

/// Standard deviations of a fluctuation that the limits of a course allow for.
const DEVIATIONS: f64 = 5.0;

/// The deviation of a quantity from its design value over time: the sum of an offset, a ramp, a
/// sine and a fluctuation, in the unit of the quantity.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct Course {
    /// Constant part.
    pub offset: f64,
    /// Slope of the ramp, which begins at zero, per hour.
    pub rate_per_h: f64,
    /// Sine.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub sine: Option<Sine>,
    /// Random part.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub random: Option<Fluctuation>,
}

/// A sine that begins at zero.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Sine {
    /// Amplitude, in the unit of the quantity; a negative one falls first.
    pub amplitude: f64,
    /// Period, s.
    pub period_s: f64,
}

impl Course {
    /// Whether it moves during a run; an offset does not.
    pub fn moves(&self) -> bool {
        self.rate_per_h != 0.0
            || self.sine.is_some_and(|sine| sine.amplitude != 0.0)
            || self.random.is_some_and(|random| random.deviation != 0.0)
    }

    /// Offset, ramp and sine at a time; the random part has its own state.
    pub fn certain_at(&self, time_s: f64) -> f64 {
        let sine = self.sine.map_or(0.0, |sine| {
            sine.amplitude * (TAU * (time_s / sine.period_s)).sin()
        });
        self.offset + self.rate_per_h * (time_s / 3600.0) + sine
    }

    /// Refuses numbers that make no sense.
    pub(super) fn validate(&self, what: &'static str) -> Result<(), PlantError> {
        let finite = [-f64::MAX, f64::MAX];
        within(what, self.offset, finite, "a finite offset")?;
        within(what, self.rate_per_h, finite, "a finite rate_per_h")?;
        if let Some(Sine {
            amplitude,
            period_s,
        }) = self.sine
        {
            within(what, amplitude, finite, "a finite sine.amplitude")?;
            within(
                what,
                period_s,
                [2.0 * SAMPLE_TIME_S, f64::MAX],
                "a sine.period_s of at least two sample times (0.16 s) and finite",
            )?;
        }
        if let Some(random) = self.random {
            random.validate(
                what,
                f64::MAX,
                "a random.deviation of at least 0 and finite",
                "a random.time_constant_s of at least one sample time (0.08 s) and finite",
            )?;
        }
        Ok(())
    }

    /// Refuses a course around `design` that leaves its limits within `duration_s`.
    pub(super) fn validate_around(
        &self,
        design: f64,
        duration_s: f64,
        what: &'static str,
        limits: [f64; 2],
        expected: &'static str,
    ) -> Result<(), PlantError> {
        if self.offset == 0.0 && !self.moves() {
            return Ok(());
        }
        let ramp = self.rate_per_h * (duration_s / 3600.0);
        let reach = self.sine.map_or(0.0, |sine| sine.amplitude.abs())
            + DEVIATIONS * self.random.map_or(0.0, |random| random.deviation);
        let begin = design + self.offset;
        within(what, begin + ramp.min(0.0) - reach, limits, expected)?;
        within(what, begin + ramp.max(0.0) + reach, limits, expected)
    }
}

/// A course with the state of its random part.
#[derive(Debug, Clone)]
pub(crate) struct CourseValues {
    course: Course,
    random: Option<OrnsteinUhlenbeck>,
}

impl CourseValues {
    pub(crate) fn new(course: Course, generator: ChaCha12Rng) -> Self {
        Self {
            course,
            random: course
                .random
                .map(|random| OrnsteinUhlenbeck::new(random, generator)),
        }
    }

    /// The value of the coming sample, which is at `time_s`.
    pub(crate) fn at(&self, time_s: f64) -> f64 {
        let random = self.random.as_ref().map_or(0.0, OrnsteinUhlenbeck::value);
        self.course.certain_at(time_s) + random
    }

    /// Goes on to the next sample.
    pub(crate) fn advance(&mut self) {
        if let Some(random) = &mut self.random {
            random.advance();
        }
    }
}
