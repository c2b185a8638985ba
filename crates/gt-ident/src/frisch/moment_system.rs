//! The moment equations of an errors-in-variables relation and the covariance of their errors.

use nalgebra::{Cholesky, DMatrix, DVector};

use super::covariance::{LaggedCovariance, ScaledRecord};
use super::criterion::residual_covariance;
use super::surface::{SurfacePoint, channel_terms, regression_vector};
use crate::eiv::EivLags;
use crate::least_squares::triangular_factor;
use crate::symmetric::symmetric_eigen;

/// The least part that the second term of the moments' covariance leaves of the first.
const LEAST_PART: f64 = 0.01;

/// `g = (E z phi' - sum_j sigma_j^2 E_j) c`, zero at the truth, with `z` all channels at lags
/// `0..=max_lag` and `E_j` one where an entry of `z` is an entry of `phi` of channel `j`.
pub(crate) struct MomentSystem {
    lags: EivLags,
    phi: Vec<(usize, usize)>,
    z: Vec<(usize, usize)>,
    /// `E z phi'`.
    cross: DMatrix<f64>,
    /// `E z(t) z(t-k)'` of the channels, `k = 0..=max_lag + n`, from the whole record.
    autocovariance: Vec<DMatrix<f64>>,
    window_rows: usize,
}

/// Moments and their derivatives, both multiplied by the inverse square root of the covariance of
/// the moments' errors times the window rows.
pub(crate) struct Whitened {
    /// `m`.
    pub moments: DVector<f64>,
    /// `m x (p + 1 + nu)`: by the coefficients and by the variances.
    pub jacobian: DMatrix<f64>,
}

impl MomentSystem {
    pub fn new(lags: &EivLags, record: &ScaledRecord, covariance: &LaggedCovariance) -> Self {
        let phi = regression_vector(lags);
        let max_lag = covariance.max_lag();
        let z: Vec<(usize, usize)> = (0..=lags.inputs())
            .flat_map(|channel| (0..=max_lag).map(move |lag| (channel, lag)))
            .collect();
        let cross = covariance.columns(&z).tr_mul(&covariance.columns(&phi));
        Self {
            lags: lags.clone(),
            phi,
            z,
            cross,
            autocovariance: record.autocovariance(max_lag + lags.order()),
            window_rows: covariance.window_rows(),
        }
    }

    /// Number of moments less number of unknowns.
    pub fn surplus(&self) -> usize {
        let unknowns = self.lags.parameters() + 1 + self.lags.inputs();
        self.z.len().saturating_sub(unknowns)
    }

    /// Number of coefficients of the output.
    pub fn own_terms(&self) -> usize {
        self.lags.order()
    }

    /// The standard errors of the coefficients and the variances in the optimally weighted
    /// estimate, from `(G' S^-1 G)^-1 / T` at a point; `None` where the moments do not determine
    /// them.
    ///
    /// The inverse of a covariance of `m` moments estimated from `T` rows is too large by
    /// `T / (T - m - 1)` (the mean of the inverse Wishart distribution), which is made good.
    pub fn errors(&self, point: &SurfacePoint) -> Option<DVector<f64>> {
        let whitened = self.whiten(point, &self.weight_root(point)?)?;
        let information = whitened.jacobian.tr_mul(&whitened.jacobian);
        let left = self.window_rows.checked_sub(self.z.len() + 1)?;
        let inflation = self.window_rows as f64 / left as f64;
        let covariance = Cholesky::new(information)?.inverse() * inflation;
        let errors = covariance.diagonal().map(f64::sqrt);
        errors
            .iter()
            .all(|error| error.is_finite())
            .then_some(errors)
    }

    /// The lower Cholesky factor of `S / T`, the covariance of the moments' errors at a point:
    /// `S = sum_tau r(tau) R_z(tau) + sum_tau h(tau) h(-tau)'` for Gaussian noise, with `r` the
    /// autocovariance of the residual and `h(tau) = E z(t) e(t + tau)`.
    ///
    /// Where a variance exceeds what the spectrum of its channel leaves at some frequency, no
    /// process is like that, and the sum need not be definite: the second term then counts only
    /// as far as it leaves a part of the first in every direction.
    pub fn weight_root(&self, point: &SurfacePoint) -> Option<DMatrix<f64>> {
        let size = self.z.len();
        let mut first = DMatrix::zeros(size, size);
        let mut second = DMatrix::zeros(size, size);
        for tau in 0..=self.lags.order() {
            let scaled = self.lagged(tau) * residual_covariance(&self.lags, point, tau);
            let behind = self.residual_cross(point, tau, false);
            let product = self.residual_cross(point, tau, true) * behind.transpose();
            if tau > 0 {
                first += scaled.transpose();
                second += product.transpose();
            }
            first += scaled;
            second += product;
        }
        let finite = |s: &DMatrix<f64>| s.iter().all(|value| value.is_finite());
        if !(finite(&first) && finite(&second)) {
            return None;
        }
        // I + M with S = L (I + M) L'.
        let lower = Cholesky::new(first)?.unpack();
        let half = lower.solve_lower_triangular(&second)?;
        let relative = lower.solve_lower_triangular(&half.transpose())?;
        let (values, vectors) = symmetric_eigen((&relative + relative.transpose()) * 0.5)?;
        let mut scaled = vectors.transpose();
        for (mut row, value) in scaled.row_iter_mut().zip(values.iter()) {
            row *= (1.0 + value).max(LEAST_PART).sqrt();
        }
        let root = triangular_factor(&(scaled * lower.transpose())).transpose();
        Some(root / (self.window_rows as f64).sqrt())
    }

    /// Moments and derivatives at a point.
    pub fn whiten(&self, point: &SurfacePoint, root: &DMatrix<f64>) -> Option<Whitened> {
        let (c, p) = (&point.relation, self.lags.parameters());
        let mut compensated = self.cross.clone();
        let mut by_variance = DMatrix::zeros(self.z.len(), point.variances.len());
        for (column, &(channel, lag)) in self.phi.iter().enumerate() {
            if let Some(row) = self.z.iter().position(|&entry| entry == (channel, lag)) {
                compensated[(row, column)] -= point.variances[channel];
                by_variance[(row, channel)] -= c[column];
            }
        }
        let moments = &compensated * c;
        let mut jacobian = DMatrix::zeros(self.z.len(), p + point.variances.len());
        jacobian
            .columns_mut(0, p)
            .copy_from(&compensated.columns(1, p));
        // The coefficients of the inputs enter the relation with a minus.
        let own = self.lags.order();
        jacobian.columns_mut(own, p - own).neg_mut();
        jacobian
            .columns_mut(p, point.variances.len())
            .copy_from(&by_variance);
        Some(Whitened {
            moments: root.solve_lower_triangular(&moments)?,
            jacobian: root.solve_lower_triangular(&jacobian)?,
        })
    }

    /// `E z(t) z(t + tau)'`.
    fn lagged(&self, tau: usize) -> DMatrix<f64> {
        DMatrix::from_fn(self.z.len(), self.z.len(), |row, column| {
            let ((i, a), (j, b)) = (self.z[row], self.z[column]);
            // z_i(t - a) z_j(t + tau - b)
            if b >= a + tau {
                self.autocovariance[b - a - tau][(i, j)]
            } else {
                self.autocovariance[a + tau - b][(j, i)]
            }
        })
    }

    /// `h(tau)` or, not `ahead`, `h(-tau)`.
    fn residual_cross(&self, point: &SurfacePoint, tau: usize, ahead: bool) -> DVector<f64> {
        let mut first = Vec::with_capacity(point.variances.len());
        let mut next = 0;
        for channel in 0..point.variances.len() {
            first.push(next);
            next += channel_terms(&self.lags, channel);
        }
        let smallest = |channel: usize| match channel.checked_sub(1) {
            None => 0,
            Some(input) => self.lags.nk()[input],
        };
        DVector::from_iterator(
            self.z.len(),
            self.z.iter().map(|&(channel, k)| {
                let lag = if ahead {
                    Some(k + tau)
                } else {
                    k.checked_sub(tau)
                };
                let index = lag.and_then(|lag| lag.checked_sub(smallest(channel)));
                match index {
                    Some(index) if index < channel_terms(&self.lags, channel) => {
                        point.variances[channel] * point.relation[first[channel] + index]
                    }
                    _ => 0.0,
                }
            }),
        )
    }
}
