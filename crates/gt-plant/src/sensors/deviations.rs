//! What the noise of a run is measured by.

use nalgebra::DMatrix;

use super::{Noise, NoiseScale};
use crate::channel::{Channel, ChannelRow};
use crate::channels::{INPUTS, OUTPUTS};

/// Standard deviations of the signals of a record, to which noise may be proportional.
#[derive(Debug, Clone, PartialEq)]
pub struct Deviations {
    /// Of each input, in its unit.
    pub u: Vec<f64>,
    /// Of each output, in its unit.
    pub y: Vec<f64>,
}

impl Deviations {
    /// The deviations of true inputs (nu x N) and outputs (ny x N), divided by N.
    pub fn of(u: &DMatrix<f64>, y: &DMatrix<f64>) -> Self {
        Self {
            u: row_deviations(u),
            y: row_deviations(y),
        }
    }

    /// Those of a record in which nothing moves.
    pub fn zero() -> Self {
        Self {
            u: vec![0.0; INPUTS],
            y: vec![0.0; OUTPUTS],
        }
    }

    /// The deviation of a channel; zero where there is no such row.
    pub fn channel(&self, channel: Channel) -> f64 {
        let (rows, row) = match channel.row() {
            ChannelRow::Input(row) => (&self.u, row),
            ChannelRow::Output(row) => (&self.y, row),
        };
        rows.get(row).copied().unwrap_or(0.0)
    }
}

/// What the noise of a run is measured by.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct NoiseBasis {
    /// Of the healthy signals; zero where no noise is a share of them.
    pub signals: Deviations,
    /// Values of all channels at the healthy equilibrium, inputs first; empty where no noise is a
    /// share of them.
    pub design: Vec<f64>,
}

impl NoiseBasis {
    /// Standard deviation of a channel's noise, in its unit.
    pub fn deviation(&self, noise: &Noise, channel: Channel) -> f64 {
        match noise.scale(channel) {
            NoiseScale::Unit(deviation) => deviation,
            NoiseScale::SignalShare(share) => share * self.signals.channel(channel),
            NoiseScale::DesignShare(share) => {
                let value = self.design.get(channel.index()).copied().unwrap_or(0.0);
                share * value.abs()
            }
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
