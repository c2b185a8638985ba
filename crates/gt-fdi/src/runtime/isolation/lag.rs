//! How large a lag is.

use alloc::boxed::Box;

use super::core::DriveSums;
use super::profile::Profile;
use super::recall;
use super::suffix::Suffixes;

/// Lags tried, in multiples of the sample time: each twice the one before.
pub(crate) const LAGS: [f64; 9] = [0.25, 0.5, 1.0, 2.0, 4.0, 8.0, 16.0, 32.0, 64.0];
/// Least share of a drive's energy that counts as more than noise.
pub(super) const LEAST_REAL: f64 = 0.25;
/// Least slope that a crossing is taken to have.
const LEAST_SLOPE: f64 = 0.1;

/// What is known of a drive round one lag.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct LagParts {
    /// The lag in seconds.
    pub(crate) lag_s: f64,
    /// Healthy mean of the agreement with the residuals, a sample.
    pub(crate) offset: f64,
    /// Energy of the drive that is its own noise's, a sample.
    pub(crate) floor: f64,
    /// What the drive would agree with itself if its rate were not smoothed, over its energy.
    pub(crate) gain: f64,
}

/// The lag of an actuator by the residuals as they are, and its variance, for a profile of growth.
///
/// Round each lag of the bank the effect is taken as linear, which gives an estimate each; the lag
/// is where estimate and lag agree: a slower actuator leaves out what is fast, so an estimate round
/// a smaller lag is too small, and the reverse.
pub(super) fn size(
    bank: &[LagParts],
    sums: &Suffixes,
    at: DriveSums,
    profile: &Profile,
    scale: f64,
) -> (f64, f64) {
    let growth = profile.growth(sums);
    let (sum, own) = (profile.sum(sums), profile.own_energy(sums));
    let estimate = |index: usize, parts: &LagParts| {
        let [agreement, energy] = at.lag(index);
        let agreement = profile.weighted(sums, agreement) - parts.offset * sum;
        let (energy, noise) = (profile.energy(sums, energy), parts.floor * own);
        let real = parts.gain * (energy - noise).max(LEAST_REAL * energy);
        let variance = scale * (energy + noise) / (real * real);
        (growth * agreement / real, growth * growth * variance)
    };
    let mut before: Option<(f64, f64)> = None;
    let mut found = (0.0, 0.0);
    for (index, parts) in bank.iter().enumerate() {
        let (size, variance) = estimate(index, parts);
        if !size.is_finite() {
            continue;
        }
        found = (size.max(0.0), variance);
        if size <= 0.0 {
            break;
        }
        // By how much the estimate is above the lag, as logarithms.
        let (place, above) = (libm::log(parts.lag_s), libm::log(size / parts.lag_s));
        if above <= 0.0 {
            if let Some((last_place, last_above)) = before {
                let share = last_above / (last_above - above);
                let lag_s = libm::exp(last_place + share * (place - last_place));
                let slope = (last_above - above) / (place - last_place);
                let stretch = lag_s / size / slope.max(LEAST_SLOPE);
                found = (lag_s, variance * stretch * stretch);
            }
            break;
        }
        before = Some((place, above));
    }
    found
}

/// A first-order lag of every entry of a vector.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct LagFilter {
    pole: f64,
    state: Box<[f64]>,
}

impl LagFilter {
    pub(super) fn new(lag_s: f64, sample_time_s: f64, size: usize) -> Self {
        let pole = if lag_s > 0.0 {
            libm::exp(-sample_time_s / lag_s)
        } else {
            0.0
        };
        Self {
            pole,
            state: alloc::vec![0.0; size].into(),
        }
    }

    pub(super) fn step(&mut self, values: &[f64]) {
        for (state, value) in self.state.iter_mut().zip(values) {
            *state = self.pole * *state + (1.0 - self.pole) * value;
        }
    }

    pub(super) fn state(&self) -> &[f64] {
        &self.state
    }

    pub(super) fn reset(&mut self) {
        self.state.fill(0.0);
    }

    pub(super) fn recall(&mut self, visit: &mut dyn FnMut(&mut f64)) {
        recall::numbers(&mut self.state, visit);
    }
}
