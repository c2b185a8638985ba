//! Several residuals made white together, sample by sample.

use alloc::boxed::Box;
use alloc::vec;
use alloc::vec::Vec;

use super::recall::{self, Recall};
use crate::runtime::LARGEST_SAMPLE;

/// A deviation beyond this, in any unit, counts as this.
const LARGEST_DEVIATION: f64 = 1e150;

/// The numbers of a [`JointWhitener`], matrices row by row.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct JointWhitenerParts {
    /// Healthy means (m).
    pub(crate) mean: Vec<f64>,
    /// `A_1 .. A_p`, each `m x m`.
    pub(crate) coefficients: Vec<Vec<f64>>,
    /// `W (m x m)`, each row divided by that component's scale.
    pub(crate) factor: Vec<f64>,
}

/// `v(t) = W (e(t) + A_1 e(t-1) + ... + A_p e(t-p))`, `e = r - mean`, with its memory.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct JointWhitener {
    parts: JointWhitenerParts,
    /// `e(t-1), ..., e(t-p)` from `newest` on, round.
    past: Vec<Box<[f64]>>,
    newest: usize,
    error: Box<[f64]>,
    sum: Box<[f64]>,
    white: Box<[f64]>,
}

impl JointWhitener {
    /// A whitener whose past is at the mean.
    pub(crate) fn new(parts: JointWhitenerParts) -> Self {
        let size = parts.mean.len();
        let zeros: Box<[f64]> = vec![0.0; size].into();
        Self {
            past: vec![zeros.clone(); parts.coefficients.len()],
            newest: 0,
            error: zeros.clone(),
            sum: zeros.clone(),
            white: zeros,
            parts,
        }
    }

    /// Samples after which the past before is forgotten.
    pub(crate) fn order(&self) -> usize {
        self.past.len()
    }

    /// The whitened residuals, finite whatever comes: a residual that is not finite counts as its
    /// mean.
    pub(crate) fn step(&mut self, residuals: &[f64]) -> &[f64] {
        let size = self.parts.mean.len();
        let own = self.error.iter_mut().zip(residuals).zip(&self.parts.mean);
        for ((error, residual), mean) in own {
            let deviation = residual - mean;
            *error = if deviation.is_finite() {
                deviation.clamp(-LARGEST_DEVIATION, LARGEST_DEVIATION)
            } else {
                0.0
            };
        }
        self.sum.copy_from_slice(&self.error);
        for (lag, matrix) in self.parts.coefficients.iter().enumerate() {
            let place = (self.newest + lag) % self.past.len().max(1);
            let Some(past) = self.past.get(place) else {
                continue;
            };
            for (sum, row) in self.sum.iter_mut().zip(matrix.chunks_exact(size)) {
                *sum += row.iter().zip(past.iter()).map(|(a, e)| a * e).sum::<f64>();
            }
        }
        for (white, row) in self
            .white
            .iter_mut()
            .zip(self.parts.factor.chunks_exact(size))
        {
            let value: f64 = row.iter().zip(self.sum.iter()).map(|(w, e)| w * e).sum();
            *white = value.clamp(-LARGEST_SAMPLE, LARGEST_SAMPLE);
        }
        if !self.past.is_empty() {
            self.newest = (self.newest + self.past.len() - 1) % self.past.len();
            if let Some(oldest) = self.past.get_mut(self.newest) {
                oldest.copy_from_slice(&self.error);
            }
        }
        &self.white
    }

    /// Puts the past at the mean.
    pub(crate) fn reset(&mut self) {
        for past in &mut self.past {
            past.fill(0.0);
        }
    }
}

impl Recall for JointWhitener {
    fn recall(&mut self, visit: &mut dyn FnMut(&mut f64)) {
        for past in &mut self.past {
            recall::numbers(past, visit);
        }
        let last = self.past.len().saturating_sub(1);
        recall::count(&mut self.newest, last, visit);
    }
}
