//! Matrices in files.

use nalgebra::DMatrix;
use serde::de::Error as _;
use serde::{Deserialize, Deserializer};

/// Reads a matrix as nalgebra writes it, `[entries by columns, rows, columns]`, for
/// `#[serde(deserialize_with = "gt_core::stored_matrix")]`. nalgebra itself multiplies the sizes
/// unchecked, so that a file with huge ones would overflow there.
///
/// # Errors
/// What is not such a list, and a number of entries that is not rows times columns.
pub fn stored_matrix<'de, D: Deserializer<'de>>(source: D) -> Result<DMatrix<f64>, D::Error> {
    let (entries, rows, columns) = <(Vec<f64>, usize, usize)>::deserialize(source)?;
    if rows.checked_mul(columns) != Some(entries.len()) {
        let found = entries.len();
        return Err(D::Error::custom(format!(
            "matrix: expected {rows} x {columns} entries, found {found}"
        )));
    }
    Ok(DMatrix::from_vec(rows, columns, entries))
}
