//! Errors of Kalman filters and of the Riccati equation behind them.

use thiserror::Error;

/// Why a covariance, a Riccati equation or a filter cannot be used.
#[derive(Debug, Clone, PartialEq, Error)]
pub enum FilterError {
    /// An entry is NaN or infinite.
    #[error("{matrix}({row}, {column}): expected a finite number, found {found}")]
    NotFinite {
        /// The matrix, for example `Q`.
        matrix: &'static str,
        /// 0-based row.
        row: usize,
        /// 0-based column.
        column: usize,
        /// The value found.
        found: f64,
    },
    /// A matrix that must be symmetric is not.
    #[error(
        "{matrix}({row}, {column}): expected that of a symmetric matrix, {expected}, found {found}"
    )]
    NotSymmetric {
        /// The matrix, for example `Q`.
        matrix: &'static str,
        /// 0-based row.
        row: usize,
        /// 0-based column.
        column: usize,
        /// The entry across the diagonal.
        expected: f64,
        /// The entry found.
        found: f64,
    },
    /// A covariance has a negative eigenvalue.
    #[error(
        "{matrix}: expected a positive semidefinite matrix, found one whose correlations have the \
         eigenvalue {found}"
    )]
    NotSemidefinite {
        /// The matrix, for example `[Q S; S' R]`.
        matrix: &'static str,
        /// Smallest eigenvalue of the matrix scaled to a unit diagonal.
        found: f64,
    },
    /// The variance of a channel is negative, NaN or infinite.
    #[error("noise of `{signal}`: expected a finite variance not below 0, found {found}")]
    Variance {
        /// The channel.
        signal: String,
        /// The value found.
        found: f64,
    },
    /// The covariance of the innovations is singular: a combination of the outputs has no noise.
    #[error("covariance of the innovations, C P C' + R: expected a positive definite matrix")]
    SingularInnovation,
    /// There is no steady filter, or rounding hides it.
    #[error(
        "Riccati equation: expected a solution with A - K C inside the circle of radius {limit} \
         ((A, C) detectable, (A, noise) stabilisable), found a spectral radius of \
         {spectral_radius} and a relative residual of {relative_residual:e} after {iterations} \
         doublings"
    )]
    NoSteadySolution {
        /// The largest spectral radius accepted.
        limit: f64,
        /// Largest modulus of the eigenvalues of A - K C (NaN when there was no K).
        spectral_radius: f64,
        /// Residual of the equation relative to its largest term (NaN when there was no P).
        relative_residual: f64,
        /// Doublings spent.
        iterations: usize,
    },
}
