//! Errors of pole placement.

use nalgebra::Complex;
use thiserror::Error;

/// Why poles cannot be placed.
#[derive(Debug, Clone, PartialEq, Error)]
pub enum PlacementError {
    /// A pole off the real axis without its conjugate, so that no real gain has it.
    #[error("pole {index}, {found}: expected its complex conjugate in the list too, found none")]
    Unpaired {
        /// 0-based position in the list.
        index: usize,
        /// The pole.
        found: Complex<f64>,
    },
    /// A pole is NaN or infinite.
    #[error("pole {index}: expected a finite number, found {found}")]
    NotFinite {
        /// 0-based position in the list.
        index: usize,
        /// The pole.
        found: Complex<f64>,
    },
    /// An entry of a matrix is NaN or infinite.
    #[error("{matrix}({row}, {column}): expected a finite number, found {found}")]
    Entry {
        /// `A` or `B`.
        matrix: &'static str,
        /// 0-based row.
        row: usize,
        /// 0-based column.
        column: usize,
        /// The value found.
        found: f64,
    },
    /// Fewer poles are given than eigenvalues have to move.
    #[error(
        "poles: expected at least {expected}, one for each eigenvalue outside the bound, found \
         {found}"
    )]
    TooFew {
        /// Eigenvalues outside the bound.
        expected: usize,
        /// Poles given.
        found: usize,
    },
    /// The poles that would be used end between a pole and its conjugate.
    #[error(
        "poles: expected the first {used}, one for each eigenvalue outside the bound, to hold both \
         poles of every pair, found pole {index}, {found}, alone"
    )]
    SplitPair {
        /// Eigenvalues outside the bound.
        used: usize,
        /// 0-based position of the pole that is alone.
        index: usize,
        /// The pole.
        found: Complex<f64>,
    },
    /// A bound that is NaN, or a radius that is negative.
    #[error("bound of the eigenvalues that stay: expected {expected}, found {found}")]
    Bound {
        /// What is accepted.
        expected: &'static str,
        /// The value found.
        found: f64,
    },
    /// An eigenvalue that has to move cannot be moved: the inputs do not reach it, or the outputs
    /// of an observer do not show it.
    #[error(
        "eigenvalue {found}: expected an input that reaches it or an output that shows it by more \
         than {limit:e}, found {reach:e}"
    )]
    Fixed {
        /// The eigenvalue.
        found: Complex<f64>,
        /// How strongly it is reached: the Frobenius norm of its rows of `Z' B`.
        reach: f64,
        /// What counts as nothing.
        limit: f64,
    },
    /// Eigenvalues were not found, or could not be put in another order, to working accuracy.
    #[error("Schur form: expected one of the order {order} to working accuracy, found none")]
    Schur {
        /// Rows of A.
        order: usize,
    },
}
