//! Cross-correlation of residuals with inputs, and tests of their independence.

use std::ops::RangeInclusive;

use nalgebra::{DMatrix, DVector};
use serde::{Deserialize, Serialize};

use super::ChiSquareTest;
use super::residuals::{Residuals, Span};
use crate::distributions::normal_quantile;

/// `r(tau) = sum e(t) u(t - tau) / (T sigma_e sigma_u)` of one output and one input.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct CrossCorrelation {
    /// The output's name.
    pub output: String,
    /// The input's name.
    pub input: String,
    /// `tau`, from `-M` to `M` samples: positive for past inputs.
    pub lags: Vec<i64>,
    /// `r(tau)`.
    pub values: Vec<f64>,
    /// Half width of the band at every lag, `z sqrt(P / T)` with `P = sum_k rho_e(k) rho_u(k)`
    /// over the autocorrelations of both (Ljung 1999, section 16.6): that of a model known
    /// beforehand. At lags that are regressors, the record of the fit gives zero.
    pub band: f64,
    /// Test of independence from the past of this input; `None` where no lag is left to test.
    pub independence: Option<ChiSquareTest>,
    /// Test of independence from the present and the future of this input: all lags from `-M` on
    /// that `independence` leaves. It is rejected where the input is fed back from the outputs,
    /// which is no fault of the model, and where an input acts sooner than the model allows.
    pub feedback: Option<ChiSquareTest>,
}

impl CrossCorrelation {
    pub(crate) fn new(
        residuals: &Residuals,
        (output, input): (usize, usize),
        (output_name, input_name): (&str, &str),
        past: RangeInclusive<usize>,
        significance: f64,
    ) -> Self {
        let most = signed(residuals.lags);
        let errors = residuals.errors.column(output);
        let count = errors.len() as f64;
        let input_power = residuals.inputs.column(input).norm_squared();
        let input_power = input_power / residuals.inputs.nrows().max(1) as f64;
        let size = (residuals.covariance[(output, output)] * input_power).sqrt();
        let normalise = |value: f64| if size > 0.0 { value / size } else { 0.0 };
        let lags: Vec<i64> = (-most..=most).collect();
        let values = lags
            .iter()
            .map(|&lag| {
                let shifted = lagged(residuals, input, lag);
                normalise(errors.dot(&shifted) / count)
            })
            .collect();
        let quantile = normal_quantile(1.0 - 0.5 * significance);
        let taper = tapered(errors.as_slice(), residuals.lags);
        let inputs = residuals.inputs.column(input);
        let power: f64 = taper
            .iter()
            .enumerate()
            .map(|(lag, error)| {
                let twice = if lag == 0 { 1.0 } else { 2.0 };
                twice * error * autocovariance(inputs.as_slice(), lag)
            })
            .sum();
        let past_lags: Vec<i64> = past.map(signed).collect();
        let future: Vec<i64> = (-most..past_lags.first().copied().unwrap_or(0)).collect();
        Self {
            output: output_name.to_owned(),
            input: input_name.to_owned(),
            lags,
            values,
            band: quantile * normalise((power.max(0.0) / count).sqrt()),
            independence: independence(residuals, output, &[input], &past_lags),
            feedback: independence(residuals, output, &[input], &future),
        }
    }
}

/// The joint test of independence of an output's residuals from the given lags of the given
/// inputs: `s' V^-1 s` with `s = X' e`, `X` the lagged inputs.
///
/// `V = X' T_e X`, `T_e` the Toeplitz matrix of the errors' autocovariance (Bartlett's window of
/// width `M`), so that neither inputs nor errors need be white (Ljung 1999, eq. 16.71). On the
/// record of the fit the part of `X` in the space of the regressors is removed first, where the
/// residuals are zero by construction; on another record the error of the coefficients adds
/// `(T / T_fit) sigma^2 X' P_Phi X`. The degrees of freedom are the rank of what is left of `X`.
pub(crate) fn independence(
    residuals: &Residuals,
    output: usize,
    inputs: &[usize],
    lags: &[i64],
) -> Option<ChiSquareTest> {
    let columns: Vec<DVector<f64>> = inputs
        .iter()
        .flat_map(|&input| lags.iter().map(move |&lag| lagged(residuals, input, lag)))
        .filter(|column| column.amax() > 0.0)
        .map(|column| column.normalize())
        .collect();
    if columns.is_empty() {
        return None;
    }
    let all = DMatrix::from_columns(&columns);
    let regressors = &residuals.regressors[output].basis;
    let fitted = residuals.estimation < 0.0;
    let basis = if fitted {
        // Twice: once leaves rounding errors where little is left.
        let once = &all - regressors * regressors.tr_mul(&all);
        let mut left = &once - regressors * regressors.tr_mul(&once);
        for mut column in left.column_iter_mut() {
            // The columns had unit length: this is a regressor itself.
            if column.norm() < REGRESSOR_TOLERANCE {
                column.fill(0.0);
            }
        }
        Span::new(&left).basis
    } else {
        Span::new(&all).basis
    };
    let tested = basis.ncols();
    let count = residuals.count();
    let spare = count.saturating_sub(if fitted { regressors.ncols() } else { 0 });
    if tested == 0 || tested >= spare {
        return None;
    }
    let column = residuals.errors.column(output);
    let taper = tapered(column.as_slice(), residuals.lags);
    let mut covariance = basis.tr_mul(&toeplitz(&taper, &basis));
    if fitted {
        covariance *= count as f64 / spare as f64;
    } else {
        let shared = regressors.tr_mul(&basis);
        let variance = residuals.covariance[(output, output)];
        covariance += shared.tr_mul(&shared) * (residuals.estimation * variance);
    }
    let scores = basis.tr_mul(&column);
    let statistic = scores.dot(&covariance.cholesky()?.solve(&scores));
    let plain = columns.len();
    ChiSquareTest::new(statistic, plain, tested as f64 - plain as f64)
}

/// A lagged input of unit length of which less than this is left beside the regressors is taken
/// for one of them.
const REGRESSOR_TOLERANCE: f64 = 1e-6;

/// `u(t - lag)` at the times of the errors; zero (the mean) outside the record.
fn lagged(residuals: &Residuals, input: usize, lag: i64) -> DVector<f64> {
    let column = residuals.inputs.column(input);
    DVector::from_fn(residuals.count(), |row, _| {
        usize::try_from(signed(residuals.first + row) - lag)
            .ok()
            .and_then(|sample| column.get(sample).copied())
            .unwrap_or(0.0)
    })
}

/// Samples and lags are far below `i64::MAX`.
fn signed(count: usize) -> i64 {
    i64::try_from(count).unwrap_or(i64::MAX)
}

/// The mean of `x(t) x(t - lag)`, the sum over all samples divided by their number.
fn autocovariance(values: &[f64], lag: usize) -> f64 {
    let products = values.iter().skip(lag).zip(values).map(|(a, b)| a * b);
    products.sum::<f64>() / values.len().max(1) as f64
}

/// Autocovariances at lags `0..=most` under Bartlett's window, which keeps them positive definite.
fn tapered(values: &[f64], most: usize) -> Vec<f64> {
    (0..=most)
        .map(|lag| {
            let window = 1.0 - lag as f64 / (most + 1) as f64;
            window * autocovariance(values, lag)
        })
        .collect()
}

/// The banded symmetric Toeplitz matrix of `first_row` times a matrix.
fn toeplitz(first_row: &[f64], matrix: &DMatrix<f64>) -> DMatrix<f64> {
    let mut product = matrix * first_row[0];
    let rows = matrix.nrows();
    let columns = product.as_mut_slice().chunks_exact_mut(rows.max(1));
    for (out, column) in columns.zip(matrix.as_slice().chunks_exact(rows.max(1))) {
        for (lag, &value) in first_row.iter().enumerate().take(rows).skip(1) {
            let later = out[lag..].iter_mut().zip(column);
            later.for_each(|(out, entry)| *out += value * entry);
            let earlier = out.iter_mut().zip(&column[lag..]);
            earlier.for_each(|(out, entry)| *out += value * entry);
        }
    }
    product
}
