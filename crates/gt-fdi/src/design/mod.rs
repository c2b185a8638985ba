//! From models and healthy records to a bank of detectors, and what the bank can tell apart.
//!
//! A [`ResidualTest`] turns the residuals of some generators into a number (as they are, or through
//! a [`Whitening`] and a [`StatisticKind`]) and compares it with a limit that healthy records set. A
//! [`Bank`] is generators and tests.
//!
//! # Run lengths
//!
//! How long a detector runs before it alarms can be computed before any is built, for residuals that
//! are whitened and in units of their standard deviation: independent and normal with variance 1,
//! mean 0 while healthy. Residuals that are not will alarm at other times than these numbers say,
//! mostly sooner. A run length counts the samples up to and including the alarm; its mean without a
//! fault (ARL0) is the mean time between false alarms in samples.
//!
//! | detector | run length |
//! |---|---|
//! | [`Cusum`](crate::runtime::Cusum) | [`CusumRunLength`], from an integral equation |
//! | a limit, or a number of samples in a row beyond it | [`ExceedanceRunLength`], closed form |
//! | [`ShiryaevRoberts`](crate::runtime::ShiryaevRoberts), one side | [`ShiryaevRobertsRunLength`], from an integral equation |
//! | [`RunSum`](crate::runtime::RunSum) | [`RunSumRunLength`], from a Markov chain |
//! | any [`Statistic`](crate::runtime::Statistic) | [`SimulatedRuns`], with an interval |
//! | none can be faster | [`mean_delay_bound`] |

mod bank;
mod calibration;
mod channels;
mod doubling;
mod eiv_kalman;
mod false_alarm;
mod filter_error;
mod gains;
mod generator;
mod innovation;
mod isolating_residuals;
mod isolation;
mod joint_whitening;
mod kalman;
mod mean_time;
mod noise;
mod observer;
mod optimise;
mod placement;
mod residual_test;
mod riccati;
mod run_length;
mod scheduled;
mod settling;
mod signature;
mod small_square;
mod statistic_kind;
mod tail;
mod threshold;
mod time_varying;
mod unknown_input;
mod whitening;

pub use bank::{Alarm, Bank, BankRun, SCHEMA_VERSION};
pub use calibration::{Calibration, FalseAlarmSummary, calibrate};
pub use eiv_kalman::EivKalman;
pub use false_alarm::{FalseAlarmRate, count_alarms};
pub use filter_error::FilterError;
pub use generator::{MAX_PREDICTED_RADIUS, MAX_SETTLE_SAMPLES, ResidualGenerator, SETTLE_LEVEL};
pub use innovation::Innovation;
pub use isolating_residuals::IsolatingResiduals;
pub use isolation::{
    EffectPair, FaultEffect, FaultHypothesis, ISOLATION_SCHEMA_VERSION, IsolationAlarm,
    IsolationDesign, IsolationDetector, IsolationEvent, IsolationMonitor, IsolationRun,
    IsolationState, Isolator, MonitorState, NamedAlarm, NamedDiagnosis, NamedHypothesis, NamedPair,
};
pub use joint_whitening::JointWhitening;
pub use kalman::{FilterRun, KalmanFilter};
pub use mean_time::{MeanTime, SUPPORTED_FACTOR};
pub use noise::{DEFINITENESS_TOLERANCE, NoiseCovariance, SYMMETRY_TOLERANCE};
pub use observer::place_complex;
pub use observer::{MAX_OBSERVABILITY_CONDITION, place};
pub use optimise::{
    Attempt, Criterion, DataBound, EnergyRatio, ObserverDesign, PoleSearch, RecordPair,
    SearchError, SearchMethod, Sections, Start,
};
pub use placement::{PlacementError, SchurPlacement, StabilityBound};
pub use residual_test::{Evaluation, ResidualTest};
pub use riccati::{MAX_CLOSED_LOOP_RADIUS, MAX_DOUBLINGS, MAX_RICCATI_RESIDUAL, Riccati};
pub use run_length::{
    CusumRunLength, ExceedanceRunLength, MAX_CONSECUTIVE, MAX_CUSUM_THRESHOLD, MAX_RUN_LENGTH,
    MIN_ALARMS, SimulatedRunLength, SimulatedRuns, mean_delay_bound,
};
pub use run_length::{MAX_RUN_SUM_THRESHOLD, RunSumRunLength};
pub use run_length::{
    MAX_SHIRYAEV_ROBERTS_THRESHOLD, SHIRYAEV_ROBERTS_SHIFTS, ShiryaevRobertsRunLength,
};
pub use scheduled::{Blend, ScheduleError, ScheduledGenerators, ScheduledPoint, ScheduledRun};
pub use signature::{Feature, SignatureMatrix, feature, signature};
pub use statistic_kind::StatisticKind;
pub use tail::MIN_PEAKS;
pub use threshold::{FixedThreshold, ThresholdRule};
pub use time_varying::TimeVaryingKalman;
pub use unknown_input::{
    FaultModel, FrequencyBand, LinearResidual, MIN_DECOUPLING_GAIN, MIN_DETECTABILITY, MIN_REACH,
    PEAK_TOLERANCE, PeakGain, Robustness, UnifiedFilter, UnknownInput, UnknownInputError,
    UnknownInputObserver, peak_gain,
};
pub use whitening::{MAX_WHITENING_ORDER, Whitening};
