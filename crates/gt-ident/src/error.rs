//! What can go wrong in identification.

use gt_core::qp::QpError;
use gt_core::{DataError, DimensionError, ModelError, Stopped};
use thiserror::Error;

use crate::Dependence;

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
    /// The caller wanted the work to end.
    #[error(transparent)]
    Stopped(#[from] Stopped),
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
         condition {condition:.1e}: `{channel}` at lag {lag} {dependence}"
    )]
    RankDeficient {
        /// The output's name.
        output: String,
        /// Channel of the dependent regressor.
        channel: String,
        /// Lag of the dependent regressor in samples.
        lag: usize,
        /// What it depends on.
        dependence: Box<Dependence>,
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
    /// There is no input that could explain an output.
    #[error("inputs: expected at least 1, found none")]
    NoInputs,
    /// A spectrum is not positive definite, or its model has a pole on the unit circle.
    #[error("spectrum, frequency {index}: expected a positive definite matrix, found none")]
    SpectrumNotPositive {
        /// 0-based frequency.
        index: usize,
    },
    /// The record is too short for the autoregression behind an errors-in-variables fit.
    #[error("samples: expected at least {needed} for the autoregression, found {found}")]
    EivTooFewSamples {
        /// Samples needed.
        needed: usize,
        /// Samples found.
        found: usize,
    },
    /// The deviation of a channel is no ordinary number, so that it cannot be scaled.
    #[error("channel `{channel}`: expected a normal deviation, found {found:e}; scale the channel")]
    EivScale {
        /// The channel's name.
        channel: String,
        /// The deviation found.
        found: f64,
    },
    /// The past and the other channels determine a channel: there is no white noise on it.
    #[error(
        "channel `{channel}`: expected at least {limit:e} of its variance as noise of its own, \
         found {found:e}: the past and the other channels determine it"
    )]
    EivDetermined {
        /// The channel's name.
        channel: String,
        /// The part of its variance that is left.
        found: f64,
        /// The least accepted.
        limit: f64,
    },
    /// A starting point has other lags than the model.
    #[error("start {start}, output {output}: expected the lags of the model, found others")]
    EivStartLags {
        /// 0-based start.
        start: usize,
        /// 0-based output.
        output: usize,
    },
    /// A starting point holds a number that is no coefficient or variance.
    #[error(
        "start {start}, output {output}: expected finite coefficients and variances of at least \
         0, found {found}"
    )]
    EivStartValue {
        /// 0-based start.
        start: usize,
        /// 0-based output.
        output: usize,
        /// The value found.
        found: f64,
    },
    /// No relation was found that the likelihood could start from.
    #[error("output {output}: expected a relation to start from, found none")]
    EivNoStart {
        /// 0-based output.
        output: usize,
    },
    /// A covariance is that of no process, or of one whose channels determine each other.
    #[error("covariance ({size} x {size}): expected a positive definite matrix, found none")]
    NotPositiveDefinite {
        /// Rows of the matrix.
        size: usize,
    },
    /// A selection criterion has too few lags to tell the noise variances apart.
    #[error("option lags of {criterion}: expected at least {needed}, found {found}")]
    CriterionLags {
        /// The criterion as it is written.
        criterion: &'static str,
        /// The smallest number accepted.
        needed: usize,
        /// The number found.
        found: usize,
    },
    /// Noise variances, or the direction of a ray of them, that no noise has.
    #[error(
        "noise variance of channel {channel} (0 is the output): expected a finite number of at \
         least 0, one of them above it, found {found}"
    )]
    NoiseDirection {
        /// 0 for the output, `j + 1` for input `j`.
        channel: usize,
        /// The value found.
        found: f64,
    },
    /// Input variances beyond what the covariance of an output admits.
    #[error("output `{output}`: expected input noise variances it admits, found {variances:?}")]
    NotAdmissible {
        /// The output's name.
        output: String,
        /// The variances asked for.
        variances: Vec<f64>,
    },
    /// The lagged channels are related, but the output itself has no part in it.
    #[error("output `{output}`: expected a relation with a coefficient at y(t), found none")]
    NoRelation {
        /// The output's name.
        output: String,
    },
    /// Weighted moments leave a coefficient or a noise variance open.
    #[error(
        "output `{output}`: expected moments that determine every coefficient and variance, found \
         a singular information matrix"
    )]
    MomentsSingular {
        /// The output's name.
        output: String,
    },
    /// There is no record to fit.
    #[error("records: expected at least 1, found none")]
    NoRecords,
    /// The weight of a ridge is negative or not finite.
    #[error("option ridge: expected a finite number of at least 0, found {found}")]
    Ridge {
        /// The weight found.
        found: f64,
    },
    /// The weight of a prior on poles is negative or not finite.
    #[error("option pole_prior: expected a finite number of at least 0, found {found}")]
    PolePrior {
        /// The weight found.
        found: f64,
    },
    /// A ridge has no meaning for rows that are estimated together.
    #[error("option ridge: expected 0 with correlated equation errors, found {found}")]
    JointRidge {
        /// The weight found.
        found: f64,
    },
    /// The indices near the generic ones are too many to compare.
    #[error("index sets: expected at most {limit} within {spread} of the generic indices")]
    TooManyIndexSets {
        /// The largest number compared.
        limit: usize,
        /// The distance asked for.
        spread: usize,
    },
    /// A number of lags that the residuals do not allow.
    #[error("option lags: expected {lowest} to {highest}, found {found}")]
    ResidualLags {
        /// One more than the longest lag of the model's outputs.
        lowest: usize,
        /// One less than the number of residuals.
        highest: usize,
        /// The number asked for.
        found: usize,
    },
    /// A significance that is no probability between 0 and 1.
    #[error("option significance: expected a number above 0 and below 1, found {found}")]
    Significance {
        /// The number asked for.
        found: f64,
    },
    /// The residuals of an output are zero or rounding: there is nothing to test.
    #[error("output `{output}`: expected residuals above rounding, found none")]
    NoResidual {
        /// The output's name.
        output: String,
    },
    /// A frequency below 0 or above half the sampling rate.
    #[error("frequency: expected 0 to {nyquist_hz} Hz (half the sampling rate), found {found} Hz")]
    Frequency {
        /// Half the sampling rate in Hz.
        nyquist_hz: f64,
        /// The frequency asked for in Hz.
        found: f64,
    },
    /// The model has a pole at a frequency of the unit circle.
    #[error("response at {frequency_hz} Hz: expected a finite value, found a pole there")]
    ResponseAtPole {
        /// The frequency in Hz.
        frequency_hz: f64,
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
