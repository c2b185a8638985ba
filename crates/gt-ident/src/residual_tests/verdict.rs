//! What the tests say about a model.

use serde::Serialize;

use super::ChiSquareTest;

/// The outcome of a test at the significance asked for.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Verdict {
    /// The record does not contradict the hypothesis.
    NotRejected,
    /// The record contradicts the hypothesis.
    Rejected,
    /// Nothing was left to test.
    Untested,
}

impl Verdict {
    pub(crate) fn new(test: Option<&ChiSquareTest>, significance: f64) -> Self {
        match test {
            Some(test) if test.rejects(significance) => Self::Rejected,
            Some(_) => Self::NotRejected,
            None => Self::Untested,
        }
    }
}

/// The verdicts on the one-step errors of one output.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct OutputVerdict {
    /// The output's name.
    pub output: String,
    /// Whether the errors are white; a rejection says that the noise has dynamics that the row
    /// does not describe.
    pub whiteness: Verdict,
    /// Whether the errors are independent of past inputs; a rejection says that the record holds
    /// more about the way from the inputs than the row describes.
    pub independence: Verdict,
}

/// The verdicts on the one-step errors of a model.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct ResidualVerdict {
    /// The largest lag of the tests, in samples.
    pub lags: usize,
    /// The rate of false rejections of each test.
    pub significance: f64,
    /// Whether the errors of all outputs together are white.
    pub joint_whiteness: Verdict,
    /// One entry per output.
    pub outputs: Vec<OutputVerdict>,
}
