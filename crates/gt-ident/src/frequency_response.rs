//! The frequency response of an ARX model with confidence bands.

use nalgebra::{Complex, DMatrix};
use serde::{Deserialize, Serialize};

use crate::parameter_covariance::check_covariances;
use crate::transfer::{Transfer, standard_error};
use crate::{ArxModel, Estimate, IdentError};

/// The response at one frequency.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct FrequencyPoint {
    /// The frequency in Hz.
    pub frequency_hz: f64,
    /// `G (ny x nu)`, outputs' units per inputs' units.
    pub response: DMatrix<Complex<f64>>,
    /// Standard error of `|G|` (`ny x nu`); where `G` is zero, that of its larger part.
    pub magnitude_error: DMatrix<f64>,
    /// Standard error of the phase in radians (`ny x nu`); infinite where `G` is zero.
    pub phase_error_rad: DMatrix<f64>,
}

impl FrequencyPoint {
    /// The magnitude of one channel (0-based output and input) with its standard error.
    pub fn magnitude(&self, output: usize, input: usize) -> Option<Estimate> {
        let value = self.response.get((output, input))?.norm();
        let standard_error = self.magnitude_error.get((output, input)).copied();
        Some(Estimate {
            value,
            standard_error,
        })
    }

    /// The phase of one channel (0-based output and input) in radians, within `-pi..=pi`, with its
    /// standard error.
    pub fn phase_rad(&self, output: usize, input: usize) -> Option<Estimate> {
        let value = self.response.get((output, input))?.arg();
        let error = self.phase_error_rad.get((output, input)).copied();
        Some(Estimate {
            value,
            standard_error: error.filter(|error| error.is_finite()),
        })
    }
}

/// The frequency response `G(e^(i 2 pi f Ts))` of a model at frequencies from 0 to half the
/// sampling rate, with standard errors from the covariances of each row's coefficients.
///
/// The errors are those of the Gauss approximation (Ljung 1999, section 9.4). The rows are taken
/// as estimated independently of one another, which holds where the equation errors of the outputs
/// are not correlated; in a diagonal structure each response depends on one row only.
///
/// # Errors
/// [`IdentError::Frequency`] for a frequency out of range, [`IdentError::ResponseAtPole`] where a
/// pole lies on it, [`IdentError::Dimension`] and [`IdentError::ModelValue`] for covariances that
/// are not those of the model's rows.
pub fn frequency_response(
    model: &ArxModel,
    covariances: &[DMatrix<f64>],
    frequencies_hz: &[f64],
) -> Result<Vec<FrequencyPoint>, IdentError> {
    check_covariances(model, covariances)?;
    let nyquist_hz = 0.5 / model.sample_time_s();
    frequencies_hz
        .iter()
        .map(|&frequency_hz| {
            // The last bit of a computed half sampling rate is not the caller's fault.
            if !(0.0..=nyquist_hz * (1.0 + 1e-12)).contains(&frequency_hz) {
                return Err(IdentError::Frequency {
                    nyquist_hz,
                    found: frequency_hz,
                });
            }
            let angle = std::f64::consts::PI * (frequency_hz / nyquist_hz).min(1.0);
            point(model, covariances, frequency_hz, angle)
        })
        .collect()
}

fn point(
    model: &ArxModel,
    covariances: &[DMatrix<f64>],
    frequency_hz: f64,
    angle: f64,
) -> Result<FrequencyPoint, IdentError> {
    let z = Complex::from_polar(1.0, angle);
    let transfer = Transfer::new(model, z).ok_or(IdentError::ResponseAtPole { frequency_hz })?;
    let (ny, nu) = transfer.gain.shape();
    let mut magnitude_error = DMatrix::zeros(ny, nu);
    let mut phase_error_rad = DMatrix::zeros(ny, nu);
    for output in 0..ny {
        for input in 0..nu {
            let gain = transfer.gain[(output, input)];
            let covariance = transfer.covariance(model, covariances, (output, input));
            let size = gain.norm();
            let (magnitude, phase) = if size > 0.0 {
                let (re, im) = (gain.re / size, gain.im / size);
                (
                    standard_error([re, im], &covariance),
                    standard_error([-im / size, re / size], &covariance),
                )
            } else {
                (covariance.diagonal().max().max(0.0).sqrt(), f64::INFINITY)
            };
            magnitude_error[(output, input)] = magnitude;
            phase_error_rad[(output, input)] = phase;
        }
    }
    Ok(FrequencyPoint {
        frequency_hz,
        response: transfer.gain,
        magnitude_error,
        phase_error_rad,
    })
}

/// The gains at frequency 0 (`ny x nu`, row by row), with sign and standard error, in outputs'
/// units per inputs' units.
///
/// # Errors
/// As [`frequency_response`]: [`IdentError::ResponseAtPole`] where the model integrates.
pub fn dc_gains(
    model: &ArxModel,
    covariances: &[DMatrix<f64>],
) -> Result<Vec<Vec<Estimate>>, IdentError> {
    check_covariances(model, covariances)?;
    let transfer = Transfer::new(model, Complex::new(1.0, 0.0))
        .ok_or(IdentError::ResponseAtPole { frequency_hz: 0.0 })?;
    let (ny, nu) = transfer.gain.shape();
    let gain = |output, input| {
        let covariance = transfer.covariance(model, covariances, (output, input));
        Estimate {
            value: transfer.gain[(output, input)].re,
            standard_error: Some(standard_error([1.0, 0.0], &covariance)),
        }
    };
    Ok((0..ny)
        .map(|output| (0..nu).map(|input| gain(output, input)).collect())
        .collect())
}
