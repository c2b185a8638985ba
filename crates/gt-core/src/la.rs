//! The only door between nalgebra, the public matrix type, and faer, the factorisations.

use faer::MatRef;
use nalgebra::DMatrix;

/// A nalgebra matrix seen by faer, without a copy.
pub fn as_faer(matrix: &DMatrix<f64>) -> MatRef<'_, f64> {
    MatRef::from_column_major_slice(matrix.as_slice(), matrix.nrows(), matrix.ncols())
}

/// A copy of a faer matrix (its columns may be padded, so it cannot be borrowed).
pub fn to_nalgebra(matrix: MatRef<'_, f64>) -> DMatrix<f64> {
    DMatrix::from_fn(matrix.nrows(), matrix.ncols(), |row, column| {
        matrix[(row, column)]
    })
}
