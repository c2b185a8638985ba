//! Which pole an eigenvalue gets.

use nalgebra::Complex;

use super::PlacementError;
use super::placed_poles::pair;

/// Poles that are not assigned yet, in the order in which they were given.
pub(super) struct Pool {
    real: Vec<f64>,
    /// Those with the positive imaginary part.
    pairs: Vec<Complex<f64>>,
}

impl Pool {
    /// The first `used` poles of a list.
    pub(super) fn new(poles: &[Complex<f64>], used: usize) -> Result<Self, PlacementError> {
        let partners = pair(poles)?;
        if poles.len() < used {
            return Err(PlacementError::TooFew {
                expected: used,
                found: poles.len(),
            });
        }
        let mut pool = Self {
            real: Vec::new(),
            pairs: Vec::new(),
        };
        for (index, (&found, &partner)) in poles.iter().zip(&partners).take(used).enumerate() {
            if partner >= used {
                return Err(PlacementError::SplitPair { used, index, found });
            }
            if partner == index {
                pool.real.push(found.re);
            } else if partner > index {
                pool.pairs.push(Complex::new(found.re, found.im.abs()));
            }
        }
        Ok(pool)
    }

    /// Takes the real pole nearest to `eigenvalue`, the first of equally near ones.
    pub(super) fn real(&mut self, eigenvalue: f64) -> Option<f64> {
        let distance = |pole: &f64| (pole - eigenvalue).abs();
        let index = nearest(self.real.iter().map(distance))?;
        Some(self.real.remove(index))
    }

    /// Takes the pair nearest to `eigenvalue`, or else the two nearest real poles.
    pub(super) fn two(&mut self, eigenvalue: Complex<f64>) -> Option<[Complex<f64>; 2]> {
        let above = Complex::new(eigenvalue.re, eigenvalue.im.abs());
        if let Some(index) = nearest(self.pairs.iter().map(|pole| (pole - above).norm())) {
            let pole = self.pairs.remove(index);
            return Some([pole, pole.conj()]);
        }
        let first = self.real(eigenvalue.re)?;
        let second = self.real(eigenvalue.re)?;
        Some([Complex::new(first, 0.0), Complex::new(second, 0.0)])
    }
}

/// The position of the smallest distance, the first of equal ones.
fn nearest(distances: impl Iterator<Item = f64>) -> Option<usize> {
    distances
        .enumerate()
        .min_by(|left, right| left.1.total_cmp(&right.1))
        .map(|(index, _)| index)
}
