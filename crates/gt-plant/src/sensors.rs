//! The sensors: the thermocouple's drift, and white noise in proportion to each signal.

use std::fmt;
use std::str::FromStr;

use nalgebra::DMatrix;
use serde::{Deserialize, Serialize};

use crate::PlantError;
use crate::channels::{INPUT_CHANNELS, OUTPUT_CHANNELS, Quantity, T3};
use crate::excitation::standard_normal;
use crate::faults::{Fault, FaultSizes};
use crate::random::{Purpose, stream};

/// How noisy the sensors are.
///
/// Noise is white and normal, added to the measured outputs and to the measured `a_v` and `M_f`, not
/// to what the plant receives. Its standard deviation is a share of the signal's own standard
/// deviation over the healthy record with the same excitation, so that a fault changes no sensor;
/// the constant channels t1 and t2 therefore carry none.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum NoiseLevel {
    /// No noise.
    #[default]
    None,
    /// 1 % of each signal's deviation.
    Low,
    /// The paper's Table 8, read as standard deviations in units of the signal's (the paper does
    /// not say whether they are deviations or variances).
    Table8,
}

impl NoiseLevel {
    /// The names, in the order of the variants.
    pub const NAMES: &[&str] = &["none", "low", "table8"];

    /// Standard deviation of the noise over that of the signal.
    ///
    /// Table 8 prints `a_v`, `M_f` and one pressure, mass flow, torque and temperature, which stand
    /// for all of their kind. It has no powers and no speed: a power is read from a torque and a
    /// speed, of which the torque is by far the noisier, so it takes the torque's; speed is
    /// counted from teeth, the most exact measurement on a turbine, so it takes the smallest of
    /// the table, the temperature's (both assumed).
    pub fn fraction(self, quantity: Quantity) -> f64 {
        match (self, quantity) {
            (Self::None, _) | (_, Quantity::Known) => 0.0,
            (Self::Low, _) => 0.01,
            (Self::Table8, Quantity::ValveAngle) => 0.1417,
            (Self::Table8, Quantity::FuelDemand) => 0.2623,
            (Self::Table8, Quantity::Pressure) => 0.2497,
            (Self::Table8, Quantity::MassFlow) => 0.2345,
            (Self::Table8, Quantity::Torque | Quantity::Power) => 0.2909,
            (Self::Table8, Quantity::Temperature | Quantity::Speed) => 0.0941,
        }
    }
}

impl fmt::Display for NoiseLevel {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        formatter.pad(match self {
            Self::None => "none",
            Self::Low => "low",
            Self::Table8 => "table8",
        })
    }
}

impl FromStr for NoiseLevel {
    type Err = PlantError;

    fn from_str(name: &str) -> Result<Self, PlantError> {
        match name {
            "none" => Ok(Self::None),
            "low" => Ok(Self::Low),
            "table8" => Ok(Self::Table8),
            _ => Err(PlantError::UnknownName {
                what: "noise",
                expected: Self::NAMES,
                found: name.to_owned(),
            }),
        }
    }
}

/// Standard deviations of the signals of a record, to which noise is proportional.
#[derive(Debug, Clone, PartialEq)]
pub struct Deviations {
    /// Of each input, in its unit.
    pub u: Vec<f64>,
    /// Of each output, in its unit.
    pub y: Vec<f64>,
}

impl Deviations {
    /// The deviations of true inputs (5 x N) and outputs (28 x N), divided by N.
    pub fn of(u: &DMatrix<f64>, y: &DMatrix<f64>) -> Self {
        Self {
            u: row_deviations(u),
            y: row_deviations(y),
        }
    }
}

fn row_deviations(matrix: &DMatrix<f64>) -> Vec<f64> {
    matrix
        .row_iter()
        .map(|row| deviation(row.iter().copied()))
        .collect()
}

/// Standard deviation, divided by N. Counted from the first value, so that a constant channel has
/// exactly none and takes no noise at the level of rounding.
fn deviation(values: impl ExactSizeIterator<Item = f64> + Clone) -> f64 {
    let count = values.len() as f64;
    let Some(first) = values.clone().next() else {
        return 0.0;
    };
    let mean = values.clone().map(|value| value - first).sum::<f64>() / count;
    (values
        .map(|value| (value - first - mean).powi(2))
        .sum::<f64>()
        / count)
        .sqrt()
}

/// Adds the drift of the thermocouple t3 to true outputs (28 x N) at the given times.
pub(crate) fn add_drift(y: &mut DMatrix<f64>, faults: &[Fault], time_s: impl Fn(usize) -> f64) {
    for (k, reading) in y.row_mut(T3).iter_mut().enumerate() {
        *reading *= 1.0 + FaultSizes::at(faults, time_s(k)).t3_reading_error;
    }
}

/// Adds noise to inputs (5 x N) and outputs (28 x N), each channel from its own stream.
pub(crate) fn add_noise(
    u: &mut DMatrix<f64>,
    y: &mut DMatrix<f64>,
    level: NoiseLevel,
    deviations: &Deviations,
    [seed, run_index]: [u64; 2],
) {
    let add = |matrix: &mut DMatrix<f64>, row: usize, deviation: f64, purpose| {
        if deviation > 0.0 {
            let mut generator = stream(seed, run_index, purpose);
            for value in &mut matrix.row_mut(row) {
                *value += deviation * standard_normal(&mut generator);
            }
        }
    };
    for (row, (_, _, quantity)) in INPUT_CHANNELS.into_iter().enumerate() {
        add(
            u,
            row,
            level.fraction(quantity) * deviations.u[row],
            Purpose::InputNoise(row),
        );
    }
    for (row, (_, _, quantity)) in OUTPUT_CHANNELS.into_iter().enumerate() {
        add(
            y,
            row,
            level.fraction(quantity) * deviations.y[row],
            Purpose::OutputNoise(row),
        );
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn deviation_is_that_of_the_population() {
        // 2, 4, 4, 4, 5, 5, 7, 9 have the mean 5 and the deviation 2.
        let values = [2.0, 4.0, 4.0, 4.0, 5.0, 5.0, 7.0, 9.0].map(|value| value + 1e9);
        assert!((deviation(values.into_iter()) - 2.0).abs() < 1e-12);
        assert_eq!(
            deviation(std::iter::repeat_n(291.846488512, 7500)).to_bits(),
            0.0f64.to_bits()
        );
        assert_eq!(deviation(std::iter::empty()).to_bits(), 0.0f64.to_bits());
    }
}
