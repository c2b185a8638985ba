//! Errors of the search for an observer's poles.

use thiserror::Error;

/// Why poles cannot be searched for.
#[derive(Debug, Clone, PartialEq, Error)]
pub enum SearchError {
    /// A model without states has no poles to choose.
    #[error("model of `{output}`: expected at least 1 state, found none")]
    NoStates {
        /// The model's output.
        output: String,
    },
    /// There is nothing to judge poles by.
    #[error("training records: expected at least one healthy and faulty pair, found none")]
    NoRecords,
    /// The paper's criterion is that of one pair.
    #[error("training pairs of the paper's criterion: expected 1, found {found}")]
    PairCount {
        /// Pairs given.
        found: usize,
    },
    /// The two records of a pair are not of the same length.
    #[error("{set} pair {pair}, samples of the faulty record: expected {expected}, found {found}")]
    Length {
        /// `training` or `validation`.
        set: &'static str,
        /// 0-based index of the pair.
        pair: usize,
        /// Samples of the healthy record.
        expected: usize,
        /// Samples of the faulty record.
        found: usize,
    },
    /// A pair has too few samples.
    #[error("{set} pair {pair}: expected at least {needed} samples, found {found}")]
    TooShort {
        /// `training` or `validation`.
        set: &'static str,
        /// 0-based index of the pair.
        pair: usize,
        /// Samples needed.
        needed: usize,
        /// Samples found.
        found: usize,
    },
    /// A sample that counts is NaN or infinite.
    #[error(
        "{set} pair {pair}, {record} record, `{signal}`, sample {sample}: expected a finite \
         number, found {found}"
    )]
    NotFinite {
        /// `training` or `validation`.
        set: &'static str,
        /// 0-based index of the pair.
        pair: usize,
        /// `healthy` or `faulty`.
        record: &'static str,
        /// The channel.
        signal: String,
        /// 0-based sample index.
        sample: usize,
        /// The value found.
        found: f64,
    },
    /// One side of the ratio is zero, or too large for a double.
    #[error(
        "{set} records, energy of the {side}: expected a positive finite number, found {found}"
    )]
    Energy {
        /// `training` or `validation`.
        set: &'static str,
        /// Which side of the ratio.
        side: &'static str,
        /// The sum of squares found.
        found: f64,
    },
    /// The eigenvalue problem of the bound was not solved.
    #[error(
        "bound of {functions} functions with the pole {pole}: expected an eigenvalue, found none"
    )]
    Bound {
        /// Laguerre functions of the basis.
        functions: usize,
        /// Their pole.
        pole: f64,
    },
}
