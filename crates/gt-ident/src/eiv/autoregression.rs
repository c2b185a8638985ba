//! A vector autoregression of the measured channels, and its spectrum.

use faer::Side;
use gt_core::la::as_faer;
use nalgebra::DMatrix;

use super::hermitian::{C64, ZERO};
use super::spectrum::{Spectrum, phases};
use crate::IdentError;

/// The smallest part of a channel's variance, relative to it, that the past and the other channels
/// may leave unexplained. Below it the products of the channels no longer tell noise from
/// rounding; white noise of -90 dB on each channel leaves 100 times as much.
pub const NOISE_FLOOR: f64 = 1e-11;

/// A vector autoregression `z(t) = sum_l A_l z(t - l) + e(t)`, `l = 1..=p`.
pub(super) struct Autoregression {
    /// `[A_1 .. A_p]` (`q x p q`).
    pub coefficients: DMatrix<f64>,
    /// Covariance of `e` (`q x q`): the sum of squares over the rows. With this divisor the
    /// spectrum has no bias of first order in `p q / N`: the errors of the coefficients add what
    /// the fit takes away (derived here).
    pub covariance: DMatrix<f64>,
}

impl Autoregression {
    /// Fits by least squares on the rows `t = p..N` of `z (N x q)`, whose channels have mean 0 and
    /// deviation 1.
    ///
    /// The products of lagged channels are updated from lag to lag (a hundredth of the work of a
    /// QR factorisation). Their condition is the square of the record's, which [`NOISE_FLOOR`]
    /// bounds: white noise on every channel is the premise of the model.
    ///
    /// # Errors
    /// The position of the channel that the others and the past determine, and the part of its
    /// variance that is left.
    pub fn fit(z: &DMatrix<f64>, order: usize) -> Result<Self, (usize, f64)> {
        let (samples, q) = z.shape();
        let past = order * q;
        let products = products(z, order);
        let rows = (samples - order) as f64;
        let factor = match as_faer(&products).llt(Side::Lower) {
            Ok(factor) => gt_core::la::to_nalgebra(factor.L()),
            Err(faer::linalg::cholesky::llt::factor::LltError::NonPositivePivot { index }) => {
                return Err((index.min(past + q - 1) % q, 0.0));
            }
        };
        for index in 0..past + q {
            let left = factor[(index, index)].powi(2) / products[(index, index)];
            if left.is_nan() || left < NOISE_FLOOR {
                return Err((index % q, left));
            }
        }
        // A L11 = L21: rows of A by substitution from the last lag back.
        let mut coefficients = factor.view((past, 0), (q, past)).transpose();
        let square = factor.view((0, 0), (past, past));
        square.tr_solve_lower_triangular_mut(&mut coefficients);
        let last = factor.view((past, past), (q, q));
        Ok(Self {
            coefficients: coefficients.transpose(),
            covariance: last * last.transpose() / rows,
        })
    }

    /// `S(w)^-1 = A(w)^H covariance^-1 A(w)` with `A(w) = I - sum_l A_l exp(-j w l)`.
    ///
    /// # Errors
    /// [`IdentError::SpectrumNotPositive`] where rounding leaves no positive definite matrix.
    pub fn spectrum(&self, frequencies: usize) -> Result<Spectrum, IdentError> {
        let q = self.covariance.nrows();
        let order = self.coefficients.ncols() / q;
        let Some(factor) = self.covariance.clone().cholesky() else {
            return Err(IdentError::SpectrumNotPositive { index: 0 });
        };
        // Whitened: L^-1 A_l, so that the inverse is a product of one matrix with its adjoint.
        let lower = factor.l();
        let mut whitened = DMatrix::identity(q, q * (order + 1));
        whitened
            .columns_mut(q, q * order)
            .copy_from(&(-&self.coefficients));
        lower.solve_lower_triangular_mut(&mut whitened);
        let phases = phases(frequencies, order);
        let mut inverses = vec![ZERO; frequencies * q * q];
        let mut response = vec![ZERO; q * q];
        for (phases, inverse) in phases
            .chunks_exact(order + 1)
            .zip(inverses.chunks_exact_mut(q * q))
        {
            response.fill(ZERO);
            for (lag, &phase) in phases.iter().enumerate() {
                for column in 0..q {
                    let source = whitened.column(lag * q + column);
                    for (row, &value) in source.iter().enumerate() {
                        response[row * q + column] += phase * value;
                    }
                }
            }
            for i in 0..q {
                for j in 0..q {
                    inverse[i * q + j] = (0..q)
                        .map(|k| response[k * q + i].conj() * response[k * q + j])
                        .sum::<C64>();
                }
            }
        }
        Spectrum::from_inverses(inverses, q)
    }
}

/// `sum_t x(t) x(t)^T` over `t = p..N` with `x(t) = (z(t-1), .., z(t-p), z(t))`.
fn products(z: &DMatrix<f64>, order: usize) -> DMatrix<f64> {
    let (samples, q) = z.shape();
    let column = |channel: usize| &z.as_slice()[channel * samples..(channel + 1) * samples];
    let place = |lag: usize, channel: usize| {
        let block = if lag == 0 { order } else { lag - 1 };
        block * q + channel
    };
    let size = (order + 1) * q;
    let mut products = DMatrix::zeros(size, size);
    for i in 0..q {
        for j in 0..q {
            let now = &column(i)[order..];
            let mut previous = Vec::with_capacity(order + 1);
            for lag in 0..=order {
                let then = &column(j)[order - lag..samples - lag];
                let sum = dot(now, then);
                previous.push(sum);
                products[(place(0, i), place(lag, j))] = sum;
                products[(place(lag, j), place(0, i))] = sum;
            }
            // Lags (k + 1, l + 1) sum one sample earlier at both ends than lags (k, l).
            for (offset, mut sum) in previous.into_iter().enumerate() {
                for k in 0..order - offset {
                    let l = k + offset;
                    let (first, last) = (order - 1, samples - 1);
                    sum += column(i)[first - k] * column(j)[first - l]
                        - column(i)[last - k] * column(j)[last - l];
                    products[(place(k + 1, i), place(l + 1, j))] = sum;
                    products[(place(l + 1, j), place(k + 1, i))] = sum;
                }
            }
        }
    }
    products
}

/// Eight running sums, which the compiler turns into vector instructions.
fn dot(left: &[f64], right: &[f64]) -> f64 {
    let (mut sums, lanes) = ([0.0; 8], 8);
    let (left_chunks, right_chunks) = (left.chunks_exact(lanes), right.chunks_exact(lanes));
    let rest = left_chunks.remainder().iter().zip(right_chunks.remainder());
    let rest: f64 = rest.map(|(a, b)| a * b).sum();
    for (left, right) in left_chunks.zip(right_chunks) {
        for ((sum, a), b) in sums.iter_mut().zip(left).zip(right) {
            *sum += a * b;
        }
    }
    sums.iter().sum::<f64>() + rest
}
