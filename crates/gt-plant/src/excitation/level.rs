//! Random levels, each held for a random time, reached with limited slew.

use rand::RngExt;
use rand_chacha::ChaCha12Rng;

use crate::SAMPLE_TIME_S;

/// A signal that moves between random levels; it begins at zero.
#[derive(Debug, Clone)]
pub(crate) struct SteppedLevel {
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
    /// Levels uniform within plus or minus `amplitude`, held for a time uniform between the two of
    /// `hold_s`.
    pub(crate) fn new(
        amplitude: f64,
        hold_s: [f64; 2],
        slew_per_s: f64,
        generator: ChaCha12Rng,
    ) -> Self {
        Self {
            amplitude,
            hold_s,
            slew: slew_per_s * SAMPLE_TIME_S,
            target: 0.0,
            value: 0.0,
            samples_left: 0,
            generator,
        }
    }

    /// The value of the next sample.
    pub(crate) fn step(&mut self) -> f64 {
        if self.samples_left == 0 {
            let [shortest, longest] = self.hold_s;
            let hold_s = shortest + (longest - shortest) * self.generator.random::<f64>();
            self.samples_left = samples(hold_s);
            self.target = self.amplitude * (2.0 * self.generator.random::<f64>() - 1.0);
        }
        self.samples_left -= 1;
        // `clamp` would panic at a slew that no scenario accepts.
        self.value += (self.target - self.value).max(-self.slew).min(self.slew);
        self.value
    }
}

/// A time as a number of samples, at least one; a float cast saturates.
#[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss)]
fn samples(time_s: f64) -> u64 {
    ((time_s / SAMPLE_TIME_S).round() as u64).max(1)
}
