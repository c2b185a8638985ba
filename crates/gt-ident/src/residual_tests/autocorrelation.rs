//! Autocorrelation of the residuals of one output.

use serde::{Deserialize, Serialize};

use super::residuals::Residuals;
use crate::distributions::normal_quantile;

/// `r_k = sum e(t) e(t - k) / sum e(t)^2` of one output, with the band that white errors keep to.
///
/// The errors are taken about zero: an offset is an error of the model.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Autocorrelation {
    /// The output's name.
    pub output: String,
    /// `r_k` for `k = 1..=M`.
    pub values: Vec<f64>,
    /// Half width of the band at each lag, `1..=M`. It is `z / sqrt(T)`, narrower at the first
    /// lags on the record of the fit (Box and Pierce 1970: the fit flattens them) and wider on
    /// another one (the error of the coefficients correlates them).
    pub bands: Vec<f64>,
}

impl Autocorrelation {
    pub(crate) fn new(residuals: &Residuals, output: usize, name: &str, significance: f64) -> Self {
        let column = residuals.errors.column(output);
        let errors = column.as_slice();
        let power = residuals.covariance[(output, output)] * errors.len() as f64;
        let quantile = normal_quantile(1.0 - 0.5 * significance);
        let (mut values, mut bands) = (Vec::new(), Vec::new());
        for lag in 1..=residuals.lags {
            let product: f64 = errors[lag..].iter().zip(errors).map(|(a, b)| a * b).sum();
            values.push(product / power);
            let variance = 1.0 + residuals.estimation * share(residuals, output, lag);
            bands.push(quantile * (variance.max(0.0) / errors.len() as f64).sqrt());
        }
        Self {
            output: name.to_owned(),
            values,
            bands,
        }
    }
}

/// What the fit takes from the variance of `r_k`, as a share of `1 / T`: 1 for the first lag of a
/// fitted autoregression of order 1 whose coefficient is 0, 0 for a row without output lags.
fn share(residuals: &Residuals, output: usize, lag: usize) -> f64 {
    let follows = residuals.past_errors_in_regressors(output, lag);
    let variance = residuals.covariance[(output, output)];
    (follows.column(output).norm_squared() / variance).clamp(0.0, 1.0)
}
