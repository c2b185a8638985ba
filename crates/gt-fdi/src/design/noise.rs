//! The noise that a Kalman filter is designed for.

use gt_core::{DimensionError, StateSpace, stored_matrix};
use nalgebra::{DMatrix, DVector, SymmetricEigen};
use serde::{Deserialize, Serialize};

use super::filter_error::FilterError;
use crate::FdiError;

/// Difference between two entries across the diagonal, relative to the geometric mean of the
/// diagonal's, up to which a matrix counts as symmetric: what printing nine digits leaves.
pub const SYMMETRY_TOLERANCE: f64 = 1e-9;
/// How negative an eigenvalue of the correlations may be: what rounding a singular covariance to
/// nine digits leaves.
pub const DEFINITENESS_TOLERANCE: f64 = 1e-8;

/// Iterations per eigenvalue after which a symmetric eigenvalue problem is given up.
const EIGEN_ITERATIONS: usize = 100;

/// Covariances of white noise in `x(t+1) = A x + B u + w`, `y(t) = C x + D u + v`:
/// `Q = E[w w']` (nx x nx, squared units of the states), `R = E[v v']` (ny x ny, squared units of
/// the outputs) and the cross term `S = E[w v']` (nx x ny).
///
/// Construction and deserialisation both check that `[Q S; S' R]` is a covariance.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(try_from = "Unchecked")]
pub struct NoiseCovariance {
    q: DMatrix<f64>,
    r: DMatrix<f64>,
    s: DMatrix<f64>,
}

/// The fields of a [`NoiseCovariance`] as they come from a file.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Unchecked {
    #[serde(deserialize_with = "stored_matrix")]
    q: DMatrix<f64>,
    #[serde(deserialize_with = "stored_matrix")]
    r: DMatrix<f64>,
    #[serde(deserialize_with = "stored_matrix")]
    s: DMatrix<f64>,
}

impl TryFrom<Unchecked> for NoiseCovariance {
    type Error = FdiError;

    fn try_from(raw: Unchecked) -> Result<Self, FdiError> {
        Self::new(&raw.q, &raw.r, &raw.s)
    }
}

impl NoiseCovariance {
    /// Checked covariances; `s` may be zero, but has to be there.
    ///
    /// # Errors
    /// [`FdiError::Dimension`] for sizes that disagree; [`FilterError::NotFinite`],
    /// [`FilterError::NotSymmetric`] and [`FilterError::NotSemidefinite`] of `[Q S; S' R]`.
    pub fn new(q: &DMatrix<f64>, r: &DMatrix<f64>, s: &DMatrix<f64>) -> Result<Self, FdiError> {
        let (nx, ny) = (q.nrows(), r.nrows());
        DimensionError::check("rows of S", nx, s.nrows())?;
        DimensionError::check("columns of S", ny, s.ncols())?;
        check_covariance("Q", q)?;
        check_covariance("R", r)?;
        check_finite("S", s)?;
        let (q, r) = (symmetrised(q), symmetrised(r));
        let mut joint = DMatrix::zeros(nx + ny, nx + ny);
        joint.view_mut((0, 0), (nx, nx)).copy_from(&q);
        joint.view_mut((0, nx), (nx, ny)).copy_from(s);
        joint.view_mut((nx, 0), (ny, nx)).copy_from(&s.transpose());
        joint.view_mut((nx, nx), (ny, ny)).copy_from(&r);
        check_semidefinite("[Q S; S' R]", &joint)?;
        Ok(Self { q, r, s: s.clone() })
    }

    /// The noise of a model whose measured inputs and outputs have white noise of the variances
    /// `input` (nu) and `output` (ny), in squared units of the channels: with `w = -B u~` and
    /// `v = y~ - D u~`, `Q = B Su B'`, `R = Sy + D Su D'`, `S = B Su D'`, which is zero only
    /// without a direct term (errors in variables, the paper's section 3).
    ///
    /// # Errors
    /// [`FdiError::Dimension`] for another number of variances, [`FilterError::Variance`] for one
    /// that is negative, NaN or infinite; as [`NoiseCovariance::new`] when the products overflow.
    pub fn errors_in_variables(
        model: &StateSpace,
        input: &[f64],
        output: &[f64],
    ) -> Result<Self, FdiError> {
        DimensionError::check("input noise variances", model.nu(), input.len())?;
        DimensionError::check("output noise variances", model.ny(), output.len())?;
        let signals = model.inputs().iter().chain(model.outputs());
        for (signal, &found) in signals.zip(input.iter().chain(output)) {
            if !(found.is_finite() && found >= 0.0) {
                let signal = signal.name.clone();
                return Err(FilterError::Variance { signal, found }.into());
            }
        }
        let su = DMatrix::from_diagonal(&DVector::from_column_slice(input));
        let sy = DMatrix::from_diagonal(&DVector::from_column_slice(output));
        let (b, d) = (model.b() * &su, model.d() * &su);
        Self::new(
            &(&b * model.b().transpose()),
            &(sy + &d * model.d().transpose()),
            &(b * model.d().transpose()),
        )
    }

    /// `Q (nx x nx)`.
    pub fn q(&self) -> &DMatrix<f64> {
        &self.q
    }

    /// `R (ny x ny)`.
    pub fn r(&self) -> &DMatrix<f64> {
        &self.r
    }

    /// `S (nx x ny)`.
    pub fn s(&self) -> &DMatrix<f64> {
        &self.s
    }

    /// Refuses a model of another size.
    pub(super) fn check_model(&self, model: &StateSpace) -> Result<(), DimensionError> {
        DimensionError::check("rows of Q (states)", model.nx(), self.q.nrows())?;
        DimensionError::check("rows of R (outputs)", model.ny(), self.r.nrows())
    }
}

/// Half the sum with the transpose.
pub(super) fn symmetrised(matrix: &DMatrix<f64>) -> DMatrix<f64> {
    0.5 * (matrix + matrix.transpose())
}

pub(super) fn check_finite(matrix: &'static str, values: &DMatrix<f64>) -> Result<(), FilterError> {
    let position = values.iter().position(|value| !value.is_finite());
    position.map_or(Ok(()), |index| {
        let (row, column) = values.vector_to_matrix_index(index);
        Err(FilterError::NotFinite {
            matrix,
            row,
            column,
            found: values[index],
        })
    })
}

/// Refuses a matrix that is not square, finite and symmetric.
pub(super) fn check_symmetric(matrix: &'static str, values: &DMatrix<f64>) -> Result<(), FdiError> {
    if !values.is_square() {
        let columns = format!("columns of {matrix}");
        DimensionError::check(&columns, values.nrows(), values.ncols())?;
    }
    check_finite(matrix, values)?;
    for column in 0..values.ncols() {
        for row in column + 1..values.nrows() {
            let (found, expected) = (values[(row, column)], values[(column, row)]);
            if (found - expected).abs() == 0.0 {
                continue;
            }
            let diagonal = values[(row, row)].abs().sqrt() * values[(column, column)].abs().sqrt();
            let scale = diagonal.max(found.abs()).max(expected.abs());
            if (found - expected).abs() > SYMMETRY_TOLERANCE * scale {
                return Err(FilterError::NotSymmetric {
                    matrix,
                    row,
                    column,
                    expected,
                    found,
                }
                .into());
            }
        }
    }
    Ok(())
}

/// Refuses what is not the covariance of anything.
pub(super) fn check_covariance(
    matrix: &'static str,
    values: &DMatrix<f64>,
) -> Result<(), FdiError> {
    check_symmetric(matrix, values)?;
    Ok(check_semidefinite(matrix, values)?)
}

/// Judges the correlations, so that the units of the entries do not matter. A symmetric matrix
/// with a negative diagonal, or with something beside a zero of it, has a negative eigenvalue.
fn check_semidefinite(matrix: &'static str, values: &DMatrix<f64>) -> Result<(), FilterError> {
    if values.is_empty() {
        return Ok(());
    }
    let scales = values.diagonal().map(|value| {
        let root = value.abs().sqrt();
        if root > 0.0 { root } else { 1.0 }
    });
    let correlations = DMatrix::from_fn(values.nrows(), values.ncols(), |row, column| {
        values[(row, column)] / scales[row] / scales[column]
    });
    let iterations = EIGEN_ITERATIONS * values.nrows();
    let found = SymmetricEigen::try_new(symmetrised(&correlations), f64::EPSILON, iterations)
        .map_or(f64::NAN, |eigen| eigen.eigenvalues.min());
    if found >= -DEFINITENESS_TOLERANCE {
        Ok(())
    } else {
        Err(FilterError::NotSemidefinite { matrix, found })
    }
}
