//! The information that a record holds on an errors-in-variables model whose input spectrum is
//! unknown: the bound that no consistent estimator beats.

use nalgebra::DMatrix;

use super::hermitian::{C64, ZERO, invert, multiply, multiply_adjoint};
use super::likelihood::{Likelihood, relation};
use crate::IdentError;
use crate::symmetric::symmetric_eigen;

impl Likelihood<'_> {
    /// The semiparametric Fisher information a sample at a point (see [`Likelihood::gradient`]),
    /// coefficients before variances; its inverse over `N` bounds the covariance of the estimates.
    ///
    /// Whittle's information `(N/2) mean_w tr(Phi^-1 d_i Phi Phi^-1 d_j Phi)` less what the
    /// unknown input spectrum takes, `I_tv I_vv^-1 I_vt` over all Hermitian directions of
    /// `Phi_u(w)`, frequency by frequency. With `Pi = h^H (h D h^H)^-1 h` and
    /// `C = Phi^-1 - Pi` what is left is `N mean_w Re[ tr(Pi d_i Phi Pi d_j Phi) / 2 +
    /// tr(Pi d_i Phi C d_j Phi) ]` (derived here). `Phi_u` is the one that the likelihood
    /// eliminates, `W^H S W - (H^H D^-1 H)^-1` with `W = D^-1 H (H^H D^-1 H)^-1`: exact where the
    /// spectrum is, an estimate where it is one.
    ///
    /// # Errors
    /// [`IdentError::Dimension`] for a point of another length,
    /// [`IdentError::SpectrumNotPositive`] where a variance is not positive or the relation has a
    /// pole on the unit circle.
    pub fn information(&self, point: &[f64]) -> Result<DMatrix<f64>, IdentError> {
        let layout = &self.layout;
        gt_core::DimensionError::check("coefficients and variances", layout.len(), point.len())?;
        let (coefficients, variances) = point.split_at(layout.coefficients());
        let stride = layout.longest + 1;
        let mut total = DMatrix::zeros(layout.len(), layout.len());
        let mut parts = Parts::new(layout.outputs, layout.inputs);
        for index in 0..self.spectrum.frequencies() {
            let phases = &self.phases[index * stride..(index + 1) * stride];
            relation(layout, coefficients, phases, &mut parts.h);
            parts
                .fill(self.spectrum.matrix(index), variances)
                .ok_or(IdentError::SpectrumNotPositive { index })?;
            self.add_information(&parts, phases, &mut total);
        }
        total /= self.spectrum.frequencies() as f64;
        total.fill_lower_triangle_with_upper_triangle();
        Ok(total)
    }

    /// Adds one frequency to the upper triangle.
    fn add_information(&self, parts: &Parts, phases: &[C64], total: &mut DMatrix<f64>) {
        let layout = &self.layout;
        let (m, q, first) = (layout.outputs, layout.channels(), layout.coefficients());
        let signed: Vec<C64> = layout
            .entries
            .iter()
            .map(|&entry| phases[entry.lag] * layout.sign(entry))
            .collect();
        for (p, (left, &phase)) in layout.entries.iter().zip(&signed).enumerate() {
            for (p2, (right, &other)) in layout.entries.iter().zip(&signed).enumerate().skip(p) {
                let weight = parts.m2_inverse[right.row * m + left.row];
                let inner = parts.f[left.channel * q + right.channel];
                total[(p, p2)] += (phase * other.conj() * weight * inner).re;
            }
            for j in 0..q {
                let inner = parts.phi_c[left.channel * q + j];
                let weight = parts.m2_h[left.row * q + j].conj();
                total[(p, first + j)] -= (phase * inner * weight).re;
            }
        }
        for j in 0..q {
            for l in j..q {
                let pi = parts.pi[j * q + l];
                let cross = (parts.c[j * q + l] * pi.conj()).re;
                total[(first + j, first + l)] += 0.5 * pi.norm_sqr() + cross;
            }
        }
    }
}

/// The matrices of one frequency.
struct Parts {
    outputs: usize,
    inputs: usize,
    /// `h` (`m x q`).
    h: Vec<C64>,
    /// `(h D h^H)^-1` (`m x m`) and its product with `h` (`m x q`).
    m2_inverse: Vec<C64>,
    m2_h: Vec<C64>,
    /// `Pi`, `C`, `Phi_x C` and `Phi_x C Phi_x` (`q x q`), `Phi_x = H Phi_u H^H`.
    pi: Vec<C64>,
    c: Vec<C64>,
    phi_c: Vec<C64>,
    f: Vec<C64>,
}

impl Parts {
    fn new(m: usize, r: usize) -> Self {
        let q = m + r;
        Self {
            outputs: m,
            inputs: r,
            h: vec![ZERO; m * q],
            m2_inverse: vec![ZERO; m * m],
            m2_h: vec![ZERO; m * q],
            pi: vec![ZERO; q * q],
            c: vec![ZERO; q * q],
            phi_c: vec![ZERO; q * q],
            f: vec![ZERO; q * q],
        }
    }

    fn fill(&mut self, s: &[C64], variances: &[f64]) -> Option<()> {
        let (m, r) = (self.outputs, self.inputs);
        let q = m + r;
        let scaled: Vec<C64> = self
            .h
            .chunks_exact(q)
            .flat_map(|row| row.iter().zip(variances).map(|(h, variance)| h * variance))
            .collect();
        let mut square = vec![ZERO; m * m];
        multiply_adjoint(&mut square, &scaled, &self.h, q, m);
        invert(&mut square, &mut self.m2_inverse, m)?;
        multiply(&mut self.m2_h, &self.m2_inverse, &self.h, m, q);
        for j in 0..q {
            for l in 0..q {
                self.pi[j * q + l] = (0..m)
                    .map(|row| self.h[row * q + j].conj() * self.m2_h[row * q + l])
                    .sum();
            }
        }
        // H^H (r x q), G_ij = -h_i,m+j / h_ii, and D^-1 weighs its columns.
        let mut adjoint = vec![ZERO; r * q];
        for j in 0..r {
            for i in 0..m {
                adjoint[j * q + i] = -(self.h[i * q + m + j] / self.h[i * q + i]).conj();
            }
            adjoint[j * q + m + j] = C64::new(1.0, 0.0);
        }
        let weighted: Vec<C64> = adjoint
            .chunks_exact(q)
            .flat_map(|row| {
                row.iter()
                    .zip(variances)
                    .map(|(value, variance)| value / variance)
            })
            .collect();
        let (mut small, mut j_inverse) = (vec![ZERO; r * r], vec![ZERO; r * r]);
        multiply_adjoint(&mut small, &weighted, &adjoint, q, r);
        invert(&mut small, &mut j_inverse, r)?;
        let mut w_adjoint = vec![ZERO; r * q];
        multiply(&mut w_adjoint, &j_inverse, &weighted, r, q);
        let mut w_s = vec![ZERO; r * q];
        multiply(&mut w_s, &w_adjoint, s, q, q);
        let mut seen = vec![ZERO; r * r];
        multiply_adjoint(&mut seen, &w_s, &w_adjoint, q, r);
        let phi_u: Vec<C64> = seen.iter().zip(&j_inverse).map(|(a, b)| a - b).collect();
        let mut t = vec![ZERO; r * r];
        invert(&mut seen, &mut t, r)?;
        // T W^H, then C = W T W^H, Phi_x C = H Phi_u T W^H, F = H Phi_u T Phi_u H^H.
        let mut t_w = vec![ZERO; r * q];
        multiply(&mut t_w, &t, &w_adjoint, r, q);
        let mut phi_t_w = vec![ZERO; r * q];
        multiply(&mut phi_t_w, &phi_u, &t_w, r, q);
        let mut phi_h = vec![ZERO; r * q];
        multiply(&mut phi_h, &phi_u, &adjoint, r, q);
        let mut t_phi_h = vec![ZERO; r * q];
        multiply(&mut t_phi_h, &t, &phi_h, r, q);
        for j in 0..q {
            for l in 0..q {
                let at = j * q + l;
                let over = |left: &[C64], right: &[C64]| -> C64 {
                    (0..r)
                        .map(|k| left[k * q + j].conj() * right[k * q + l])
                        .sum()
                };
                self.c[at] = over(&w_adjoint, &t_w);
                self.phi_c[at] = over(&adjoint, &phi_t_w);
                self.f[at] = over(&phi_h, &t_phi_h);
            }
        }
        Some(())
    }
}

/// A coordinate takes part in a direction from this share of it on.
const PART: f64 = 1e-6;

/// The covariance from the information of a whole record. Where the information is singular, the
/// entries of the parameters that take part in what the record does not tell are infinite.
pub(super) fn covariance(information: &DMatrix<f64>) -> DMatrix<f64> {
    let count = information.nrows();
    // Scaled to a unit diagonal: coefficients and variances differ by orders of magnitude.
    let scale = information.diagonal().map(|value| {
        let scale = value.sqrt().recip();
        if scale.is_finite() { scale } else { 1.0 }
    });
    let scaled = DMatrix::from_fn(count, count, |i, j| {
        information[(i, j)] * scale[i] * scale[j]
    });
    // A decomposition by Cholesky would let singular matrices pass as often as rounding wants.
    let Some((values, vectors)) = symmetric_eigen(scaled) else {
        return DMatrix::from_element(count, count, f64::INFINITY);
    };
    let floor = count as f64 * f64::EPSILON * values.amax();
    let mut unknown = vec![false; count];
    let mut inverse = DMatrix::zeros(count, count);
    for (vector, &value) in vectors.column_iter().zip(&values) {
        if value > floor {
            inverse.ger(1.0 / value, &vector, &vector, 1.0);
        } else {
            let parts = unknown.iter_mut().zip(&vector);
            parts.for_each(|(unknown, part): (_, &f64)| *unknown |= part.abs() > PART);
        }
    }
    DMatrix::from_fn(count, count, |i, j| {
        if unknown[i] || unknown[j] {
            f64::INFINITY
        } else {
            inverse[(i, j)] * scale[i] * scale[j]
        }
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The variances from an information matrix, by rows.
    fn variances(count: usize, entries: &[f64]) -> Vec<f64> {
        let found = covariance(&DMatrix::from_row_slice(count, count, entries));
        found.diagonal().iter().copied().collect()
    }

    #[test]
    fn a_direction_that_is_not_told_leaves_the_others_their_deviations() {
        // The first two only as their sum, the third alone: 1 / 25, a few roundings off.
        let found = variances(3, &[4.0, 4.0, 0.0, 4.0, 4.0, 0.0, 0.0, 0.0, 25.0]);
        assert!(found[0].is_infinite() && found[1].is_infinite());
        assert!((found[2] - 0.04).abs() < 1e-16, "{found:?}");
        // Nothing is said of the second.
        let found = variances(3, &[4.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 25.0]);
        assert!((found[0] - 0.25).abs() < 1e-15 && (found[2] - 0.04).abs() < 1e-16);
        assert!(found[1].is_infinite());
        // Rank two, where Cholesky ends with a pivot of 5.6e-17 instead of zero.
        let found = variances(3, &[2.0, 3.0, 4.0, 3.0, 5.0, 7.0, 4.0, 7.0, 10.0]);
        assert!(found.iter().all(|value| value.is_infinite()), "{found:?}");
        let found = variances(1, &[f64::NAN]);
        assert!(found[0].is_infinite());
    }
}
