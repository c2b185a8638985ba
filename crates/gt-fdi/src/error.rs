//! Errors of design and of records that do not fit a design.

use gt_core::{DataError, DimensionError, ModelError, Stopped};
use thiserror::Error;

use crate::design::{FilterError, PlacementError, SearchError};
use crate::design::{ScheduleError, UnknownInputError};
use crate::runtime::{StatisticError, StepError};

/// Why a generator, a threshold, a bank or a signature cannot be made or used.
#[derive(Debug, Clone, PartialEq, Error)]
pub enum FdiError {
    /// Sizes disagree.
    #[error(transparent)]
    Dimension(#[from] DimensionError),
    /// The record cannot be used.
    #[error(transparent)]
    Data(#[from] DataError),
    /// The model cannot be used.
    #[error(transparent)]
    Model(#[from] ModelError),
    /// The caller wanted the work to end.
    #[error(transparent)]
    Stopped(#[from] Stopped),
    /// The detector refused a sample.
    #[error(transparent)]
    Step(#[from] StepError),
    /// A statistic cannot be made.
    #[error(transparent)]
    Statistic(#[from] StatisticError),
    /// A covariance, a Riccati equation or a Kalman filter cannot be used.
    #[error(transparent)]
    Filter(#[from] FilterError),
    /// Poles cannot be placed.
    #[error(transparent)]
    Placement(#[from] PlacementError),
    /// Poles cannot be searched for.
    #[error(transparent)]
    Search(#[from] SearchError),
    /// A residual cannot be made robust against unknown inputs or freed of them.
    #[error(transparent)]
    UnknownInput(#[from] UnknownInputError),
    /// Generators cannot be scheduled.
    #[error(transparent)]
    Schedule(#[from] ScheduleError),
    /// The model has another number of outputs than one.
    #[error("outputs of the model: expected 1 (one observer an output), found {found}")]
    OutputCount {
        /// Outputs of the model.
        found: usize,
    },
    /// The number of poles is not the model's order.
    #[error("poles: expected {expected}, one a state, found {found}")]
    PoleCount {
        /// States of the model.
        expected: usize,
        /// Poles given.
        found: usize,
    },
    /// A pole is not inside the unit circle.
    #[error("pole {index}: expected a modulus below 1, found {found}")]
    PoleOutside {
        /// 0-based position in the list.
        index: usize,
        /// The pole, the modulus of a complex one.
        found: f64,
    },
    /// The output does not determine the state, so its observer's poles cannot be chosen.
    #[error(
        "model of `{output}`: expected an observable pair (A, C) with an observability matrix of \
         condition below {limit:e}, found {condition:e}"
    )]
    Unobservable {
        /// The model's output.
        output: String,
        /// Ratio of the extreme singular values of `[C; C A; ...]`; infinite when singular.
        condition: f64,
        /// The largest condition accepted.
        limit: f64,
    },
    /// The generator is unstable, or so slow that it is of no use.
    #[error(
        "generator of `{output}`: expected a stable A - K C whose free response falls below \
         {level:e} within {limit} samples, found a spectral radius of {spectral_radius}"
    )]
    DoesNotSettle {
        /// The model's output.
        output: String,
        /// The level to fall below, relative to the initial state.
        level: f64,
        /// The largest number of samples accepted.
        limit: usize,
        /// Largest modulus of the eigenvalues of A - K C (NaN when they were not found).
        spectral_radius: f64,
    },
    /// A file's gain does not follow from the poles or the noise that stand beside it.
    #[error(
        "generator of `{output}`, gain: expected that of its {design}, {expected} at state \
         {state}, found {found}"
    )]
    Gain {
        /// The model's output.
        output: String,
        /// What the gain follows from, `poles` or `noise`.
        design: &'static str,
        /// 0-based state with the largest difference.
        state: usize,
        /// The gain that follows.
        expected: f64,
        /// The gain found.
        found: f64,
    },
    /// A file's rate of false alarms does not follow from its counts.
    #[error("false alarms, {what}: expected {expected} from the counts, found {found}")]
    FalseAlarms {
        /// The number looked at.
        what: &'static str,
        /// What the counts say.
        expected: f64,
        /// The value found.
        found: f64,
    },
    /// A number of a generator is NaN or infinite.
    #[error("generator of `{output}`, {what}: expected a finite number, found {found}")]
    NotFinite {
        /// The model's output.
        output: String,
        /// What was looked at, for example `gain`.
        what: &'static str,
        /// The value found.
        found: f64,
    },
    /// A tag appears twice where it may appear once.
    #[error("{place}: expected unique tags, found `{tag}` twice")]
    DuplicateTag {
        /// Where, for example `outputs of the bank`.
        place: &'static str,
        /// The repeated tag.
        tag: String,
    },
    /// The record lacks channels.
    #[error(
        "record: expected the channels {}, found only {}", missing.join(", "), available.join(", ")
    )]
    MissingTags {
        /// All the tags that are needed and not there.
        missing: Vec<String>,
        /// The tags there are.
        available: Vec<String>,
    },
    /// Two sample times that must agree do not.
    #[error("sample time of {what}: expected {expected_s} s, found {found_s} s")]
    SampleTime {
        /// Whose sample time was looked at, for example `the record`.
        what: String,
        /// The sample time that fits, in seconds.
        expected_s: f64,
        /// The sample time found, in seconds.
        found_s: f64,
    },
    /// A fault hypothesis with a number out of its range.
    #[error("hypothesis `{name}`, {option}: expected {expected}, found {found}")]
    Hypothesis {
        /// The hypothesis.
        name: String,
        /// The option.
        option: &'static str,
        /// What was expected.
        expected: &'static str,
        /// What was found.
        found: f64,
    },
    /// Records that show no effect of their fault.
    #[error(
        "effect of a fault: expected records whose residuals differ with a fault that is not 0 \
         throughout, found no difference that follows it"
    )]
    NoEffect,
    /// A bank without a detector.
    #[error("bank `{name}`: expected at least one generator and one test, found none")]
    EmptyBank {
        /// The bank's name.
        name: String,
    },
    /// A file written by another version of this format.
    #[error("bank: expected schema_version {expected}, found {found}")]
    SchemaVersion {
        /// The version this library reads.
        expected: u32,
        /// The version found.
        found: u32,
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
    /// A threshold's limit is negative, NaN or infinite.
    #[error("threshold limit: expected a finite number not below 0, found {found}")]
    Limit {
        /// The value found.
        found: f64,
    },
    /// A threshold or a signature was asked for without healthy data.
    #[error("healthy residuals: expected at least one record, found none")]
    NoHealthyData,
    /// A healthy record has too few samples for the rule.
    #[error("healthy residual {record}: expected at least {needed} samples, found {found}")]
    HealthySamples {
        /// 0-based index of the record.
        record: usize,
        /// Samples needed.
        needed: usize,
        /// Samples found.
        found: usize,
    },
    /// All healthy records together have too few samples for the share asked for.
    #[error(
        "healthy residuals: a share of {share} needs at least {needed} samples in all records \
         together, found {found}"
    )]
    HealthyTotal {
        /// The share of samples above the limit that was asked for.
        share: f64,
        /// Samples needed.
        needed: usize,
        /// Samples found.
        found: usize,
    },
    /// Too little healthy running for the mean time between false alarms that was asked for.
    #[error(
        "healthy residuals: a mean time of {asked_hours} h between false alarms needs at least \
         {needed_hours} h of healthy running, found {found_hours} h"
    )]
    HealthyHours {
        /// Mean time between false alarms asked for, in hours.
        asked_hours: f64,
        /// Hours of healthy running needed.
        needed_hours: f64,
        /// Hours of healthy running found.
        found_hours: f64,
    },
    /// A residual is NaN or infinite where every sample is needed.
    #[error("{what}, sample {sample}: expected a finite residual, found {found}")]
    NotFiniteResidual {
        /// Whose residual, for example `healthy residual 0`.
        what: String,
        /// 0-based sample index.
        sample: usize,
        /// The value found.
        found: f64,
    },
    /// A window of samples is empty or reaches past the end.
    #[error("window {start}..{end}: expected a non-empty range within 0..{len}")]
    Window {
        /// First sample.
        start: usize,
        /// One past the last sample.
        end: usize,
        /// Samples there are.
        len: usize,
    },
    /// An average run length is out of the range that can be reached or computed.
    #[error("average run length: expected {low} to {high} samples, found {found}")]
    RunLength {
        /// The smallest that is accepted, in samples.
        low: f64,
        /// The largest that is accepted, in samples.
        high: f64,
        /// The value found, in samples; infinite when it is beyond the range of doubles.
        found: f64,
    },
    /// A statistic of residuals with a sign, for the norm of several.
    #[error(
        "statistic of {found} residuals together: expected one of their norm, the modulus or the \
         sum of squares, found one of a residual with a sign"
    )]
    SignedStatistic {
        /// Residuals that the test watches.
        found: usize,
    },
    /// Healthy records, or the fifth of a single one that judges the others, shorter than what a
    /// statistic has to see before it says anything.
    #[error(
        "healthy record, or a fifth of a single one: expected at least {needed} samples for the \
         window and the whitening, found {found}"
    )]
    ShortFold {
        /// Samples needed.
        needed: usize,
        /// Samples found.
        found: usize,
    },
    /// Too few peaks of a statistic for a fit of their tail.
    #[error("peaks of the statistic on healthy records: expected at least {needed}, found {found}")]
    TooFewPeaks {
        /// Peaks needed for a fit.
        needed: usize,
        /// Peaks found.
        found: usize,
    },
    /// A residual does not move on healthy records, so that nothing is known of its noise.
    #[error(
        "healthy residual {index} of the test: expected one that moves, found a standard deviation \
         of {found}"
    )]
    ConstantResidual {
        /// 0-based position of the residual among those of the test.
        index: usize,
        /// Its standard deviation.
        found: f64,
    },
    /// Too few simulated paths raise an alarm to say when they do.
    #[error("simulated paths with an alarm: expected at least {needed}, found {found}")]
    TooFewAlarms {
        /// Alarms needed.
        needed: usize,
        /// Alarms found.
        found: usize,
    },
}
