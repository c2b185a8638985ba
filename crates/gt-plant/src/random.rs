//! Streams of random numbers: one for each purpose, from the seed and the run index alone.

use rand::SeedableRng;
use rand_chacha::ChaCha12Rng;

/// What a stream is for. Streams never overlap, so that what one consumes changes no other.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Purpose {
    /// Levels and holds of the valve.
    Valve,
    /// Levels and holds of the speed reference.
    Speed,
    /// Fuel dither.
    Dither,
    /// Noise of an input channel.
    InputNoise(usize),
    /// Noise of an output channel.
    OutputNoise(usize),
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
        Purpose::InputNoise(channel) => 1000 + channel as u64,
        Purpose::OutputNoise(channel) => 2000 + channel as u64,
    });
    generator
}
