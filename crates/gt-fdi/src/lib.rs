//! Residual generators, thresholds, signatures and the online detector.
//!
//! [`design`] turns identified models and healthy records into a [`design::Bank`] of output
//! observers with fixed thresholds and measured false-alarm rates; [`runtime`] runs that bank
//! sample by sample, without allocating, with the same results bit for bit.
//!
//! # From a model to a verdict
//!
//! | step | by | of the paper |
//! |---|---|---|
//! | residuals | [`design::ResidualGenerator`]: an observer with placed poles, or a Kalman filter for the noise of all channels | eq. 22, 27 |
//! | the poles | given, or searched by records with a fault: [`design::PoleSearch`] | eq. 23, 24 |
//! | a number of them | [`design::StatisticKind`], of the residual as it is or of what [`design::Whitening`] leaves | section 5.7 |
//! | a limit | [`design::ResidualTest::calibrate`] with a [`design::ThresholdRule`], on healthy records | eq. 26 |
//! | what the limit promises | [`design::FalseAlarmRate`], counted by cross-validation; [`design::MeanTime`], extrapolated with its interval | |
//! | all together | [`design::Bank`], and [`runtime::Detector`] sample by sample | |
//! | which fault, since when, how large | [`design::Isolator`], and [`design::IsolationMonitor`] sample by sample | Table 9, 10 |
//! | which output shows which fault | [`design::signature()`] | Table 2, 9 |
//!
//! How soon a fault of a size can be seen at all, and by what, [`design`] computes before anything is
//! built. The example of the facade crate `gtfdi` goes the whole way.
//!
//! Source of the method: S. Simani, C. Fantuzzi, *Dynamic system identification and model-based
//! fault diagnosis of an industrial gas turbine prototype*, Mechatronics 16 (2006), section 4.2,
//! called *the paper* in this crate; its equation numbers are quoted.
//!
//! # Features
//!
//! | feature | default | what it adds |
//! |---|---|---|
//! | `design` | yes | [`design`] and [`FdiError`], which need std |
//!
//! Without it, [`runtime`] is left, for targets that have `core` and `alloc` only.

#![cfg_attr(not(feature = "design"), no_std)]

extern crate alloc;

#[cfg(feature = "design")]
pub mod design;
#[cfg(feature = "design")]
mod error;
pub mod runtime;

#[cfg(feature = "design")]
pub use design::RunSumRunLength;
#[cfg(feature = "design")]
pub use design::ShiryaevRobertsRunLength;
#[cfg(feature = "design")]
pub use design::{
    Alarm, Bank, BankRun, Calibration, CusumRunLength, EivKalman, Evaluation, ExceedanceRunLength,
    FalseAlarmRate, FalseAlarmSummary, Feature, FilterError, FilterRun, FixedThreshold, Innovation,
    JointWhitening, KalmanFilter, MeanTime, NoiseCovariance, ResidualGenerator, ResidualTest,
    Riccati, SUPPORTED_FACTOR, SignatureMatrix, SimulatedRunLength, SimulatedRuns, StatisticKind,
    ThresholdRule, TimeVaryingKalman, Whitening, calibrate, count_alarms, feature,
    mean_delay_bound, place, signature,
};
#[cfg(feature = "design")]
pub use design::{
    Attempt, Criterion, DataBound, EnergyRatio, ObserverDesign, PoleSearch, RecordPair,
    SearchError, SearchMethod, Sections, Start,
};
#[cfg(feature = "design")]
pub use design::{Blend, ScheduleError, ScheduledGenerators, ScheduledPoint, ScheduledRun};
#[cfg(feature = "design")]
pub use design::{
    EffectPair, FaultEffect, FaultHypothesis, IsolatingResiduals, IsolationAlarm, IsolationDesign,
    IsolationDetector, IsolationEvent, IsolationMonitor, IsolationRun, IsolationState, Isolator,
    MonitorState, NamedAlarm, NamedDiagnosis, NamedHypothesis, NamedPair,
};
#[cfg(feature = "design")]
pub use design::{
    FaultModel, FrequencyBand, LinearResidual, PeakGain, Robustness, UnifiedFilter, UnknownInput,
    UnknownInputError, UnknownInputObserver, peak_gain,
};
#[cfg(feature = "design")]
pub use design::{PlacementError, SchurPlacement, StabilityBound, place_complex};
#[cfg(feature = "design")]
pub use error::FdiError;
pub use runtime::{
    AdaptiveThreshold, GrowingChiSquare, GrowingVariance, Growth, RunSum, ShiryaevRoberts,
    Whiteness, WindowedVariance,
};
pub use runtime::{
    Change, ChannelVerdict, Cusum, CusumFleet, Decision, Detector, DetectorState, Estimate,
    Evaluator, ExceedanceRun, Fleet, FleetError, Glr, Modulus, MovingAverage, Persistence,
    ResumeError, Sides, Sprt, SprtDecision, Statistic, StatisticError, StepError, Verdict,
    Waveform, WindowedChiSquare,
};
pub use runtime::{Diagnosis, Finding, Hypothesis, IsolationVerdict, Pair};
