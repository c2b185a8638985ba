//! Covariances of lagged channels, weighted over the frequencies.

use nalgebra::{DMatrix, DVector};

use super::hermitian::C64;
use super::row::EivLags;
use super::spectrum::{Spectrum, phases};

/// The lagged channels of one output, `phi(t) = [y(t)..y(t-n), u_1(t-nk_1)..u_1(t-n), ..]`, as
/// pairs (channel, lag); a relation is `theta_bar = [1, a, -b_1, -b_2, ..]` on them.
pub(super) fn columns(lags: &EivLags) -> Vec<(usize, usize)> {
    let mut columns: Vec<_> = (0..=lags.order()).map(|lag| (0, lag)).collect();
    for (input, &nk) in lags.nk().iter().enumerate() {
        columns.extend((nk..=lags.order()).map(|lag| (input + 1, lag)));
    }
    columns
}

/// The spectrum of one output and the inputs, with what its moments need.
pub(super) struct Moments<'a> {
    spectrum: &'a Spectrum,
    columns: Vec<(usize, usize)>,
    longest: usize,
    phases: Vec<C64>,
}

impl<'a> Moments<'a> {
    pub fn new(spectrum: &'a Spectrum, lags: &EivLags) -> Self {
        let longest = lags.order();
        Self {
            spectrum,
            columns: columns(lags),
            longest,
            phases: phases(spectrum.frequencies(), longest),
        }
    }

    pub fn frequencies(&self) -> usize {
        self.spectrum.frequencies()
    }

    /// The spectrum of the output at every frequency.
    pub fn output_spectrum(&self) -> Vec<f64> {
        let frequencies = 0..self.frequencies();
        let first = frequencies.map(|index| self.spectrum.matrix(index)[0].re);
        first.collect()
    }

    pub fn columns(&self) -> &[(usize, usize)] {
        &self.columns
    }

    /// `mean_w weight(w) Re[phi(w) phi(w)^H]`, for which
    /// `theta_bar^T (..) theta_bar = mean_w weight h S h^H`.
    pub fn signal(&self, weight: &[f64]) -> DMatrix<f64> {
        let q = self.spectrum.channels();
        // rho_cd(+-lag) is an even and an odd part.
        let (mut even, mut odd) = (self.correlations(), self.correlations());
        let stride = self.longest + 1;
        for (index, &weight) in weight.iter().enumerate() {
            let matrix = self.spectrum.matrix(index);
            let phases = &self.phases[index * stride..(index + 1) * stride];
            // rho_dc(lag) = rho_cd(-lag): the pairs c <= d hold everything.
            let upper = (0..q).flat_map(|c| (c..q).map(move |d| c * q + d));
            for pair in upper {
                let value = matrix[pair] * weight;
                for (lag, phase) in phases.iter().enumerate() {
                    even[pair * stride + lag] += value.re * phase.re;
                    odd[pair * stride + lag] -= value.im * phase.im;
                }
            }
        }
        let count = weight.len() as f64;
        self.assemble(|c, d, k, l| {
            let at = (c.min(d) * q + c.max(d)) * stride + k.abs_diff(l);
            let sign = if (k >= l) == (c <= d) { 1.0 } else { -1.0 };
            (even[at] + sign * odd[at]) / count
        })
    }

    /// The same of white noise with the given variances.
    pub fn noise(&self, weight: &[f64], variances: &[f64]) -> DMatrix<f64> {
        let stride = self.longest + 1;
        let mut sums = vec![0.0; stride];
        for (weight, phases) in weight.iter().zip(self.phases.chunks_exact(stride)) {
            for (sum, phase) in sums.iter_mut().zip(phases) {
                *sum += weight * phase.re;
            }
        }
        let count = weight.len() as f64;
        self.assemble(|c, d, k, l| {
            if c == d {
                variances[c] * sums[k.abs_diff(l)] / count
            } else {
                0.0
            }
        })
    }

    /// `1 / (h D h^H)` at every frequency, up to a factor.
    pub fn weight(&self, relation: &DVector<f64>, variances: &[f64]) -> Vec<f64> {
        let stride = self.longest + 1;
        let mut response = vec![C64::new(0.0, 0.0); variances.len()];
        let weight = self.phases.chunks_exact(stride).map(|phases| {
            response.fill(C64::new(0.0, 0.0));
            for (&(channel, lag), &value) in self.columns.iter().zip(relation.iter()) {
                response[channel] += phases[lag] * value;
            }
            let sum: f64 = response
                .iter()
                .zip(variances)
                .map(|(value, variance)| value.norm_sqr() * variance)
                .sum();
            1.0 / sum
        });
        weight.collect()
    }

    /// The largest noise variance of each channel, alone, that the covariance admits:
    /// `1 / lambda_max[(Sigma^-1)_jj]` over the channel's block (the intercepts of the Frisch
    /// surface).
    pub fn largest_variances(&self) -> Option<Vec<f64>> {
        let uniform = vec![1.0; self.spectrum.frequencies()];
        let inverse = self.signal(&uniform).cholesky()?.inverse();
        let channels = 0..self.spectrum.channels();
        let largest = channels.map(|channel| {
            let own: Vec<usize> = (0..self.columns.len())
                .filter(|&index| self.columns[index].0 == channel)
                .collect();
            let block = DMatrix::from_fn(own.len(), own.len(), |i, j| inverse[(own[i], own[j])]);
            if !block.iter().all(|value| value.is_finite()) {
                return None;
            }
            let largest = block.symmetric_eigenvalues().max();
            (largest > 0.0 && largest.is_finite()).then(|| 1.0 / largest)
        });
        largest.collect()
    }

    fn correlations(&self) -> Vec<f64> {
        let q = self.spectrum.channels();
        vec![0.0; q * q * (self.longest + 1)]
    }

    fn assemble(&self, value: impl Fn(usize, usize, usize, usize) -> f64) -> DMatrix<f64> {
        let size = self.columns.len();
        DMatrix::from_fn(size, size, |i, j| {
            let ((c, k), (d, l)) = (self.columns[i], self.columns[j]);
            value(c, d, k, l)
        })
    }
}
