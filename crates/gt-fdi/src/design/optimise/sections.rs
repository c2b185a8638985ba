//! An observer's characteristic polynomial in second-order sections.

use nalgebra::{Complex, DMatrix, DVector};

use super::super::placement::{PlacementError, pair};

/// Rounding of `a1^2 / 4 - a2`, relative to its terms, below which a section has a double pole.
const DOUBLE_POLE_ROUNDINGS: f64 = 4.0;
/// Distance from a face of the polytope, relative to its size, at which coefficients are on it.
const FACE: f64 = 1e-8;

/// `P(z^-1) = prod_k (1 + a1_k z^-1 + a2_k z^-2)`, and for an odd order a factor `1 + c z^-1`.
///
/// All poles are within a radius `rho` exactly if `a2 <= rho^2`, `+-rho a1 - a2 <= rho^2` for each
/// section and `|c| <= rho`: a polytope, with no singularity where poles meet.
#[derive(Debug, Clone, PartialEq)]
pub struct Sections {
    coefficients: DVector<f64>,
}

impl Sections {
    /// Sections with the coefficients `a1, a2` of one after the other and, for an odd number of
    /// them, `c` at the end (n, the order).
    pub fn new(coefficients: DVector<f64>) -> Self {
        Self { coefficients }
    }

    /// Sections with these poles (n): complex ones in pairs, real ones two by two in the order of
    /// the list, the last of an odd number alone.
    ///
    /// # Errors
    /// [`PlacementError::Unpaired`] or [`PlacementError::NotFinite`].
    pub fn from_poles(poles: &[Complex<f64>]) -> Result<Self, PlacementError> {
        let (mut real, mut coefficients) = (Vec::new(), Vec::new());
        for (index, (pole, partner)) in poles.iter().zip(pair(poles)?).enumerate() {
            if partner == index {
                real.push(pole.re);
            } else if partner > index {
                coefficients.extend([-2.0 * pole.re, pole.norm_sqr()]);
            }
        }
        for two in real.chunks(2) {
            match *two {
                [first, second] => coefficients.extend([-first - second, first * second]),
                _ => coefficients.extend(two.iter().map(|pole| -pole)),
            }
        }
        Ok(Self::new(DVector::from_vec(coefficients)))
    }

    /// The order n.
    pub fn order(&self) -> usize {
        self.coefficients.len()
    }

    /// The coefficients (n), as in [`Sections::new`].
    pub fn coefficients(&self) -> &DVector<f64> {
        &self.coefficients
    }

    /// The poles (n), section by section; complex ones are exact conjugates.
    pub fn poles(&self) -> Vec<Complex<f64>> {
        let sections = self.coefficients.as_slice().chunks(2);
        sections.flat_map(section_poles).collect()
    }

    /// `signal / P`, from rest.
    pub fn filter(&self, signal: &[f64]) -> Vec<f64> {
        let mut filtered = signal.to_vec();
        for section in 0..self.count() {
            self.filter_by(section, &mut filtered);
        }
        filtered
    }

    /// Sections of the first and second order.
    pub(super) fn count(&self) -> usize {
        self.order().div_ceil(2)
    }

    /// Divides by one section, from rest.
    pub(super) fn filter_by(&self, section: usize, signal: &mut [f64]) {
        let a1 = self.coefficients[2 * section];
        let a2 = self
            .coefficients
            .get(2 * section + 1)
            .copied()
            .unwrap_or(0.0);
        let (mut last, mut before) = (0.0, 0.0);
        for value in signal {
            *value -= a1 * last + a2 * before;
            (before, last) = (last, *value);
        }
    }

    /// The sections one by one.
    pub(super) fn parts(&self) -> Vec<Self> {
        let sections = self.coefficients.as_slice().chunks(2);
        sections
            .map(|section| Self::new(DVector::from_column_slice(section)))
            .collect()
    }

    /// Of a single section, the coefficients of `z^-1`, `z^-2` of the numerator that makes it an
    /// all-pass, whose constant is [`Sections::last`]: `a1, 1` or `1`.
    pub(super) fn reversed(&self) -> impl Iterator<Item = f64> {
        let behind_last = self.coefficients.iter().rev().skip(1).copied();
        behind_last.chain([1.0])
    }

    /// The last coefficient, 0 when there is none.
    pub(super) fn last(&self) -> f64 {
        self.coefficients.as_slice().last().copied().unwrap_or(0.0)
    }

    /// The nearest point, section by section, with poles within the radius: `a2` first, then `a1`.
    /// What is within [`FACE`] of a face is put on it: the solver of the quadratic programmes stops
    /// about that far inside, and a vertex has to be met.
    pub(super) fn clamped(mut self, radius: f64) -> Self {
        let square = radius * radius;
        let within = |value: f64, limit: f64, size: f64| {
            if value.abs() > limit - FACE * size {
                limit.copysign(value)
            } else {
                value
            }
        };
        for section in self.coefficients.as_mut_slice().chunks_mut(2) {
            match section {
                [a1, a2] => {
                    *a2 = within(*a2, square, square);
                    *a1 = within(*a1, (square + *a2) / radius, radius);
                }
                [c] => *c = within(*c, radius, radius),
                _ => {}
            }
        }
        self
    }
}

/// `G x <= h` for sections of this order with poles within the radius.
pub(super) fn polytope(order: usize, radius: f64) -> (DMatrix<f64>, DVector<f64>) {
    let square = radius * radius;
    let mut rows: Vec<(usize, [f64; 2], f64)> = Vec::new();
    for section in 0..order / 2 {
        let at = 2 * section;
        rows.push((at, [0.0, 1.0], square));
        rows.push((at, [radius, -1.0], square));
        rows.push((at, [-radius, -1.0], square));
    }
    if order % 2 == 1 {
        rows.push((order - 1, [1.0, 0.0], radius));
        rows.push((order - 1, [-1.0, 0.0], radius));
    }
    let mut g = DMatrix::zeros(rows.len(), order);
    for (row, &(at, entries, _)) in rows.iter().enumerate() {
        for (entry, column) in entries.into_iter().zip(at..order) {
            g[(row, column)] = entry;
        }
    }
    let h = DVector::from_iterator(rows.len(), rows.iter().map(|&(_, _, limit)| limit));
    (g, h)
}

/// The poles of `1 + a1 z^-1 + a2 z^-2`, or the one of `1 + c z^-1`.
fn section_poles(section: &[f64]) -> Vec<Complex<f64>> {
    let &[a1, a2] = section else {
        return section.iter().map(|c| Complex::new(-c, 0.0)).collect();
    };
    let half = -a1 / 2.0;
    let square = half * half;
    let discriminant = square - a2;
    if discriminant.abs() <= DOUBLE_POLE_ROUNDINGS * f64::EPSILON * square {
        return vec![Complex::new(half, 0.0); 2];
    }
    if discriminant < 0.0 {
        let pole = Complex::new(half, (-discriminant).sqrt());
        return vec![pole, pole.conj()];
    }
    // The larger root without cancellation, the other from the product.
    let larger = half + discriminant.sqrt().copysign(half);
    [larger, a2 / larger]
        .map(|pole| Complex::new(pole, 0.0))
        .to_vec()
}
