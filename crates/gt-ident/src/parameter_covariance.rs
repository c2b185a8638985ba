//! The covariance of least-squares coefficients.

use std::ops::Range;

use gt_core::la::{as_faer, to_nalgebra};
use gt_core::{Dataset, DimensionError};
use nalgebra::DMatrix;

use crate::{ArxModel, CONDITION_LIMIT, Channel, Dependence, IdentError};

/// The covariance of the coefficients of each row, `sigma^2 (Phi' Phi)^-1 (p x p)`, in the order of
/// the row's terms, from the record that the model was fitted to (Ljung 1999, eq. 9.42).
///
/// `Phi` holds the regressors at the samples from the longest lag on, `sigma^2` is the sum of
/// squared equation errors over `T - p`. The triangular factor of `Phi` is inverted; `Phi' Phi`,
/// which squares its condition, is never formed. It holds for white equation errors: whiteness is
/// for [`crate::test_residuals`] to say.
///
/// # Errors
/// As [`ArxModel::predict`]; [`IdentError::TooFewRows`] where no residual is left beyond the
/// coefficients; [`IdentError::RankDeficient`] beyond [`CONDITION_LIMIT`].
pub fn parameter_covariance(
    model: &ArxModel,
    data: &Dataset,
) -> Result<Vec<DMatrix<f64>>, IdentError> {
    let errors = model.equation_error(data)?;
    let rows = model.max_lag()..data.len();
    let most = model.rows().iter().map(|row| row.terms.len()).max();
    let needed = model.max_lag() + most.unwrap_or(0) + 1;
    if data.len() < needed {
        return Err(IdentError::TooFewRows {
            structure: model.structure().to_string(),
            needed,
            found: data.len(),
        });
    }
    (0..data.ny())
        .map(|output| {
            let regressors = regressor_matrix(model, data, output, rows.clone());
            let spare = (rows.len() - regressors.ncols()) as f64;
            let squares = errors
                .row(output)
                .columns(rows.start, rows.len())
                .norm_squared();
            let variance = squares / spare;
            let root = inverse_root(model, output, regressors)?;
            Ok(&root * root.transpose() * variance)
        })
        .collect()
}

/// The covariance of coefficients that are taken as exact, zero (`p x p` a row): what poles, zeros
/// and gains of a model are computed with where only their places are asked for.
pub fn exact_coefficients(model: &ArxModel) -> Vec<DMatrix<f64>> {
    let sizes = model.rows().iter().map(|row| row.terms.len());
    sizes.map(|size| DMatrix::zeros(size, size)).collect()
}

/// The regressors of an output's row (`rows x p`) as deviations from the model's operating point.
/// The record has the model's channels, and `rows` starts at its longest lag or later.
pub(crate) fn regressor_matrix(
    model: &ArxModel,
    data: &Dataset,
    output: usize,
    rows: Range<usize>,
) -> DMatrix<f64> {
    let (terms, point) = (&model.rows()[output].terms, model.operating_point());
    DMatrix::from_fn(rows.len(), terms.len(), |row, column| {
        let term = &terms[column];
        let sample = rows.start + row - term.lag;
        match term.channel {
            Channel::Output(index) => data.y()[(index, sample)] - point.y[index],
            Channel::Input(index) => data.u()[(index, sample)] - point.u[index],
        }
    })
}

/// Refuses covariances that do not belong to the rows of a model, as everything that takes them
/// does.
///
/// # Errors
/// [`IdentError::Dimension`] for another number of them or another size, [`IdentError::ModelValue`]
/// for a number that is not finite or a negative variance.
pub fn check_covariances(model: &ArxModel, covariances: &[DMatrix<f64>]) -> Result<(), IdentError> {
    DimensionError::check(
        "covariances (one per output)",
        model.rows().len(),
        covariances.len(),
    )?;
    for (index, (row, covariance)) in model.rows().iter().zip(covariances).enumerate() {
        for (side, found) in [
            ("rows", covariance.nrows()),
            ("columns", covariance.ncols()),
        ] {
            let what = format!("{side} of covariance {index} (coefficients of the row)");
            DimensionError::check(&what, row.terms.len(), found)?;
        }
        let bad = |value: &&f64| !value.is_finite();
        let diagonal = covariance.diagonal();
        let negative = |value: &&f64| **value < 0.0;
        let faults = covariance.iter().find(bad);
        if let Some(&found) = faults.or_else(|| diagonal.iter().find(negative)) {
            return Err(IdentError::ModelValue {
                what: format!("covariance {index}"),
                expected: "finite numbers, none below 0 on the diagonal",
                found,
            });
        }
    }
    Ok(())
}

/// `R^-1 (p x p)` of the triangular factor of the column-scaled regressors, scaled back:
/// `(Phi' Phi)^-1` is it times its transpose.
fn inverse_root(
    model: &ArxModel,
    output: usize,
    mut regressors: DMatrix<f64>,
) -> Result<DMatrix<f64>, IdentError> {
    let size = regressors.ncols();
    if size == 0 {
        return Ok(DMatrix::zeros(0, 0));
    }
    let mut scales = Vec::with_capacity(size);
    for mut column in regressors.column_iter_mut() {
        let norm = column.norm();
        let scale = if norm > 0.0 { norm } else { 1.0 };
        column /= scale;
        scales.push(scale);
    }
    let factor = to_nalgebra(as_faer(&regressors).qr().thin_R());
    let condition = condition(&factor);
    let mut inverse = DMatrix::identity(size, size);
    if condition > CONDITION_LIMIT || !factor.solve_upper_triangular_mut(&mut inverse) {
        // The columns have unit length: the least diagonal entry is the least independent one.
        let weakest = factor.diagonal().map(f64::abs).imin();
        let term = &model.rows()[output].terms[weakest];
        let channel = match term.channel {
            Channel::Output(index) => &model.outputs()[index],
            Channel::Input(index) => &model.inputs()[index],
        };
        return Err(IdentError::RankDeficient {
            output: model.outputs()[output].name.clone(),
            channel: channel.name.clone(),
            lag: term.lag,
            condition,
            limit: CONDITION_LIMIT,
            dependence: Box::new(Dependence::Unclear),
        });
    }
    for (mut row, scale) in inverse.row_iter_mut().zip(&scales) {
        row /= *scale;
    }
    Ok(inverse)
}

/// The ratio of the extreme singular values; infinite for a singular matrix, 1 for an empty one.
pub(crate) fn condition(matrix: &DMatrix<f64>) -> f64 {
    if matrix.is_empty() {
        return 1.0;
    }
    if !matrix.iter().all(|value| value.is_finite()) {
        return f64::INFINITY;
    }
    let Ok(values) = as_faer(matrix).singular_values() else {
        return f64::INFINITY;
    };
    let largest = values.iter().copied().fold(0.0, f64::max);
    let smallest = values.iter().copied().fold(f64::INFINITY, f64::min);
    if smallest > 0.0 {
        largest / smallest
    } else {
        f64::INFINITY
    }
}
