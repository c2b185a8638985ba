//! Errors of shapes, data and models.

use thiserror::Error;

/// A matrix or vector has another size than its context asks for.
#[derive(Debug, Clone, PartialEq, Eq, Error)]
#[error("{what}: expected {expected}, found {found}")]
pub struct DimensionError {
    /// What was measured, for example `rows of B`.
    pub what: String,
    /// The size that fits.
    pub expected: usize,
    /// The size that was found.
    pub found: usize,
}

impl DimensionError {
    /// `Ok` when `found == expected`, otherwise the error that says so.
    pub fn check(what: &str, expected: usize, found: usize) -> Result<(), Self> {
        if expected == found {
            Ok(())
        } else {
            Err(Self {
                what: what.to_owned(),
                expected,
                found,
            })
        }
    }
}

/// A dataset that cannot be built or used.
#[derive(Debug, Clone, PartialEq, Error)]
pub enum DataError {
    /// Sizes of names and matrices disagree.
    #[error(transparent)]
    Dimension(#[from] DimensionError),
    /// The sample time is not a positive finite number.
    #[error("sample time: expected a positive number of seconds, found {found}")]
    SampleTime {
        /// The value found, in seconds.
        found: f64,
    },
    /// Two channels share a name.
    #[error("channel `{name}`: expected unique channel names, found it twice")]
    DuplicateName {
        /// The repeated name.
        name: String,
    },
    /// A channel that was asked for is not there.
    #[error("channel `{name}`: not found; there are: {}", available.join(", "))]
    UnknownChannel {
        /// The name asked for.
        name: String,
        /// The names there are.
        available: Vec<String>,
    },
    /// A sample is NaN or infinite where a finite number is needed.
    #[error("channel `{channel}`, sample {sample}: expected a finite number, found {found}")]
    NotFinite {
        /// The channel's name.
        channel: String,
        /// The 0-based sample index.
        sample: usize,
        /// The value found.
        found: f64,
    },
    /// A range of samples reaches past the end, or is empty.
    #[error("rows {start}:{end}: expected a non-empty range within 0:{len}")]
    Range {
        /// First row asked for.
        start: usize,
        /// One past the last row asked for.
        end: usize,
        /// Rows there are.
        len: usize,
    },
}

/// A state-space model that cannot be built or used.
#[derive(Debug, Clone, PartialEq, Error)]
pub enum ModelError {
    /// Sizes of the matrices or of a signal disagree.
    #[error(transparent)]
    Dimension(#[from] DimensionError),
    /// The sample time is not a positive finite number.
    #[error("sample time: expected a positive number of seconds, found {found}")]
    SampleTime {
        /// The value found, in seconds.
        found: f64,
    },
    /// A matrix holds NaN or infinity.
    #[error("matrix {matrix}({row}, {column}): expected a finite number, found {found}")]
    NotFinite {
        /// `A`, `B`, `C` or `D`.
        matrix: char,
        /// 0-based row.
        row: usize,
        /// 0-based column.
        column: usize,
        /// The value found.
        found: f64,
    },
    /// The eigenvalue iteration did not converge.
    #[error("eigenvalues of A ({order} x {order}): no convergence in {iterations} iterations")]
    NoConvergence {
        /// Size of A.
        order: usize,
        /// Iterations spent.
        iterations: usize,
    },
}
