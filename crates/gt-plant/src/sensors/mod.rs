//! The sensors: their noise, their resolution and their faults.

mod deviations;
mod level;
mod noise;
mod reading;

pub use deviations::Deviations;
pub use level::{NoiseLevel, NoiseScale};
pub use noise::{ChannelNoise, Noise};

pub(crate) use deviations::NoiseBasis;
pub(crate) use reading::{Sensor, measure};
