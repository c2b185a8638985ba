//! Streams of random numbers: one for each purpose, from the seed and the run index alone.

use rand::{Rng, SeedableRng};
use rand_chacha::ChaCha12Rng;
use rand_distr::{Distribution, StandardNormal};

/// What a stream is for. Streams never overlap, so that what one consumes changes no other.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Purpose {
    /// Levels and holds of the valve.
    Valve,
    /// Levels and holds of the speed reference.
    Speed,
    /// Fuel dither.
    Dither,
    /// Levels and holds of the fuel.
    Fuel,
    /// Fluctuation of the ambient temperature.
    AmbientTemperature,
    /// Fluctuation of the ambient pressure.
    AmbientPressure,
    /// Fluctuation of the lower heating value.
    HeatingValue,
    /// Disturbance of the heat release.
    HeatRelease,
    /// Disturbing torque on the shaft.
    Torque,
    /// Noise of an input channel.
    InputNoise(usize),
    /// Noise of an output channel.
    OutputNoise(usize),
    /// Spikes or noise of a faulty sensor.
    SensorFault {
        /// Place among all channels.
        channel: usize,
        /// Spikes, or else noise.
        spikes: bool,
        /// How many faults of the same name come before it.
        repeat: u32,
    },
    /// Spikes or noise of a faulty actuator.
    ActuatorFault {
        /// Place among the actuators.
        actuator: usize,
        /// Spikes, or else noise.
        spikes: bool,
        /// How many faults of the same name come before it.
        repeat: u32,
    },
}

/// The stream of a purpose: the key is (seed, run index), the ChaCha stream the purpose.
pub fn stream(seed: u64, run_index: u64, purpose: Purpose) -> ChaCha12Rng {
    let mut key = [0; 32];
    key[..8].copy_from_slice(&seed.to_le_bytes());
    key[8..16].copy_from_slice(&run_index.to_le_bytes());
    let mut generator = ChaCha12Rng::from_seed(key);
    generator.set_stream(match purpose {
        Purpose::Valve => 0,
        Purpose::Speed => 1,
        Purpose::Dither => 2,
        Purpose::Fuel => 3,
        Purpose::AmbientTemperature => 4,
        Purpose::AmbientPressure => 5,
        Purpose::HeatingValue => 6,
        Purpose::HeatRelease => 7,
        Purpose::Torque => 8,
        Purpose::InputNoise(channel) => 1000 + channel as u64,
        Purpose::OutputNoise(channel) => 2000 + channel as u64,
        Purpose::SensorFault {
            channel,
            spikes,
            repeat,
        } => fault_stream(1, channel, spikes, repeat),
        Purpose::ActuatorFault {
            actuator,
            spikes,
            repeat,
        } => fault_stream(2, actuator, spikes, repeat),
    });
    generator
}

/// Two bits of kind, then the place, one bit of spikes and 32 of the repeat.
fn fault_stream(kind: u64, place: usize, spikes: bool, repeat: u32) -> u64 {
    (kind << 62) | ((place as u64) << 33) | (u64::from(spikes) << 32) | u64::from(repeat)
}

/// A standard normal number.
pub fn standard_normal(generator: &mut impl Rng) -> f64 {
    StandardNormal.sample(generator)
}
