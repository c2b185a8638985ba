//! The faults that are looked for.

use serde::{Deserialize, Serialize};

/// How a fault moves the mean of a residual.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Waveform {
    /// By its size at once, in standard deviations.
    Step,
    /// By its size more with each sample, in standard deviations a sample: by the size itself at
    /// the first faulty sample.
    Ramp,
}

impl Waveform {
    /// Sum of the squared means of the first `samples` faulty samples, for a fault of size 1.
    pub(crate) fn energy(self, samples: f64) -> f64 {
        match self {
            Self::Step => samples,
            Self::Ramp => samples * (samples + 1.0) * (2.0 * samples + 1.0) / 6.0,
        }
    }
}
