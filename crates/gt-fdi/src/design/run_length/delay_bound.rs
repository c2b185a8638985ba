//! A bound on the mean delay of any detector.

use super::normal::{tail, tail_quantile};
use super::{check, check_run_length};
use crate::FdiError;
use crate::runtime::Waveform;

/// The largest delay that is summed, in samples.
const MAX_DELAY: usize = 10_000_000;
/// Terms are positive and fall; where one is below this share of the sum, those after it fall so
/// fast that they change nothing.
const NEGLIGIBLE: f64 = 1e-15;

/// The mean delay, in samples from the first faulty one to the alarm, below which no detector comes
/// that has a constant hazard of false alarm and a mean time of `run_length` samples between them.
///
/// The fault's mean is `size` standard deviations (a step) or rises by `size` standard deviations a
/// sample (a ramp, `size` at the first faulty sample); the bound does not know the sign, so it is
/// one-sided. For detectors with several sides or outputs, multiply `run_length` by their number.
///
/// By Neyman and Pearson's lemma, a test of `m` samples with the probability `a = 1 -
/// exp(-m / run_length)` of a false alarm misses the known fault with at least the probability
/// `Phi(z - d)`, where `a = Phi(-z)` and `d^2` is the sum of the squared means; so does a detector
/// within `m` samples, and the mean delay is `1 + sum_m Phi(z - d)`.
///
/// # Errors
/// [`FdiError::Option`] unless `size` is positive, finite and so large that the delay is below
/// 1e7 samples; [`FdiError::RunLength`] for a `run_length` below 1 or above
/// [`MAX_RUN_LENGTH`](super::MAX_RUN_LENGTH).
pub fn mean_delay_bound(waveform: Waveform, size: f64, run_length: f64) -> Result<f64, FdiError> {
    let expected = "a positive finite number";
    check("size", expected, size, size.is_finite() && size > 0.0)?;
    check_run_length(run_length, 1.0)?;
    let mut sum = 1.0;
    for m in 1..=MAX_DELAY {
        let samples = m as f64;
        let false_alarm = -(-samples / run_length).exp_m1();
        let distance = size * waveform.energy(samples).sqrt();
        let term = tail(distance - tail_quantile(false_alarm));
        sum += term;
        if term <= NEGLIGIBLE * sum {
            return Ok(sum);
        }
    }
    let expected = "a size that is found within 1e7 samples";
    check("size", expected, size, false)?;
    Ok(f64::INFINITY)
}
