//! Factorisations of small symmetric matrices.

use nalgebra::{Cholesky, DMatrix, DVector, SymmetricEigen};

use crate::IdentError;

/// The upper triangular `R` with `R' R` the matrix.
pub(crate) fn upper_root(matrix: DMatrix<f64>) -> Result<DMatrix<f64>, IdentError> {
    let size = matrix.nrows();
    let finite = matrix.iter().all(|value| value.is_finite());
    match finite.then(|| Cholesky::new(matrix)).flatten() {
        Some(factor) => Ok(factor.l().transpose()),
        None => Err(IdentError::NotPositiveDefinite { size }),
    }
}

/// The eigenvalues and eigenvectors of a symmetric matrix, ascending; `None` where it is not
/// finite.
pub(crate) fn symmetric_eigen(matrix: DMatrix<f64>) -> Option<(DVector<f64>, DMatrix<f64>)> {
    /// Sweeps of the implicit QR; it needs two to three a row.
    const ROUNDS_PER_ROW: usize = 100;
    if !matrix.iter().all(|value| value.is_finite()) {
        return None;
    }
    if matrix.is_empty() {
        return Some((DVector::zeros(0), matrix));
    }
    let rounds = ROUNDS_PER_ROW * matrix.nrows();
    let eigen = SymmetricEigen::try_new(matrix, f64::EPSILON, rounds)?;
    let mut order: Vec<usize> = (0..eigen.eigenvalues.len()).collect();
    order.sort_by(|&a, &b| eigen.eigenvalues[a].total_cmp(&eigen.eigenvalues[b]));
    let values = DVector::from_iterator(order.len(), order.iter().map(|&k| eigen.eigenvalues[k]));
    Some((values, eigen.eigenvectors.select_columns(&order)))
}
