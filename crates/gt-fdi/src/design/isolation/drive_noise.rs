//! What a drive makes of its input's noise, and what smoothing its rate takes from it.

use std::collections::VecDeque;

use gt_core::Dataset;

use super::isolator::{DriveNoise, Fields, LagNoise};
use super::linear::Tags;
use crate::FdiError;
use crate::design::channels::Channels;
use crate::runtime::{Drive, LAGS};

/// Samples of a healthy record that gains are computed from.
const GAIN_SAMPLES: usize = 45_000;
/// Samples on either side for a rate that is as good as not smoothed.
pub(super) const SHARP: usize = 1;

/// An actuator's input with the lag round which its effect is linear, in seconds, and the standard
/// deviation of the input's noise.
#[derive(Debug, Clone, Copy)]
pub(super) struct Actuator<'a> {
    pub(super) input: &'a str,
    pub(super) nominal_s: f64,
    pub(super) deviation: f64,
}

/// What its own noise gives a drive, round its nominal lag and each of those tried, with offsets of
/// zero; gains are those of the movements of the first healthy record.
pub(super) fn drive_noise(
    fields: &Fields,
    tags: &Tags,
    actuator: Actuator,
    healthy: &[Dataset],
) -> Result<DriveNoise, FdiError> {
    let Some(data) = healthy.first() else {
        return Err(FdiError::NoHealthyData);
    };
    let pulse = pulse(fields, tags, actuator);
    let own = Sums::of(fields, tags, actuator, pulse.iter().map(Vec::as_slice));
    let mut channels = Channels::of(data, fields.sample_time_s, &tags.inputs, &tags.outputs)?;
    let length = data.len().min(GAIN_SAMPLES);
    let inputs: Vec<Vec<f64>> = (0..length)
        .map(|sample| channels.at(sample).0.to_vec())
        .collect();
    let moved = Sums::of(fields, tags, actuator, inputs.iter().map(Vec::as_slice));
    let lags = (1..=LAGS.len()).map(|lag| {
        let noise = length as f64;
        let sharp = moved.sharp[lag] - noise * own.sharp[lag];
        let smooth = moved.smooth[lag] - noise * own.smooth[lag];
        let gain = sharp / smooth;
        LagNoise {
            offset: 0.0,
            floor: own.smooth[lag],
            // Where the input does not move more than its noise, nothing is known.
            gain: if gain.is_finite() && gain > 0.0 {
                gain
            } else {
                1.0
            },
        }
    });
    Ok(DriveNoise {
        offset: 0.0,
        floor: own.smooth[0],
        lags: lags.collect(),
    })
}

/// Sums over a series of inputs of the products of a drive with itself, and with one whose rate is
/// hardly smoothed, round each lag.
struct Sums {
    smooth: Vec<f64>,
    sharp: Vec<f64>,
}

impl Sums {
    fn of<'a>(
        fields: &Fields,
        tags: &Tags,
        actuator: Actuator,
        inputs: impl Iterator<Item = &'a [f64]>,
    ) -> Self {
        let drive =
            |half_width: usize| fields.drive(tags, actuator.input, actuator.nominal_s, half_width);
        let smoothed = fields.half_width > SHARP;
        let (mut smooth, mut sharp) = (drive(fields.half_width), drive(SHARP));
        let mut late: VecDeque<Vec<f64>> = VecDeque::new();
        let mut sums = Self {
            smooth: vec![0.0; LAGS.len() + 1],
            sharp: vec![0.0; LAGS.len() + 1],
        };
        for u in inputs {
            smooth.step(u);
            // The answer to a smooth rate comes later.
            late.push_back(u.to_vec());
            if late.len() > fields.half_width.saturating_sub(SHARP)
                && let Some(u) = late.pop_front()
            {
                sharp.step(&u);
            }
            let dot = |other: &Drive, lag: usize| -> f64 {
                let pairs = smooth.change(lag).iter().zip(other.change(lag));
                pairs.map(|(left, right)| left * right).sum()
            };
            for lag in 0..=LAGS.len() {
                sums.smooth[lag] += dot(&smooth, lag);
                sums.sharp[lag] += dot(if smoothed { &sharp } else { &smooth }, lag);
            }
        }
        sums
    }
}

/// The inputs of a single pulse of one deviation, as long as a drive answers it: white noise has
/// the energy of that answer. Nothing without a deviation.
fn pulse(fields: &Fields, tags: &Tags, actuator: Actuator) -> Vec<Vec<f64>> {
    if actuator.deviation == 0.0 {
        return Vec::new();
    }
    let fill = 2 * fields.half_width + 1;
    // The slowest lag has settled to 1e-6 in 14 of its time constants.
    #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)] // a thousand or so
    let lag = LAGS
        .iter()
        .fold(0.0, |slowest: f64, own| slowest.max(14.0 * own)) as usize;
    let answer =
        2 * fields.half_width + 2 * fields.settle_samples() + fields.whitening.order() + lag;
    let one = |sample: usize| {
        let own = tags.inputs.iter();
        own.map(|tag| {
            if sample == fill && tag == actuator.input {
                actuator.deviation
            } else {
                0.0
            }
        })
        .collect()
    };
    (0..fill + answer).map(one).collect()
}
