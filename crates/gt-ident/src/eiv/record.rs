//! A record made ready: channels without mean, of unit deviation, and their spectrum.

use gt_core::{Dataset, DimensionError, OperatingPoint};
use nalgebra::DMatrix;

use super::autoregression::{Autoregression, NOISE_FLOOR};
use super::spectrum::Spectrum;
use crate::IdentError;
use crate::regressor::check_varies;

/// Longest autoregression that is chosen by itself.
const LONGEST: usize = 60;
/// The autoregression behind the information is this much longer than `sqrt(N) / 3`.
const SHORTEST: usize = 4;

/// The spectrum of a record, with what brings an estimate back to its units.
pub(super) struct Record {
    pub spectrum: Spectrum,
    /// Of a shorter autoregression, for the information: it is quadratic in the spectrum of the
    /// inputs, so that the scatter of a long one would pass for information.
    pub smooth: Spectrum,
    pub point: OperatingPoint,
    /// Deviation of each channel, outputs before inputs.
    pub scales: Vec<f64>,
    pub samples: usize,
    pub order: usize,
}

/// The autoregression order for a model of order `n` of `q` channels over `samples`:
/// `max(2 n, min(60, N / (8 q)))`. Too short an autoregression biases slow poles, a long one costs
/// little.
pub(super) fn autoregression_order(n: usize, q: usize, samples: usize) -> usize {
    n.saturating_mul(2).max((samples / (8 * q)).min(LONGEST))
}

impl Record {
    /// The spectrum of `data` from an autoregression of the given order at `frequencies`.
    ///
    /// # Errors
    /// As [`super::Eiv::fit`].
    pub fn new(data: &Dataset, order: usize, frequencies: usize) -> Result<Self, IdentError> {
        let (ny, nu, samples) = (data.ny(), data.nu(), data.len());
        let q = ny + nu;
        if ny == 0 {
            return Err(IdentError::NoOutputs);
        }
        if nu == 0 {
            return Err(IdentError::NoInputs);
        }
        Self::check_length(samples, q, order)?;
        data.check_finite()?;
        let signals = || data.outputs().iter().chain(data.inputs());
        let source = |channel: usize| match channel.checked_sub(ny) {
            None => data.y().row(channel),
            Some(input) => data.u().row(input),
        };
        let point = data.mean();
        let mut z = DMatrix::zeros(samples, q);
        let mut scales = Vec::with_capacity(q);
        for (channel, signal) in signals().enumerate() {
            let row = source(channel);
            check_varies(signal, row.iter().copied())?;
            let mean = match channel.checked_sub(ny) {
                None => point.y[channel],
                Some(input) => point.u[input],
            };
            let mut column = z.column_mut(channel);
            for (out, value) in column.iter_mut().zip(row.iter()) {
                *out = value - mean;
            }
            let scale = column.norm() / (samples as f64).sqrt();
            if !(scale.is_normal()) {
                return Err(IdentError::EivScale {
                    channel: signal.name.clone(),
                    found: scale,
                });
            }
            column /= scale;
            scales.push(scale);
        }
        let spectrum = |order: usize| {
            let fitted = Autoregression::fit(&z, order).map_err(|(channel, found)| {
                let signal = signals().nth(channel);
                IdentError::EivDetermined {
                    channel: signal.map(|signal| signal.name.clone()).unwrap_or_default(),
                    found,
                    limit: NOISE_FLOOR,
                }
            })?;
            fitted.spectrum(frequencies)
        };
        let short = SHORTEST + samples.isqrt() / 3;
        Ok(Self {
            spectrum: spectrum(order)?,
            smooth: spectrum(short.min(order))?,
            point,
            scales,
            samples,
            order,
        })
    }

    /// Refuses a record without as many rows as the autoregression has columns, and one for each
    /// residual and one more.
    pub fn check_length(samples: usize, channels: usize, order: usize) -> Result<(), IdentError> {
        let columns = order.saturating_mul(channels + 1);
        let needed = columns.saturating_add(channels + 1);
        if samples < needed {
            return Err(IdentError::EivTooFewSamples {
                needed,
                found: samples,
            });
        }
        Ok(())
    }

    /// Refuses a structure of other numbers of outputs or inputs.
    pub fn check(data: &Dataset, outputs: usize, inputs: usize) -> Result<(), IdentError> {
        DimensionError::check("outputs of the structure", data.ny(), outputs)?;
        DimensionError::check("inputs of the structure", data.nu(), inputs)?;
        Ok(())
    }
}
