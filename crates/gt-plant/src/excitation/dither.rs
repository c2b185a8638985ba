//! Dither: coloured noise on the fuel.

use rand_chacha::ChaCha12Rng;

use crate::random::standard_normal;

/// White noise through two equal poles; it begins at zero, like the plant.
#[derive(Debug, Clone)]
pub(crate) struct Dither {
    gain: f64,
    pole: f64,
    first: f64,
    second: f64,
    generator: ChaCha12Rng,
}

impl Dither {
    /// Dither of the given stationary standard deviation.
    pub(crate) fn new(standard_deviation: f64, pole: f64, generator: ChaCha12Rng) -> Self {
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

    /// The value of the next sample.
    pub(crate) fn step(&mut self) -> f64 {
        self.first = self.pole * self.first + self.gain * standard_normal(&mut self.generator);
        self.second = self.pole * self.second + self.first;
        self.second
    }
}
