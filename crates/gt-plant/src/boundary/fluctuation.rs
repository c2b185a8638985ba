//! Fluctuations: Ornstein-Uhlenbeck processes.

use rand_chacha::ChaCha12Rng;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::interval::within;
use crate::random::standard_normal;
use crate::{PlantError, SAMPLE_TIME_S};

/// A normal random process with an exponential correlation, stationary from the first sample on,
/// so that a record is as disturbed at its beginning as later, however long the time constant.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Fluctuation {
    /// Standard deviation, in the unit of the quantity.
    pub deviation: f64,
    /// Time after which the correlation has fallen to 1/e, s.
    pub time_constant_s: f64,
}

impl Fluctuation {
    /// Refuses numbers that make no sense.
    pub(crate) fn validate(
        &self,
        what: &'static str,
        most: f64,
        expected_deviation: &'static str,
        expected_time_constant: &'static str,
    ) -> Result<(), PlantError> {
        within(what, self.deviation, [0.0, most], expected_deviation)?;
        within(
            what,
            self.time_constant_s,
            [SAMPLE_TIME_S, f64::MAX],
            expected_time_constant,
        )
    }
}

/// A fluctuation at the samples, discretised exactly.
#[derive(Debug, Clone)]
pub(crate) struct OrnsteinUhlenbeck {
    decay: f64,
    gain: f64,
    value: f64,
    generator: ChaCha12Rng,
}

impl OrnsteinUhlenbeck {
    /// A fluctuation whose first value has the stationary distribution.
    pub(crate) fn new(fluctuation: Fluctuation, mut generator: ChaCha12Rng) -> Self {
        let Fluctuation {
            deviation,
            time_constant_s,
        } = fluctuation;
        let step = SAMPLE_TIME_S / time_constant_s;
        Self {
            decay: (-step).exp(),
            // sqrt(1 - decay^2) without the cancellation at long time constants.
            gain: deviation * (-(-2.0 * step).exp_m1()).sqrt(),
            value: deviation * standard_normal(&mut generator),
            generator,
        }
    }

    /// The value of the coming sample.
    pub(crate) fn value(&self) -> f64 {
        self.value
    }

    /// Goes on to the next sample.
    pub(crate) fn advance(&mut self) {
        self.value = self.decay * self.value + self.gain * standard_normal(&mut self.generator);
    }
}
