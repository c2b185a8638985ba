//! The spectrum of the measured channels on a grid of frequencies.

use std::f64::consts::PI;

use nalgebra::{Complex, DMatrix};

use super::hermitian::{C64, ZERO, invert};
use crate::IdentError;

/// The spectral matrix `S (q x q)` of the channels `z = (y, u)` and its inverse at the mid-point
/// frequencies `w_k = pi (k + 1/2) / K`, `k = 0..K`, in radians a sample.
///
/// `S(w) = sum_tau E[z(t) z(t - tau)^T] exp(-j w tau)`, so that white noise of variance 1 has
/// spectrum 1 and the mean of `S` over the frequencies is the variance.
#[derive(Debug, Clone, PartialEq)]
pub struct Spectrum {
    channels: usize,
    frequencies: usize,
    /// `K` matrices, each row by row.
    matrices: Vec<C64>,
    inverses: Vec<C64>,
}

impl Spectrum {
    /// The spectrum whose matrix (`q x q`, Hermitian, positive definite) at `w` is `matrix(w)`;
    /// only lower triangles are read.
    ///
    /// # Errors
    /// [`IdentError::Dimension`] for a matrix that is not `q x q`,
    /// [`IdentError::SpectrumNotPositive`] for one that is not positive definite.
    pub fn from_fn(
        channels: usize,
        frequencies: usize,
        matrix: impl Fn(f64) -> DMatrix<Complex<f64>>,
    ) -> Result<Self, IdentError> {
        let mut matrices = Vec::with_capacity(frequencies * channels * channels);
        for index in 0..frequencies {
            let value = matrix(frequency(index, frequencies));
            gt_core::DimensionError::check("rows of a spectrum", channels, value.nrows())?;
            gt_core::DimensionError::check("columns of a spectrum", channels, value.ncols())?;
            for row in 0..channels {
                matrices.extend((0..channels).map(|column| {
                    if column <= row {
                        value[(row, column)]
                    } else {
                        value[(column, row)].conj()
                    }
                }));
            }
        }
        let inverses = inverted(&matrices, channels)?;
        Ok(Self {
            channels,
            frequencies,
            matrices,
            inverses,
        })
    }

    /// From the inverses (`K` matrices, row by row), as an autoregression gives them.
    pub(super) fn from_inverses(inverses: Vec<C64>, channels: usize) -> Result<Self, IdentError> {
        let matrices = inverted(&inverses, channels)?;
        Ok(Self {
            channels,
            frequencies: inverses.len() / (channels * channels),
            matrices,
            inverses,
        })
    }

    /// The spectrum of some of the channels.
    pub(super) fn marginal(&self, selected: &[usize]) -> Result<Self, IdentError> {
        let (q, count) = (self.channels, selected.len());
        let mut matrices = Vec::with_capacity(self.frequencies * count * count);
        for matrix in self.matrices.chunks_exact(q * q) {
            for &row in selected {
                matrices.extend(selected.iter().map(|&column| matrix[row * q + column]));
            }
        }
        let inverses = inverted(&matrices, count)?;
        Ok(Self {
            channels: count,
            frequencies: self.frequencies,
            matrices,
            inverses,
        })
    }

    /// Number of channels `q`.
    pub fn channels(&self) -> usize {
        self.channels
    }

    /// Number of frequencies `K`.
    pub fn frequencies(&self) -> usize {
        self.frequencies
    }

    /// The frequency `w_k` in radians a sample.
    pub fn frequency(&self, index: usize) -> f64 {
        frequency(index, self.frequencies)
    }

    /// `S` at a frequency, row by row.
    pub(super) fn matrix(&self, index: usize) -> &[C64] {
        let size = self.channels * self.channels;
        &self.matrices[index * size..(index + 1) * size]
    }

    /// The inverse of `S` at a frequency, row by row.
    pub(super) fn inverse(&self, index: usize) -> &[C64] {
        let size = self.channels * self.channels;
        &self.inverses[index * size..(index + 1) * size]
    }
}

/// `w_k` of [`Spectrum`].
pub(super) fn frequency(index: usize, frequencies: usize) -> f64 {
    PI * (index as f64 + 0.5) / frequencies as f64
}

/// `exp(-j w_k lag)` for `lag = 0..=last`, a frequency after the other.
pub(super) fn phases(frequencies: usize, last: usize) -> Vec<C64> {
    // w_k lag = 2 pi ((2 k + 1) lag) / (4 K): the exact angle is one of 4 K.
    let circle = 4 * frequencies;
    let table: Vec<C64> = (0..circle)
        .map(|step| C64::from_polar(1.0, -2.0 * PI * step as f64 / circle as f64))
        .collect();
    (0..frequencies)
        .flat_map(|index| (0..=last).map(move |lag| ((2 * index + 1) * lag) % circle))
        .map(|step| table[step])
        .collect()
}

fn inverted(matrices: &[C64], channels: usize) -> Result<Vec<C64>, IdentError> {
    let size = channels * channels;
    let mut inverses = vec![ZERO; matrices.len()];
    let mut work = vec![ZERO; size];
    let pairs = matrices
        .chunks_exact(size)
        .zip(inverses.chunks_exact_mut(size));
    for (index, (matrix, inverse)) in pairs.enumerate() {
        work.copy_from_slice(matrix);
        if invert(&mut work, inverse, channels).is_none() {
            return Err(IdentError::SpectrumNotPositive { index });
        }
    }
    Ok(inverses)
}
