//! From residuals in their units to one number in standard deviations.

use alloc::boxed::Box;
use alloc::vec;
use alloc::vec::Vec;

use super::LARGEST_SAMPLE;
use super::fingerprint::Fingerprint;

/// A deviation beyond this, in any unit, counts as this.
const LARGEST_DEVIATION: f64 = 1e150;

/// The numbers that whiten `m` residuals: `v = W (r - mean)`, then for each component
/// `z(t) = (v(t) + a_1 v(t-1) + ... + a_p v(t-p)) / s`.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Whitening {
    /// Healthy means (m).
    pub(crate) mean: Vec<f64>,
    /// `W (m x m)`, lower triangular, row by row.
    pub(crate) factor: Vec<f64>,
    /// For each component the coefficients `a_1 .. a_p`, of one length.
    pub(crate) coefficients: Vec<Vec<f64>>,
    /// For each component `s`.
    pub(crate) scale: Vec<f64>,
}

/// A [`Whitening`] with its memory; one residual keeps its sign, several become the norm of `z`.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Whitener {
    mean: Box<[f64]>,
    factor: Box<[f64]>,
    components: Box<[Component]>,
    /// Deviations of the residuals from their means (m).
    deviations: Box<[f64]>,
}

#[derive(Debug, Clone, PartialEq)]
struct Component {
    coefficients: Box<[f64]>,
    scale: f64,
    /// `v(t-1) .. v(t-p)`.
    past: Box<[f64]>,
}

impl Whitener {
    /// A whitener whose past is at the mean.
    pub(crate) fn new(whitening: Whitening) -> Self {
        let size = whitening.mean.len();
        let components = whitening.coefficients.into_iter().zip(whitening.scale);
        let components = components.map(|(coefficients, scale)| Component {
            past: vec![0.0; coefficients.len()].into(),
            coefficients: coefficients.into(),
            scale,
        });
        Self {
            mean: whitening.mean.into(),
            factor: whitening.factor.into(),
            components: components.collect(),
            deviations: vec![0.0; size].into(),
        }
    }

    /// Takes the residuals that stand at `places` of `residuals`; NaN when one is missing, which
    /// leaves the past as it was.
    pub(crate) fn step(&mut self, residuals: &[f64], places: &[usize]) -> f64 {
        let own = self.deviations.iter_mut().zip(places).zip(&self.mean);
        let mut finite = true;
        for ((deviation, &place), mean) in own {
            let residual = residuals.get(place).copied().unwrap_or(f64::NAN);
            finite &= residual.is_finite();
            // Sums of products stay finite.
            *deviation = (residual - mean).clamp(-LARGEST_DEVIATION, LARGEST_DEVIATION);
        }
        if !finite {
            return f64::NAN;
        }
        let (mut last, mut squares) = (0.0, 0.0);
        let rows = self.factor.chunks_exact(self.deviations.len().max(1));
        for (index, (row, component)) in rows.zip(&mut self.components).enumerate() {
            // Below the diagonal and on it; beyond are zeros.
            let terms = row.iter().zip(&self.deviations).take(index + 1);
            let value = terms.fold(0.0, |sum, (factor, deviation)| sum + factor * deviation);
            last = component.step(value.clamp(-LARGEST_SAMPLE, LARGEST_SAMPLE));
            squares += last * last;
        }
        if self.components.len() == 1 {
            last
        } else {
            libm::sqrt(squares)
        }
    }

    /// Adds its numbers to a fingerprint.
    pub(crate) fn mark(&self, print: &mut Fingerprint) {
        let components = self.components.iter();
        let own = components.flat_map(|own| own.coefficients.iter().chain([&own.scale]));
        for value in self.mean.iter().chain(&self.factor).chain(own) {
            print.add(value.to_bits());
        }
    }

    /// Puts the past at the mean.
    pub(crate) fn reset(&mut self) {
        for component in &mut self.components {
            component.past.fill(0.0);
        }
    }

    /// The past of every component, one after the other.
    pub(crate) fn past(&self) -> impl Iterator<Item = f64> + '_ {
        let components = self.components.iter();
        components.flat_map(|component| component.past.iter().copied())
    }

    /// Takes a past that [`Whitener::past`] gave; `false`, and nothing taken, when it does not fit.
    pub(crate) fn set_past(&mut self, past: &[f64]) -> bool {
        let lengths = self.components.iter().map(|component| component.past.len());
        if past.len() != lengths.sum::<usize>() || !past.iter().all(|value| value.is_finite()) {
            return false;
        }
        let mut rest = past.iter();
        for component in &mut self.components {
            for (own, &value) in component.past.iter_mut().zip(&mut rest) {
                *own = value;
            }
        }
        true
    }
}

impl Component {
    fn step(&mut self, value: f64) -> f64 {
        let terms = self.coefficients.iter().zip(&self.past);
        let whitened = terms.fold(value, |sum, (coefficient, past)| sum + coefficient * past);
        if let Some(kept) = self.past.len().checked_sub(1) {
            self.past.copy_within(..kept, 1);
        }
        if let Some(newest) = self.past.first_mut() {
            *newest = value;
        }
        whitened / self.scale
    }
}
