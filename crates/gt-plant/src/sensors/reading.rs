//! What a sensor makes of a true value.

use nalgebra::DMatrix;
use rand::RngExt;
use rand_chacha::ChaCha12Rng;

use super::{Noise, NoiseBasis};
use crate::SAMPLE_TIME_S;
use crate::channel::{Channel, ChannelRow};
use crate::excitation::standard_normal;
use crate::faults::{Fault, FaultCase, Mode, Target, repeats, spike_share};
use crate::random::{Purpose, stream};

/// Turns true inputs (nu x N) and outputs (ny x N) at the given times into what the sensors say.
pub(crate) fn measure(
    [u, y]: [&mut DMatrix<f64>; 2],
    faults: &[Fault],
    noise: &Noise,
    basis: &NoiseBasis,
    key: [u64; 2],
    time_s: impl Fn(usize) -> f64,
) {
    for channel in Channel::all() {
        let mut sensor = Sensor::new(channel, faults, noise, basis, key);
        let values = match channel.row() {
            ChannelRow::Input(row) if row < u.nrows() => u.row_mut(row),
            ChannelRow::Output(row) if row < y.nrows() => y.row_mut(row),
            // A channel of the other variant.
            _ => continue,
        };
        if sensor.is_perfect() {
            continue;
        }
        for (k, value) in values.into_iter().enumerate() {
            *value = sensor.read(time_s(k), *value);
        }
    }
}

/// The sensor of one channel; see [`Mode`] for the order of its parts.
#[derive(Debug, Clone)]
pub(crate) struct Sensor {
    channel: Channel,
    effects: Vec<(Effect, Fault)>,
    lag: Option<Lag>,
    noise: Option<Coloured>,
    resolution: f64,
    /// The reading that is held while it is stuck.
    held: Option<f64>,
}

/// What a fault does to a reading.
#[derive(Debug, Clone)]
enum Effect {
    Lag,
    Gain,
    Add,
    Spike { share: f64, generator: ChaCha12Rng },
    Noise { generator: ChaCha12Rng },
    Stuck,
    Dropout,
}

impl Sensor {
    /// The sensor of a channel before its first sample.
    pub fn new(
        channel: Channel,
        faults: &[Fault],
        noise: &Noise,
        basis: &NoiseBasis,
        [seed, run_index]: [u64; 2],
    ) -> Self {
        let effects = effects(channel, faults, [seed, run_index]);
        let deviation = basis.deviation(noise, channel);
        let own = noise.channel(channel);
        let purpose = match channel.row() {
            ChannelRow::Input(row) => Purpose::InputNoise(row),
            ChannelRow::Output(row) => Purpose::OutputNoise(row),
        };
        Self {
            channel,
            lag: lags(&effects).then(Lag::default),
            effects,
            noise: (deviation > 0.0)
                .then(|| Coloured::new(deviation, own.pole, stream(seed, run_index, purpose))),
            resolution: own.resolution,
            held: None,
        }
    }

    /// Whether it reads the truth.
    fn is_perfect(&self) -> bool {
        self.effects.is_empty() && self.noise.is_none() && self.resolution == 0.0
    }

    /// Puts other faults in the place of those that it has; its noise goes on.
    pub fn set_faults(&mut self, faults: &[Fault], key: [u64; 2]) {
        self.effects = effects(self.channel, faults, key);
        if !lags(&self.effects) {
            self.lag = None;
        } else if self.lag.is_none() {
            self.lag = Some(Lag::default());
        }
    }

    /// The reading of a true value; to be called once a sample, in order.
    pub fn read(&mut self, t_s: f64, truth: f64) -> f64 {
        let (mut lag_s, mut gain_error, mut offset, mut extra) = (0.0, 0.0, 0.0, 0.0);
        let (mut stuck, mut lost) = (false, false);
        for (effect, fault) in &mut self.effects {
            let magnitude = fault.magnitude(t_s);
            match effect {
                Effect::Lag => lag_s += magnitude,
                Effect::Gain => gain_error += magnitude / 100.0,
                Effect::Add => offset += magnitude,
                // Drawn whether it is active or not, so that the onset shifts no draw.
                Effect::Spike { share, generator } => {
                    if generator.random::<f64>() < *share {
                        offset += magnitude;
                    }
                }
                Effect::Noise { generator } => extra += magnitude * standard_normal(generator),
                Effect::Stuck => stuck |= magnitude != 0.0,
                Effect::Dropout => lost |= magnitude != 0.0,
            }
        }
        let lagged = match &mut self.lag {
            Some(lag) => lag.step(truth, lag_s),
            None => truth,
        };
        let mut reading = lagged * (1.0 + gain_error) + offset;
        if let Some(noise) = &mut self.noise {
            reading += noise.step();
        }
        reading = quantised(reading + extra, self.resolution);
        if stuck {
            reading = *self.held.get_or_insert(reading);
        } else {
            self.held = None;
        }
        if lost { f64::NAN } else { reading }
    }
}

/// What those of `faults` that are of a channel do to its sensor.
fn effects(
    channel: Channel,
    faults: &[Fault],
    [seed, run_index]: [u64; 2],
) -> Vec<(Effect, Fault)> {
    let effect = |(index, fault): (usize, &Fault)| {
        let mode = match fault.target {
            Target::Sensor { channel: of, mode } if of == channel => mode,
            Target::Case(FaultCase::ThermocoupleDrift) if channel.name() == "t3" => Mode::Gain,
            _ => return None,
        };
        let generator = || {
            let purpose = Purpose::SensorFault {
                channel: channel.index(),
                spikes: matches!(mode, Mode::Spike { .. }),
                repeat: repeats(&faults[..index], fault),
            };
            stream(seed, run_index, purpose)
        };
        let effect = match mode {
            Mode::Bias | Mode::Drift => Effect::Add,
            Mode::Gain => Effect::Gain,
            Mode::Stuck => Effect::Stuck,
            Mode::Spike { spikes_per_h } => Effect::Spike {
                share: spike_share(spikes_per_h),
                generator: generator(),
            },
            Mode::Dropout => Effect::Dropout,
            Mode::Noise => Effect::Noise {
                generator: generator(),
            },
            Mode::Lag => Effect::Lag,
        };
        Some((effect, fault.clone()))
    };
    faults.iter().enumerate().filter_map(effect).collect()
}

/// Whether any of the effects is a lag.
fn lags(effects: &[(Effect, Fault)]) -> bool {
    effects
        .iter()
        .any(|(effect, _)| matches!(effect, Effect::Lag))
}

/// The nearest multiple of a resolution; the value itself where the resolution is 0.
fn quantised(value: f64, resolution: f64) -> f64 {
    if resolution > 0.0 {
        // A resolution far below the value's last digit would overflow; it rounds nothing.
        let multiple = (value / resolution).round() * resolution;
        if multiple.is_finite() {
            multiple
        } else {
            value
        }
    } else {
        value
    }
}

/// A first-order lag, exact for a signal that is linear between samples.
#[derive(Debug, Clone, Default)]
struct Lag {
    /// Value and lagged value of the sample before.
    before: Option<(f64, f64)>,
}

impl Lag {
    /// The lagged value of the next sample under a time constant of `lag_s`; 0 is no lag. It begins
    /// at rest.
    fn step(&mut self, value: f64, lag_s: f64) -> f64 {
        let lagged = match self.before {
            Some((last, lagged)) if lag_s > 0.0 => {
                let decay = (-SAMPLE_TIME_S / lag_s).exp();
                // Share of a slope that is left behind within a sample: lag_s / Ts (1 - decay).
                let behind = lag_s / SAMPLE_TIME_S * -(-SAMPLE_TIME_S / lag_s).exp_m1();
                decay * lagged + (behind - decay) * last + (1.0 - behind) * value
            }
            _ => value,
        };
        self.before = Some((value, lagged));
        lagged
    }
}

/// Normal noise of a given deviation, white or a first-order autoregression; stationary from the
/// first sample on.
#[derive(Debug, Clone)]
struct Coloured {
    deviation: f64,
    pole: f64,
    /// Share of the deviation that is new in a sample.
    fresh: f64,
    last: Option<f64>,
    generator: ChaCha12Rng,
}

impl Coloured {
    fn new(deviation: f64, pole: f64, generator: ChaCha12Rng) -> Self {
        Self {
            deviation,
            pole,
            fresh: (1.0 - pole * pole).sqrt(),
            last: None,
            generator,
        }
    }

    fn step(&mut self) -> f64 {
        let white = self.deviation * standard_normal(&mut self.generator);
        let value = match self.last {
            Some(last) => self.pole * last + self.fresh * white,
            None => white,
        };
        self.last = Some(value);
        value
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        /// Behind a ramp of slope s that begins at rest: s (t - tau (1 - exp(-t / tau))).
        #[test]
        fn prop_lag_follows_a_ramp_exactly(tau in 1e-3..1e3f64, slope in -1e2..1e2f64, n in 1..500u32) {
            let mut lag = Lag::default();
            let mut found = 0.0;
            let time = |k: u32| f64::from(k) * SAMPLE_TIME_S;
            for k in 0..=n {
                found = lag.step(slope * time(k), tau);
            }
            let t = time(n);
            let expected = slope * (t + tau * (-t / tau).exp_m1());
            // Differences of numbers of the size of slope tau.
            prop_assert!((found - expected).abs() < 1e-12 * (slope.abs() * (t + tau) + 1.0));
        }

        /// After a jump at a sample the lagged value decays by exp(-Ts / tau) a sample.
        #[test]
        fn prop_lag_settles_like_a_first_order_system(tau in 1e-2..1e2f64, size in -9.0..9.0f64) {
            let mut lag = Lag::default();
            lag.step(0.0, tau);
            let first = size - lag.step(size, tau);
            for k in 1..100_u32 {
                let left = size - lag.step(size, tau);
                let expected = first * (-f64::from(k) * SAMPLE_TIME_S / tau).exp();
                prop_assert!((left - expected).abs() < 1e-12 * size.abs().max(1.0));
            }
        }

        /// A lag that vanishes leaves the value itself, without a delay.
        #[test]
        fn prop_short_lags_are_none(values in proptest::collection::vec(-1e3..1e3f64, 1..20)) {
            let (mut short, mut none) = (Lag::default(), Lag::default());
            for value in values {
                prop_assert!((short.step(value, 1e-12) - value).abs() < 1e-7);
                prop_assert_eq!(none.step(value, 0.0).to_bits(), value.to_bits());
            }
        }

        #[test]
        fn prop_quantised_is_the_nearest_multiple(value in -1e6..1e6f64, resolution in 1e-3..1e3f64) {
            let reading = quantised(value, resolution);
            prop_assert!((reading - value).abs() <= 0.5 * resolution * (1.0 + 1e-9));
            let multiple = reading / resolution;
            prop_assert!((multiple - multiple.round()).abs() <= 1e-15 * multiple.abs());
            prop_assert_eq!(quantised(value, 0.0).to_bits(), value.to_bits());
            prop_assert_eq!(quantised(value, 5e-324).to_bits(), value.to_bits());
        }
    }
}
