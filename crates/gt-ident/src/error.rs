//! What can go wrong in identification.

use gt_core::qp::QpError;
use gt_core::{DataError, DimensionError, ModelError};
use thiserror::Error;

/// A model that cannot be identified, realised or applied.
#[derive(Debug, Clone, PartialEq, Error)]
pub enum IdentError {
    /// Sizes disagree.
    #[error(transparent)]
    Dimension(#[from] DimensionError),
    /// The record cannot be used, for example because a sample is not finite.
    #[error(transparent)]
    Data(#[from] DataError),
    /// The realisation is no state-space model, for example because an entry overflows.
    #[error(transparent)]
    Model(#[from] ModelError),
    /// A list of one value per input has another length.
    #[error("option {option}: expected 1 entry or {inputs} (one per input), found {found}")]
    OptionLength {
        /// `nb` or `nk`.
        option: &'static str,
        /// Number of inputs.
        inputs: usize,
        /// Entries found.
        found: usize,
    },
    /// There is nothing to identify.
    #[error("outputs: expected at least 1, found none")]
    NoOutputs,
    /// The structure has no regressor at all.
    #[error("structure {structure}: expected na >= 1 or some nb >= 1 with an input, found neither")]
    NoTerms {
        /// The structure as it prints.
        structure: String,
    },
    /// A canonical structure needs an index for each output.
    #[error("option indices: expected {expected} (one per output), found {found}")]
    IndexCount {
        /// Number of outputs.
        expected: usize,
        /// Indices found.
        found: usize,
    },
    /// A canonical index is zero.
    #[error("option indices, output {output}: expected an index of at least 1, found 0")]
    IndexZero {
        /// 0-based output.
        output: usize,
    },
    /// The order does not give each output an index of at least 1.
    #[error("order: expected at least {outputs} (one for each output), found {order}")]
    OrderTooSmall {
        /// The order asked for.
        order: usize,
        /// Number of outputs.
        outputs: usize,
    },
    /// A range of orders is empty or starts at zero.
    #[error("orders {first}..={last}: expected a non-empty range that starts at 1 or above")]
    OrderRange {
        /// First order asked for.
        first: usize,
        /// Last order asked for.
        last: usize,
    },
    /// An errors-in-variables order is zero.
    #[error("order: expected at least 1, found 0")]
    EivOrder,
    /// The smallest lag of an input lies beyond the order of an errors-in-variables model.
    #[error("option nk, input {input}: expected at most the order, {order}, found {found}")]
    EivLag {
        /// 0-based input.
        input: usize,
        /// The order.
        order: usize,
        /// The lag found.
        found: usize,
    },
    /// The record is shorter than the structure needs.
    #[error("samples: expected at least {needed} for {structure}, found {found}")]
    TooFewRows {
        /// The structure as it prints.
        structure: String,
        /// Samples needed: first regression row, plus the parameters of the largest row, plus 1.
        needed: usize,
        /// Samples found.
        found: usize,
    },
    /// A channel does not move, so that nothing can be learnt from or about it.
    #[error("channel `{channel}`: expected a signal that varies, found {value} in every row used")]
    ConstantChannel {
        /// The channel's name.
        channel: String,
        /// Its value.
        value: f64,
    },
    /// The regressors of an output are linearly dependent.
    #[error(
        "output `{output}`: expected independent regressors (condition at most {limit:e}), found \
         condition {condition:e}: `{channel}` at lag {lag} depends on the others"
    )]
    RankDeficient {
        /// The output's name.
        output: String,
        /// Channel of the dependent regressor.
        channel: String,
        /// Lag of the dependent regressor in samples.
        lag: usize,
        /// Condition of the column-scaled regressor matrix.
        condition: f64,
        /// The largest condition accepted.
        limit: f64,
    },
    /// The least-squares solution overflows.
    #[error("output `{output}`: expected finite coefficients, found {found}; scale the channels")]
    CoefficientNotFinite {
        /// The output's name.
        output: String,
        /// The value found.
        found: f64,
    },
    /// The record has other channels than the model.
    #[error("{side} {position}: expected channel `{expected}`, found `{found}`")]
    ChannelName {
        /// `input` or `output`.
        side: &'static str,
        /// 0-based position.
        position: usize,
        /// The model's channel.
        expected: String,
        /// The record's channel.
        found: String,
    },
    /// The record states another unit than the model; an empty unit is unknown and fits any.
    #[error("channel `{channel}`: expected unit `{expected}`, found `{found}`")]
    ChannelUnit {
        /// The channel's name.
        channel: String,
        /// The model's unit.
        expected: String,
        /// The record's unit.
        found: String,
    },
    /// The record is sampled at another rate than the model.
    #[error("sample time: expected {expected} s (the model's), found {found} s")]
    SampleTime {
        /// The model's, in seconds.
        expected: f64,
        /// The record's, in seconds.
        found: f64,
    },
    /// An output index reaches past the outputs.
    #[error("output {found}: expected an index below {outputs}")]
    NoSuchOutput {
        /// 0-based index asked for.
        found: usize,
        /// Number of outputs.
        outputs: usize,
    },
    /// A stored model's regressor is not the one that its structure puts there.
    #[error("row {row}, term {term}: expected {expected}, found {found}")]
    TermMismatch {
        /// 0-based output.
        row: usize,
        /// 0-based term.
        term: usize,
        /// What the structure asks for.
        expected: String,
        /// What is there.
        found: String,
    },
    /// A stored model holds a number that no fit can give.
    #[error("{what}: expected {expected}, found {found}")]
    ModelValue {
        /// The field.
        what: String,
        /// The values allowed.
        expected: &'static str,
        /// The value found.
        found: f64,
    },
    /// A state-space model is not in the canonical form of eq. 13-16.
    #[error("{matrix}({row}, {column}): expected {expected} in canonical form, found {found}")]
    NotCanonical {
        /// `A` or `C`.
        matrix: char,
        /// 0-based row.
        row: usize,
        /// 0-based column.
        column: usize,
        /// The value of the canonical form.
        expected: f64,
        /// The value found.
        found: f64,
    },
    /// The state cannot be seen in the outputs, so that there is no canonical form.
    #[error("observability: expected rank {expected} (all states), found {found}")]
    NotObservable {
        /// Number of states.
        expected: usize,
        /// Rank found.
        found: usize,
    },
    /// The realisation would have more states than are of any use.
    #[error("states: expected at most {limit}, found {found} (a longest lag of {max_lag} samples)")]
    TooManyStates {
        /// The largest number accepted.
        limit: usize,
        /// The number that the model needs.
        found: usize,
        /// The model's longest lag.
        max_lag: usize,
    },
    /// A method takes diagonal structures only.
    #[error("{method}: expected a diagonal structure (own-output lags only), found {structure}")]
    NotDiagonal {
        /// The method.
        method: &'static str,
        /// The structure as it prints.
        structure: String,
    },
    /// An option lies outside its range.
    #[error("option {option}: expected a number {expected}, found {found}")]
    OptionRange {
        /// The option.
        option: &'static str,
        /// The numbers allowed.
        expected: &'static str,
        /// The value found.
        found: f64,
    },
    /// The range of a steady-state gain is empty or not finite.
    #[error(
        "gain of `{input}` on `{output}`: expected finite limits with lower <= upper, found \
         {lower} and {upper}"
    )]
    GainRange {
        /// The output's name.
        output: String,
        /// The input's name.
        input: String,
        /// Lower limit.
        lower: f64,
        /// Upper limit.
        upper: f64,
    },
    /// A steady-state gain is given for an input that the structure leaves out.
    #[error("gain of `{input}` on `{output}`: expected lags of `{input}` (nb >= 1), found none")]
    GainWithoutTerms {
        /// The output's name.
        output: String,
        /// The input's name.
        input: String,
    },
    /// The quadratic programme of a constrained fit cannot be solved.
    #[error("output `{output}`: {source}")]
    Programme {
        /// The output's name.
        output: String,
        /// Why.
        source: QpError,
    },
    /// A row to be refined has poles outside the largest radius.
    #[error(
        "output `{output}`: expected poles within {limit} before the refinement, found {found}; \
         fit it with constrained least squares first"
    )]
    UnstableStart {
        /// The output's name.
        output: String,
        /// The largest modulus allowed.
        limit: f64,
        /// The largest modulus found.
        found: f64,
    },
    /// There is no record at all.
    #[error("records: expected at least 1, found none")]
    NoRecords,
    /// The operating points of a schedule are missing or out of order.
    #[error("schedule: expected at least 1 finite value, in ascending order, found {found:?}")]
    ScheduleValues {
        /// The values found.
        found: Vec<f64>,
    },
    /// An operating point has too few samples around it.
    #[error("samples around `{channel}` = {value}: expected at least {needed}, found {found}")]
    SchedulePoint {
        /// The scheduling channel.
        channel: String,
        /// Its value at the point.
        value: f64,
        /// Samples needed.
        needed: usize,
        /// Samples found.
        found: usize,
    },
    /// A local model has a pole at 1, so that its constant belongs to no operating point.
    #[error("schedule, point {value}: expected an equilibrium, found a pole at 1")]
    NoEquilibrium {
        /// The scheduling channel's value at the point.
        value: f64,
    },
}
