//! The denominator of one output's row and its poles.

use gt_core::{ModelError, StateSpace};
use nalgebra::{Complex, DMatrix};

/// `A(z) = 1 + a_1 z^-1 + .. + a_n z^-n`; the own-output coefficients of a row are `-a_k`.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Denominator {
    a: Vec<f64>,
}

impl Denominator {
    /// From the coefficients of the output's own lags `1..=n`.
    pub fn from_own_lags(coefficients: &[f64]) -> Self {
        Self {
            a: coefficients.iter().map(|value| -value).collect(),
        }
    }

    /// From its poles, which come in conjugate pairs.
    pub fn from_poles(poles: &[Complex<f64>]) -> Self {
        let mut product = vec![Complex::new(1.0, 0.0)];
        for pole in poles {
            product.push(Complex::new(0.0, 0.0));
            for k in (1..product.len()).rev() {
                product[k] = product[k] - pole * product[k - 1];
            }
        }
        Self {
            a: product[1..].iter().map(|value| value.re).collect(),
        }
    }

    /// The coefficients of the output's own lags: `-a_k`.
    pub fn own_lags(&self) -> impl Iterator<Item = f64> + '_ {
        self.a.iter().map(|value| -value)
    }

    /// The polynomial whose poles are these divided by `radius`: `a_k / radius^k`.
    #[must_use]
    pub fn divided(&self, radius: f64) -> Self {
        let mut power = 1.0;
        let scaled = self.a.iter().map(|value| {
            power /= radius;
            value * power
        });
        Self {
            a: scaled.collect(),
        }
    }

    /// The poles, with multiplicity.
    pub fn poles(&self) -> Result<Vec<Complex<f64>>, ModelError> {
        let n = self.a.len();
        let companion = DMatrix::from_fn(n, n, |row, column| match (row, column) {
            (0, _) => -self.a[column],
            _ => f64::from(u8::from(row == column + 1)),
        });
        let none = |rows, columns| DMatrix::zeros(rows, columns);
        let matrices = [companion, none(n, 0), none(0, n), none(0, 0)];
        StateSpace::new(matrices, 1.0, Vec::new(), Vec::new())?.poles()
    }

    /// The largest modulus of a pole; 0 without poles.
    pub fn radius(&self) -> Result<f64, ModelError> {
        let poles = self.poles()?;
        Ok(poles.iter().map(|pole| pole.norm()).fold(0.0, f64::max))
    }

    /// `A(e^{j omega})`.
    pub fn response(&self, omega: f64) -> Complex<f64> {
        let step = Complex::from_polar(1.0, -omega);
        self.a
            .iter()
            .rev()
            .fold(Complex::new(0.0, 0.0), |sum, &a| (sum + a) * step)
            + 1.0
    }
}
