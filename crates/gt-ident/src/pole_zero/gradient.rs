//! Derivatives of the roots of `det S(z)` by the coefficients of a model.

use nalgebra::{Complex, DMatrix};

use super::{RESOLUTION, Root};
use crate::transfer::{delay, propagate};
use crate::{ArxModel, Channel};

/// A derivative of the determinant below this share of its terms' size counts as zero: the root is
/// a multiple one.
const MULTIPLE_ROOT: f64 = 1e-9;

/// A square part of `[P(z) Q(z)]`: some rows of the model, and one channel for each.
///
/// All outputs as columns give the poles. With output `i` replaced by input `j` they give the
/// zeros of that channel, as `G_ij = det S / det P` by Cramer's rule.
pub(crate) struct Part<'a> {
    pub model: &'a ArxModel,
    pub rows: Vec<usize>,
    pub columns: Vec<Channel>,
}

impl Part<'_> {
    /// The given roots of `det S(z)` with their covariances.
    pub fn with_errors(&self, roots: &[Complex<f64>], covariances: &[DMatrix<f64>]) -> Vec<Root> {
        roots
            .iter()
            .enumerate()
            .map(|(index, &value)| {
                let gradient = self.gradient(value);
                let covariance = gradient.as_ref().map(|rows| {
                    rows.iter()
                        .map(|(row, gradient)| propagate(gradient, &covariances[*row]))
                        .sum()
                });
                let nearest = roots
                    .iter()
                    .enumerate()
                    .filter(|(other, _)| *other != index)
                    .map(|(_, other)| (other - value).norm())
                    .fold(f64::INFINITY, f64::min);
                let resolved = |covariance: &nalgebra::Matrix2<f64>| {
                    covariance.trace().max(0.0).sqrt() * RESOLUTION < nearest
                };
                Root {
                    value,
                    covariance: covariance.filter(resolved),
                    gradient: gradient.unwrap_or_default(),
                }
            })
            .collect()
    }

    /// `dz / dtheta` for the terms of each row: `dz = -tr(adj(S) dS) / tr(adj(S) S'(z))` as
    /// `d det S = tr(adj(S) dS)` (Jacobi). `None` at a multiple root and at the origin.
    fn gradient(&self, z: Complex<f64>) -> Option<Vec<(usize, Vec<Complex<f64>>)>> {
        if z.norm() == 0.0 {
            return None;
        }
        let size = self.rows.len();
        let mut matrix: DMatrix<Complex<f64>> = DMatrix::zeros(size, size);
        let mut slope: DMatrix<Complex<f64>> = DMatrix::zeros(size, size);
        let mut scales = Vec::with_capacity(size);
        for (position, &row) in self.rows.iter().enumerate() {
            let terms = &self.model.rows()[row].terms;
            let longest = terms.iter().map(|term| term.lag).max().unwrap_or(0);
            // A row times a constant has the same roots; this one keeps the powers near 1.
            let scale = Complex::new(1.0 / delay(z, longest).norm().max(1.0), 0.0);
            scales.push(scale);
            if let Some(column) = self.column(Channel::Output(row)) {
                matrix[(position, column)] += scale;
            }
            for term in terms {
                if let Some(column) = self.column(term.channel) {
                    let power = delay(z, term.lag) * scale;
                    matrix[(position, column)] -= power * term.coefficient;
                    slope[(position, column)] += power / z * (term.coefficient * term.lag as f64);
                }
            }
        }
        let mut numbers = matrix.iter().chain(slope.iter());
        if !numbers.all(|value| value.re.is_finite() && value.im.is_finite()) {
            return None;
        }
        let adjugate = adjugate(&matrix);
        let along = (&adjugate * &slope).trace();
        if along.norm() <= MULTIPLE_ROOT * adjugate.norm() * slope.norm() {
            return None;
        }
        let rows = self.rows.iter().enumerate().map(|(position, &row)| {
            let terms = self.model.rows()[row].terms.iter();
            let derivatives = terms
                .map(|term| match self.column(term.channel) {
                    Some(column) => {
                        let power = delay(z, term.lag) * scales[position];
                        adjugate[(column, position)] * power / along
                    }
                    None => Complex::new(0.0, 0.0),
                })
                .collect();
            (row, derivatives)
        });
        Some(rows.collect())
    }

    fn column(&self, channel: Channel) -> Option<usize> {
        self.columns.iter().position(|&column| column == channel)
    }
}

/// The adjugate, minor by minor: it exists for a singular matrix too, and the systems have as many
/// rows as the model has outputs.
fn adjugate(matrix: &DMatrix<Complex<f64>>) -> DMatrix<Complex<f64>> {
    let size = matrix.nrows();
    DMatrix::from_fn(size, size, |row, column| {
        let minor = matrix.clone().remove_row(column).remove_column(row);
        let sign = if (row + column) % 2 == 0 { 1.0 } else { -1.0 };
        minor.determinant() * sign
    })
}
