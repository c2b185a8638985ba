//! The profile Whittle likelihood of an errors-in-variables model.

use nalgebra::DVector;

use super::hermitian::{C64, ZERO, invert, multiply, multiply_adjoint};
use super::layout::Layout;
use super::row::EivLags;
use super::spectrum::{Spectrum, phases};
use crate::IdentError;

/// The likelihood of the coefficients and noise variances of `m` outputs that share `r` noisy
/// inputs, where the spectrum of the noise-free inputs is arbitrary.
///
/// The measured channels have spectrum `H Phi_u H^H + D`, `H = [G; I]`, `D` the noise variances.
/// With `h(w) = [P(w), -Q(w)]` (`m x (m + r)`, `h H = 0`), eliminating `Phi_u(w)` from Whittle's
/// likelihood at each frequency leaves (derived here)
///
/// `f = mean_w { ln det(h D S^-1 D h^H) - ln det(h D h^H) + tr[(h D h^H)^-1 h S h^H] }`,
///
/// and `-2 ln L = N f` up to a constant. `f` does not depend on the units of the channels.
#[derive(Debug, Clone)]
pub struct Likelihood<'a> {
    pub(super) layout: Layout,
    pub(super) spectrum: &'a Spectrum,
    /// `exp(-j w_k lag)`, lags `0..=longest` a frequency.
    pub(super) phases: Vec<C64>,
    work: Work,
}

/// Matrices of one frequency.
#[derive(Debug, Clone)]
struct Work {
    /// `h` and `h D` (`m x q`).
    h: Vec<C64>,
    hd: Vec<C64>,
    /// `h D S^-1 D` and `h S` (`m x q`).
    v: Vec<C64>,
    w: Vec<C64>,
    /// `M1 = h D S^-1 D h^H`, `M2 = h D h^H`, `M3 = h S h^H` (`m x m`), and inverses of two.
    m1: Vec<C64>,
    m2: Vec<C64>,
    m3: Vec<C64>,
    m1_inverse: Vec<C64>,
    m2_inverse: Vec<C64>,
    /// `M2^-1 + M2^-1 M3 M2^-1` and what it is made of.
    x: Vec<C64>,
    product: Vec<C64>,
    /// `M1^-1 V`, `M2^-1 W`, `X h` (`m x q`).
    left: Vec<C64>,
    middle: Vec<C64>,
    right: Vec<C64>,
}

impl<'a> Likelihood<'a> {
    /// The likelihood of a row per output, given the spectrum of the channels `(y, u)`.
    ///
    /// # Errors
    /// [`IdentError::NoOutputs`], [`IdentError::NoInputs`], or [`IdentError::Dimension`] where the
    /// numbers of channels disagree.
    pub fn new(lags: &[EivLags], spectrum: &'a Spectrum) -> Result<Self, IdentError> {
        let layout = Layout::new(lags)?;
        gt_core::DimensionError::check(
            "channels of the spectrum (outputs and inputs)",
            layout.channels(),
            spectrum.channels(),
        )?;
        let phases = phases(spectrum.frequencies(), layout.longest);
        let (m, q) = (layout.outputs, layout.channels());
        let (wide, square) = (vec![ZERO; m * q], vec![ZERO; m * m]);
        let work = Work {
            h: wide.clone(),
            hd: wide.clone(),
            v: wide.clone(),
            w: wide.clone(),
            m1: square.clone(),
            m2: square.clone(),
            m3: square.clone(),
            m1_inverse: square.clone(),
            m2_inverse: square.clone(),
            x: square.clone(),
            product: square,
            left: wide.clone(),
            middle: wide.clone(),
            right: wide,
        };
        Ok(Self {
            layout,
            spectrum,
            phases,
            work,
        })
    }

    /// Number of coefficients and variances, the length of a point.
    pub fn parameters(&self) -> usize {
        self.layout.len()
    }

    /// `f` and its gradient at a point: the coefficients of all rows, each as
    /// [`super::EivRow::theta`], then the `m` output and the `r` input noise variances.
    ///
    /// `f` is infinite where a variance is not positive.
    ///
    /// # Errors
    /// [`IdentError::Dimension`] for a point of another length.
    pub fn gradient(&mut self, point: &[f64]) -> Result<(f64, DVector<f64>), IdentError> {
        gt_core::DimensionError::check(
            "coefficients and variances",
            self.layout.len(),
            point.len(),
        )?;
        let mut gradient = DVector::zeros(point.len());
        let value = self.evaluate(point, gradient.as_mut_slice());
        Ok((value, gradient))
    }

    /// [`Self::gradient`] in place, for slices of the right length.
    pub(super) fn evaluate(&mut self, point: &[f64], gradient: &mut [f64]) -> f64 {
        gradient.fill(0.0);
        let (coefficients, variances) = point.split_at(self.layout.coefficients());
        let stride = self.layout.longest + 1;
        let mut sum = 0.0;
        let work = &mut self.work;
        for index in 0..self.spectrum.frequencies() {
            let phases = &self.phases[index * stride..(index + 1) * stride];
            relation(&self.layout, coefficients, phases, &mut work.h);
            let (s, inverse) = (self.spectrum.matrix(index), self.spectrum.inverse(index));
            let Some(value) = work.at(s, inverse, variances, self.layout.outputs) else {
                gradient.fill(0.0);
                return f64::INFINITY;
            };
            sum += value;
            work.add(&self.layout, phases, variances, gradient);
        }
        let count = self.spectrum.frequencies() as f64;
        for value in gradient.iter_mut() {
            *value /= count;
        }
        sum / count
    }
}

/// `h` (`m x q`) at the frequency of `phases`.
pub(super) fn relation(layout: &Layout, coefficients: &[f64], phases: &[C64], h: &mut [C64]) {
    let q = layout.channels();
    h.fill(ZERO);
    for row in 0..layout.outputs {
        h[row * q + row] = C64::new(1.0, 0.0);
    }
    for (&entry, &value) in layout.entries.iter().zip(coefficients) {
        h[entry.row * q + entry.channel] += phases[entry.lag] * (layout.sign(entry) * value);
    }
}

impl Work {
    /// The summand of `f` at a frequency, for the `h` in place; `None` where it is not defined.
    fn at(&mut self, s: &[C64], inverse: &[C64], variances: &[f64], m: usize) -> Option<f64> {
        let q = variances.len();
        for (hd, h) in self.hd.chunks_exact_mut(q).zip(self.h.chunks_exact(q)) {
            for ((hd, h), variance) in hd.iter_mut().zip(h).zip(variances) {
                *hd = h * variance;
            }
        }
        multiply(&mut self.v, &self.hd, inverse, q, q);
        for v in self.v.chunks_exact_mut(q) {
            for (v, variance) in v.iter_mut().zip(variances) {
                *v *= variance;
            }
        }
        multiply(&mut self.w, &self.h, s, q, q);
        multiply_adjoint(&mut self.m1, &self.v, &self.h, q, m);
        multiply_adjoint(&mut self.m2, &self.hd, &self.h, q, m);
        multiply_adjoint(&mut self.m3, &self.w, &self.h, q, m);
        let first = invert(&mut self.m1, &mut self.m1_inverse, m)?;
        let second = invert(&mut self.m2, &mut self.m2_inverse, m)?;
        multiply(&mut self.product, &self.m2_inverse, &self.m3, m, m);
        let trace: f64 = (0..m).map(|i| self.product[i * m + i].re).sum();
        multiply(&mut self.x, &self.product, &self.m2_inverse, m, m);
        for (x, inverse) in self.x.iter_mut().zip(&self.m2_inverse) {
            *x += inverse;
        }
        let value = first - second + trace;
        value.is_finite().then_some(value)
    }

    /// Adds the gradient at this frequency: `df = 2 Re tr(dh G)` with
    /// `G = V^H M1^-1 + W^H M2^-1 - D h^H X`, and
    /// `df/dD_j = 2 Re (V^H M1^-1 h)_jj / D_j - (h^H X h)_jj`.
    fn add(&mut self, layout: &Layout, phases: &[C64], variances: &[f64], gradient: &mut [f64]) {
        let (m, q) = (layout.outputs, layout.channels());
        multiply(&mut self.left, &self.m1_inverse, &self.v, m, q);
        multiply(&mut self.middle, &self.m2_inverse, &self.w, m, q);
        multiply(&mut self.right, &self.x, &self.h, m, q);
        let (coefficients, noise) = gradient.split_at_mut(layout.coefficients());
        for (&entry, out) in layout.entries.iter().zip(coefficients) {
            let at = entry.row * q + entry.channel;
            let adjoint =
                self.left[at] + self.middle[at] - self.right[at] * variances[entry.channel];
            let part = (phases[entry.lag] * adjoint.conj()).re;
            *out += 2.0 * layout.sign(entry) * part;
        }
        for (j, (out, variance)) in noise.iter_mut().zip(variances).enumerate() {
            for row in 0..m {
                let at = row * q + j;
                let first = (self.left[at].conj() * self.h[at]).re;
                let second = (self.right[at].conj() * self.h[at]).re;
                *out += 2.0 * first / variance - second;
            }
        }
    }
}
