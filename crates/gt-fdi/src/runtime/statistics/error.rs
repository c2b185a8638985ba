//! Errors of statistics and of their saved states.

use thiserror::Error;

/// Why a statistic cannot be made, or a saved one cannot be resumed.
#[derive(Debug, Clone, Copy, PartialEq, Error)]
pub enum StatisticError {
    /// A threshold is not positive, NaN or infinite.
    #[error("threshold: expected a positive finite number, found {found}")]
    Threshold {
        /// The value found.
        found: f64,
    },
    /// A window is empty or too long.
    #[error("window: expected 1 to {longest} samples, found {found}")]
    Window {
        /// The longest window accepted, in samples.
        longest: usize,
        /// The value found.
        found: usize,
    },
    /// A window is too short or too long for a statistic that needs several samples.
    #[error("window: expected {shortest} to {longest} samples, found {found}")]
    WindowRange {
        /// The shortest window accepted, in samples.
        shortest: usize,
        /// The longest window accepted, in samples.
        longest: usize,
        /// The value found.
        found: usize,
    },
    /// The lengths between which a window grows are not in order.
    #[error(
        "growing window: expected {least} <= shortest <= longest, found {shortest} and {longest} \
         samples"
    )]
    Growth {
        /// The smallest `shortest` accepted, in samples.
        least: u64,
        /// The shortest window given, in samples.
        shortest: u64,
        /// The longest window given, in samples.
        longest: u64,
    },
    /// No lags, or more than the window or the statistic has.
    #[error("lags: expected 1 to {most}, found {found}")]
    Lags {
        /// The most lags accepted.
        most: usize,
        /// The value found.
        found: usize,
    },
    /// An option is out of its range.
    #[error("option `{option}`: expected {expected}, found {found}")]
    Option {
        /// The option's name.
        option: &'static str,
        /// The range that is accepted.
        expected: &'static str,
        /// The value found.
        found: f64,
    },
    /// Another number of inputs than the threshold was made for.
    #[error("inputs of the sample: expected {expected}, found {found}")]
    Inputs {
        /// Inputs of the threshold.
        expected: usize,
        /// Inputs in the sample.
        found: usize,
    },
    /// An allowance is negative, NaN or infinite.
    #[error("allowance: expected a finite number not below 0, found {found}")]
    Allowance {
        /// The value found.
        found: f64,
    },
    /// A range of fault sizes is not one.
    #[error("sizes: expected 0 < smallest <= largest, both finite, found {smallest} and {largest}")]
    Sizes {
        /// The smallest size given.
        smallest: f64,
        /// The largest size given.
        largest: f64,
    },
    /// A shift to test for is zero, NaN or infinite.
    #[error("shift: expected a finite number other than 0, found {found}")]
    Shift {
        /// The value found.
        found: f64,
    },
    /// Two bounds do not stand on either side of zero.
    #[error("bounds: expected accept < 0 < reject, both finite, found {accept} and {reject}")]
    Bounds {
        /// The lower bound given.
        accept: f64,
        /// The upper bound given.
        reject: f64,
    },
    /// A number of a saved state cannot have come from the statistic.
    #[error("state, {what}: expected a number from {low} to {high}, found {found}")]
    State {
        /// What was looked at, for example `sample`.
        what: &'static str,
        /// The smallest value accepted.
        low: f64,
        /// The largest value accepted.
        high: f64,
        /// The value found.
        found: f64,
    },
    /// A list of a saved state has another length than the statistic's.
    #[error("state, {what}: expected {expected} numbers, found {found}")]
    Length {
        /// What was looked at, for example `samples`.
        what: &'static str,
        /// The length that fits (the longest, for lists that grow).
        expected: usize,
        /// The length found.
        found: usize,
    },
}
