//! What a drive makes of its input's noise, and of lags that are not small.

use gt_core::Dataset;

use super::isolator::Fields;
use super::linear::Tags;
use crate::FdiError;
use crate::design::channels::Channels;
use crate::runtime::Drive;

/// Lags at which the curve of a drive is computed, in seconds.
const LAGS_S: [f64; 12] = [
    0.01, 0.05, 0.1, 0.2, 0.3, 0.45, 0.7, 1.0, 1.5, 2.2, 3.2, 5.0,
];
/// Samples of a healthy record that it is computed from.
const CURVE_SAMPLES: usize = 45_000;

/// An actuator's input with the lag round which its effect is linear, in seconds.
type Actuator<'a> = (&'a str, f64);

/// Energy of a drive a sample when its input is white noise of this deviation.
pub(super) fn noise_energy(
    fields: &Fields,
    tags: &Tags,
    (input, nominal_s): Actuator,
    deviation: f64,
) -> f64 {
    let mut drives = [fields.drive(tags, input, nominal_s)];
    let mut energy = 0.0;
    for u in pulse(fields, tags, input, deviation) {
        energy += products(&mut drives, &u)[0];
    }
    energy
}

/// What is estimated of lags, as if the effect were linear, for the movements of the input in the
/// first healthy record and without what its noise of this deviation adds: the slower actuator
/// leaves out what is fast, so that its effect grows less than its lag.
pub(super) fn lag_curve(
    fields: &Fields,
    tags: &Tags,
    (input, nominal_s): Actuator,
    deviation: f64,
    healthy: &[Dataset],
) -> Result<Vec<[f64; 2]>, FdiError> {
    let Some(data) = healthy.first() else {
        return Err(FdiError::NoHealthyData);
    };
    let drives = || -> Vec<Drive> {
        let lags = [nominal_s].into_iter().chain(LAGS_S);
        lags.map(|lag_s| fields.drive(tags, input, lag_s)).collect()
    };
    let mut sums = vec![0.0; LAGS_S.len() + 1];
    let mut channels = Channels::of(data, fields.sample_time_s, &tags.inputs, &tags.outputs)?;
    let length = data.len().min(CURVE_SAMPLES);
    let mut moved = drives();
    for sample in 0..length {
        let found = products(&mut moved, channels.at(sample).0);
        sums.iter_mut()
            .zip(found)
            .for_each(|(sum, own)| *sum += own);
    }
    let mut shaken = drives();
    for u in pulse(fields, tags, input, deviation) {
        let found = products(&mut shaken, &u);
        let noise = found.into_iter().map(|own| length as f64 * own);
        sums.iter_mut()
            .zip(noise)
            .for_each(|(sum, own)| *sum -= own);
    }
    let mut curve = vec![[0.0, 0.0]];
    for (lag_s, sum) in LAGS_S.iter().zip(&sums[1..]) {
        let estimate = lag_s * sum / sums[0];
        // Beyond where it no longer grows, lags cannot be told apart.
        if !estimate.is_finite() || curve.last().is_some_and(|[last, _]| estimate <= *last) {
            break;
        }
        curve.push([estimate, *lag_s]);
    }
    Ok(curve)
}

/// The inputs of a single pulse of one deviation, as long as a drive answers it: white noise has
/// the energy of that answer. Nothing without a deviation.
fn pulse(fields: &Fields, tags: &Tags, input: &str, deviation: f64) -> Vec<Vec<f64>> {
    if deviation == 0.0 {
        return Vec::new();
    }
    let fill = 2 * fields.half_width + 1;
    let answer = 2 * fields.half_width + 2 * fields.settle_samples() + fields.whitening.order() + 2;
    let one = |sample: usize| {
        let own = tags.inputs.iter();
        own.map(|tag| {
            if sample == fill && tag == input {
                deviation
            } else {
                0.0
            }
        })
        .collect()
    };
    (0..fill + answer).map(one).collect()
}

/// The products of what the first drive says of a sample with what each of them says.
fn products(drives: &mut [Drive], u: &[f64]) -> Vec<f64> {
    let Some((first, others)) = drives.split_first_mut() else {
        return Vec::new();
    };
    let first = first.step(u);
    let dot = |own: &[f64]| own.iter().zip(first).map(|(l, r)| l * r).sum::<f64>();
    let mut found = vec![dot(first)];
    found.extend(others.iter_mut().map(|drive| dot(drive.step(u))));
    found
}
