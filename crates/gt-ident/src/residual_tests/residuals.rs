//! The equation errors of a model on a record, with what its coefficients do to them.

use gt_core::Dataset;
use gt_core::la::{as_faer, to_nalgebra};
use nalgebra::DMatrix;

use super::{RecordOrigin, ResidualOptions};
use crate::parameter_covariance::regressor_matrix;
use crate::{ArxModel, Channel, IdentError};

/// Residuals below this many times the size of the record are rounding, not noise.
const ROUNDING: f64 = 1e-12;

/// Directions of a matrix of lagged channels below this many times its largest singular value are
/// linear combinations of the others.
const RANK_TOLERANCE: f64 = 1e-7;

/// Equation errors and the regressors of each row.
pub(crate) struct Residuals {
    /// The errors (`T x ny`), a channel a column.
    pub errors: DMatrix<f64>,
    /// `Lambda (ny x ny)`, the mean of `e e'`.
    pub covariance: DMatrix<f64>,
    /// The inputs (`N x nu`) without their means.
    pub inputs: DMatrix<f64>,
    /// The sample of the first error.
    pub first: usize,
    /// The largest lag `M`.
    pub lags: usize,
    /// How the regressors of each output's row span the errors' space.
    pub regressors: Vec<Span>,
    /// `-1` on the record of the fit, `T / T_fit` on another: the sign and the size of what the
    /// estimation error does to sums of squared correlations.
    pub estimation: f64,
    /// `E[y(t + k) e(t)'] (ny x ny)` for `k = 0..=M`.
    response: Vec<DMatrix<f64>>,
    /// The terms of each row that are outputs: column of the regressor matrix, output, lag.
    own: Vec<Vec<(usize, usize, usize)>>,
}

/// An orthonormal basis of the columns of a matrix `X (T x p)`.
pub(crate) struct Span {
    /// `T x r`.
    pub basis: DMatrix<f64>,
    /// `W (p x r)` with `X W = basis`.
    pub map: DMatrix<f64>,
}

impl Residuals {
    pub fn new(
        model: &ArxModel,
        data: &Dataset,
        options: &ResidualOptions,
    ) -> Result<Self, IdentError> {
        let equation_error = model.equation_error(data)?;
        let (first, samples) = (model.max_lag(), data.len());
        let rows = samples - first;
        let parameters = model.rows().iter().map(|row| row.terms.len()).max();
        let parameters = parameters.unwrap_or(0);
        if rows < parameters + 3 {
            return Err(IdentError::TooFewRows {
                structure: model.structure().to_string(),
                needed: first + parameters + 3,
                found: samples,
            });
        }
        let own: Vec<Vec<(usize, usize, usize)>> = model
            .rows()
            .iter()
            .map(|row| {
                let terms = row.terms.iter().enumerate();
                terms
                    .filter_map(|(column, term)| match term.channel {
                        Channel::Output(output) => Some((column, output, term.lag)),
                        Channel::Input(_) => None,
                    })
                    .collect()
            })
            .collect();
        let longest = own.iter().flatten().map(|&(_, _, lag)| lag).max();
        options.validate(longest.unwrap_or(0) + 1, rows - 1)?;

        let errors = equation_error.columns(first, rows).transpose();
        for (output, signal) in data.outputs().iter().enumerate() {
            let size = data.y().row(output).amax();
            if errors.column(output).amax() <= ROUNDING * size {
                return Err(IdentError::NoResidual {
                    output: signal.name.clone(),
                });
            }
        }
        let covariance = errors.tr_mul(&errors) / rows as f64;
        let mut inputs = data.u().transpose();
        for mut column in inputs.column_iter_mut() {
            let mean = column.mean();
            column.add_scalar_mut(-mean);
        }
        let regressors = (0..data.ny())
            .map(|output| Span::new(&regressor_matrix(model, data, output, first..samples)))
            .collect();
        let estimation = match options.origin {
            RecordOrigin::Fitted => -1.0,
            RecordOrigin::Fresh => rows as f64 / model.rows_used().max(1) as f64,
        };
        let response = response(&own, model, &covariance, options.lags);
        Ok(Self {
            errors,
            covariance,
            inputs,
            first,
            lags: options.lags,
            regressors,
            estimation,
            response,
            own,
        })
    }

    /// Number of residuals of an output.
    pub fn count(&self) -> usize {
        self.errors.nrows()
    }

    /// `sqrt(T) (Phi' Phi)^(-1/2) E[phi_i(t) e(t - k)'] (r x ny)`: how the regressors of row
    /// `output` follow past errors. Its squares, over variances, are what the estimation takes
    /// from (or adds to) the variance of the residual correlations at lag `k`.
    pub fn past_errors_in_regressors(&self, output: usize, lag: usize) -> DMatrix<f64> {
        let span = &self.regressors[output];
        let mut follows = DMatrix::zeros(span.map.nrows(), self.errors.ncols());
        for &(column, channel, delay) in &self.own[output] {
            if delay <= lag {
                follows.set_row(column, &self.response[lag - delay].row(channel));
            }
        }
        let follows = span.map.tr_mul(&follows) * (self.count() as f64).sqrt();
        if follows.iter().all(|value| value.is_finite()) {
            follows
        } else {
            // The response of an unstable model over many lags overflows: no correction is known.
            DMatrix::zeros(span.map.ncols(), self.errors.ncols())
        }
    }
}

/// `E[y(t + k) e(t)']` of the model driven by its equation errors alone.
fn response(
    own: &[Vec<(usize, usize, usize)>],
    model: &ArxModel,
    covariance: &DMatrix<f64>,
    lags: usize,
) -> Vec<DMatrix<f64>> {
    let mut response: Vec<DMatrix<f64>> = Vec::with_capacity(lags + 1);
    for k in 0..=lags {
        let mut now = if k == 0 {
            covariance.clone()
        } else {
            DMatrix::zeros(covariance.nrows(), covariance.ncols())
        };
        for (output, terms) in own.iter().enumerate() {
            let mut row = now.row(output).into_owned();
            for &(column, channel, lag) in terms.iter().filter(|&&(_, _, lag)| lag <= k) {
                let coefficient = model.rows()[output].terms[column].coefficient;
                // At lag 0 stand outputs before this one only.
                if lag == 0 {
                    row += now.row(channel) * coefficient;
                } else {
                    row += response[k - lag].row(channel) * coefficient;
                }
            }
            now.set_row(output, &row);
        }
        response.push(now);
    }
    response
}

impl Span {
    /// The basis from the triangular factor of the column-scaled matrix; a column that the others
    /// explain adds nothing.
    pub fn new(matrix: &DMatrix<f64>) -> Self {
        let (rows, columns) = matrix.shape();
        if rows == 0 || columns == 0 {
            return Self::empty(rows, columns);
        }
        let mut scaled = matrix.clone();
        let mut scales = Vec::with_capacity(columns);
        for mut column in scaled.column_iter_mut() {
            let norm = column.norm();
            let scale = if norm > 0.0 { norm } else { 1.0 };
            column /= scale;
            scales.push(scale);
        }
        let factor = to_nalgebra(as_faer(&scaled).qr().thin_R());
        let Some(decomposed) = factor.try_svd(false, true, f64::EPSILON, 0) else {
            return Self::empty(rows, columns);
        };
        let (Some(right), values) = (decomposed.v_t, decomposed.singular_values) else {
            return Self::empty(rows, columns);
        };
        let largest = values.max();
        let kept: Vec<usize> = (0..values.len())
            .filter(|&index| values[index] > RANK_TOLERANCE * largest)
            .collect();
        let map = DMatrix::from_fn(columns, kept.len(), |row, column| {
            right[(kept[column], row)] / values[kept[column]] / scales[row]
        });
        Self {
            basis: matrix * &map,
            map,
        }
    }

    fn empty(rows: usize, columns: usize) -> Self {
        Self {
            basis: DMatrix::zeros(rows, 0),
            map: DMatrix::zeros(columns, 0),
        }
    }
}
