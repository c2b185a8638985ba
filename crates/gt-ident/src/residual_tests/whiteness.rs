//! Portmanteau tests of whiteness.

use nalgebra::DMatrix;

use super::ChiSquareTest;
use super::autocorrelation::Autocorrelation;
use super::residuals::Residuals;

/// The test of Ljung and Box (1978): `T (T + 2) sum_k r_k^2 / (T - k)`.
///
/// The fit changes the covariance of the correlations from `I` to `I - K` with
/// `K_kl = D_k' Sigma^-1 D_l / sigma^2`, `D_k = E[phi(t) e(t - k)]`, `Sigma = E[phi phi']`; on
/// another record it is `I + K T / T_fit`. The law is the scaled chi-square of the same mean and
/// variance. Without inputs `K` is close to a projection of rank `na`, and `na` degrees of freedom
/// go, as usual; inputs that move the outputs more than the errors do make `K` smaller.
pub(crate) fn ljung_box(
    residuals: &Residuals,
    autocorrelation: &Autocorrelation,
    output: usize,
) -> Option<ChiSquareTest> {
    let count = residuals.count() as f64;
    let sum: f64 = autocorrelation
        .values
        .iter()
        .zip(1..)
        .map(|(value, lag): (&f64, usize)| value * value / (count - lag as f64))
        .sum();
    let deviation = residuals.covariance[(output, output)].sqrt();
    let columns: Vec<_> = (1..=residuals.lags)
        .map(|lag| {
            let follows = residuals.past_errors_in_regressors(output, lag);
            follows.column(output) / deviation
        })
        .collect();
    let effect = Effect::new(&DMatrix::from_columns(&columns));
    effect.test(residuals, count * (count + 2.0) * sum, residuals.lags)
}

/// The joint test of Hosking (1980):
/// `T^2 sum_k tr(C_k' C_0^-1 C_k C_0^-1) / (T - k)` with `C_k` the mean of `e(t) e(t - k)'`.
///
/// What the fit changes is counted row by row as in the test of Ljung and Box, with the past errors
/// of all outputs: exact where the rows share their regressors or their errors are not correlated.
/// `None` where the errors of one output follow from those of the others.
pub(crate) fn hosking(residuals: &Residuals) -> Option<ChiSquareTest> {
    let (count, outputs) = residuals.errors.shape();
    let factor = residuals.covariance.clone().cholesky()?.unpack();
    // Errors of unit covariance: L^-1 e.
    let mut white = residuals.errors.transpose();
    if !factor.solve_lower_triangular_mut(&mut white) {
        return None;
    }
    let mut statistic = 0.0;
    for lag in 1..=residuals.lags {
        let (now, past) = (
            white.columns(lag, count - lag),
            white.columns(0, count - lag),
        );
        let covariance: DMatrix<f64> = now * past.transpose() / count as f64;
        statistic += covariance.norm_squared() / (count - lag) as f64;
    }
    statistic *= (count as f64).powi(2);
    let mut effect = Effect::default();
    for output in 0..outputs {
        let mut columns = Vec::with_capacity(outputs * residuals.lags);
        for lag in 1..=residuals.lags {
            let follows = residuals.past_errors_in_regressors(output, lag);
            let mut follows = follows.transpose();
            if !factor.solve_lower_triangular_mut(&mut follows) {
                return None;
            }
            columns.extend(follows.row_iter().map(|row| row.transpose()));
        }
        let row = Effect::new(&DMatrix::from_columns(&columns));
        effect.trace += row.trace;
        effect.squares += row.squares;
    }
    effect.test(residuals, statistic, outputs * outputs * residuals.lags)
}

/// `tr K` and `tr K^2` of what the estimation does to the covariance of correlations.
#[derive(Default)]
struct Effect {
    trace: f64,
    squares: f64,
}

impl Effect {
    /// Of `K = B' B`.
    fn new(root: &DMatrix<f64>) -> Self {
        Self {
            trace: root.norm_squared(),
            squares: (root * root.transpose()).norm_squared(),
        }
    }

    fn test(&self, residuals: &Residuals, statistic: f64, count: usize) -> Option<ChiSquareTest> {
        let sign = residuals.estimation;
        let mean = count as f64 + sign * self.trace;
        let spread = mean + sign * self.trace + sign * sign * self.squares;
        ChiSquareTest::matched(statistic, count, mean, spread)
    }
}
