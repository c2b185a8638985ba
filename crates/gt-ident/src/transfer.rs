//! The rows of an ARX model at one complex frequency, and what their coefficients do there.
//!
//! With `z` in place of the shift operator the rows are `P(z) Y = Q(z) U`, both polynomials in
//! `1 / z`: `P_ii = 1 - sum a z^-lag`, `P_ij = -sum a z^-lag`, `Q_ij = sum b z^-lag`.

use nalgebra::{Complex, DMatrix, Matrix2, Vector2};

use crate::{ArxModel, Channel, Term};

/// `z^-lag`.
pub(crate) fn delay(z: Complex<f64>, lag: usize) -> Complex<f64> {
    match i32::try_from(lag) {
        Ok(lag) => z.powi(-lag),
        Err(_) => z.powf(-(lag as f64)),
    }
}

/// The transfer matrix at one `z`, with what it takes to differentiate it.
pub(crate) struct Transfer {
    z: Complex<f64>,
    /// `G (ny x nu)`.
    pub gain: DMatrix<Complex<f64>>,
    /// `P^-1 (ny x ny)`.
    inverse: DMatrix<Complex<f64>>,
}

impl Transfer {
    /// `G = P^-1 Q`; `None` at a pole.
    pub fn new(model: &ArxModel, z: Complex<f64>) -> Option<Self> {
        let (nu, ny) = (model.inputs().len(), model.outputs().len());
        let mut p: DMatrix<Complex<f64>> = DMatrix::identity(ny, ny);
        let mut q: DMatrix<Complex<f64>> = DMatrix::zeros(ny, nu);
        for (output, row) in model.rows().iter().enumerate() {
            for term in &row.terms {
                let value = delay(z, term.lag) * term.coefficient;
                match term.channel {
                    Channel::Output(other) => p[(output, other)] -= value,
                    Channel::Input(input) => q[(output, input)] += value,
                }
            }
        }
        let inverse = p.try_inverse()?;
        let gain: DMatrix<Complex<f64>> = &inverse * q;
        let numbers = inverse.iter().chain(gain.iter());
        let mut finite = numbers.map(|value| value.re.is_finite() && value.im.is_finite());
        finite.all(|one| one).then_some(Self { z, gain, inverse })
    }

    /// The derivative of `G[(output, input)]` by the coefficient of a term of row `row`:
    /// `(P^-1)[(output, row)] z^-lag` times the response of the term's channel to the input.
    fn derivative(&self, at: (usize, usize), row: usize, term: &Term) -> Complex<f64> {
        let (output, input) = at;
        let channel = match term.channel {
            Channel::Output(other) => self.gain[(other, input)],
            Channel::Input(other) if other == input => Complex::new(1.0, 0.0),
            Channel::Input(_) => return Complex::new(0.0, 0.0),
        };
        self.inverse[(output, row)] * delay(self.z, term.lag) * channel
    }

    /// The covariance of the real and imaginary part of `G[(output, input)]`.
    pub fn covariance(
        &self,
        model: &ArxModel,
        covariances: &[DMatrix<f64>],
        at: (usize, usize),
    ) -> Matrix2<f64> {
        let mut total = Matrix2::zeros();
        for (row, (terms, covariance)) in model.rows().iter().zip(covariances).enumerate() {
            let gradient: Vec<Complex<f64>> = terms
                .terms
                .iter()
                .map(|term| self.derivative(at, row, term))
                .collect();
            total += propagate(&gradient, covariance);
        }
        total
    }
}

/// `J Sigma J'` of a complex function with the given derivatives, as covariance of its real and
/// imaginary part.
pub(crate) fn propagate(gradient: &[Complex<f64>], covariance: &DMatrix<f64>) -> Matrix2<f64> {
    let mut total = Matrix2::zeros();
    for (i, left) in gradient.iter().enumerate() {
        let mut sum = Vector2::zeros();
        for (j, right) in gradient.iter().enumerate() {
            sum += Vector2::new(right.re, right.im) * covariance[(i, j)];
        }
        total += Vector2::new(left.re, left.im) * sum.transpose();
    }
    total
}

/// The standard error of a real function of a complex number of which the real and imaginary part
/// have the given covariance and derivatives.
pub(crate) fn standard_error(derivatives: [f64; 2], covariance: &Matrix2<f64>) -> f64 {
    let gradient = Vector2::from(derivatives);
    (covariance * gradient).dot(&gradient).max(0.0).sqrt()
}
