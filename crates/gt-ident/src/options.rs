//! What a fit may be asked for besides the structure.

use gt_core::OperatingPoint;
use serde::{Deserialize, Serialize};

/// What a sample that is NaN means to a fit. Infinite samples are always refused.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Missing {
    /// The record is refused.
    #[default]
    Refuse,
    /// The record ends before the sample and another begins after it: no regression row reaches
    /// across, and the means leave the sample out, all of its channels.
    Break,
}

/// The operating point that a fit subtracts and the model carries.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Centre {
    /// The means of all samples of all records.
    #[default]
    Means,
    /// Zero: the channels are deviations already.
    Zero,
    /// A known operating point.
    At(OperatingPoint),
}

/// What is assumed of the equation errors of different outputs at one instant.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum EquationErrors {
    /// They are not correlated: each row is a least-squares problem of its own. Where a row holds
    /// another output at lag 0 the model is read as recursive, output by output; with correlated
    /// errors its coefficients are then biased, however long the record.
    #[default]
    Uncorrelated,
    /// They have any covariance, which is estimated with the coefficients: iterated three-stage
    /// least squares on all rows at once.
    ///
    /// An output at lag 0 is replaced by its projection on everything that precedes it; the lags
    /// that its own row has beyond those of the row at hand are what identifies the coefficient.
    /// Where they do not move it the row is refused as rank-deficient.
    Correlated,
}

/// How the least-squares problem of a row may be solved.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Solver {
    /// By the QR factorisation in blocks of rows.
    #[default]
    Qr,
    /// By refinement on long records of moderate condition, where it is several times faster, else
    /// by QR. The two agree to about the accuracy of the QR factorisation in nearly all cases; in
    /// about one of two thousand random ones, where one channel explains little, a coefficient was
    /// five times further away than that.
    Automatic,
}

/// How the least-squares problem of a row was solved.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum SolvedBy {
    /// Refinement: inner products as a preconditioner, residuals of the record as the judge.
    Refinement,
    /// Householder QR in blocks of rows.
    Qr,
    /// Three-stage least squares of all rows.
    Joint,
}
