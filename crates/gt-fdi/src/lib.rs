//! Residual generators, thresholds, signatures and the online detector.
//!
//! [`design`] turns identified models and healthy records into a [`design::Bank`] of output
//! observers with fixed thresholds and measured false-alarm rates; [`runtime`] runs that bank
//! sample by sample, without allocating, with the same results bit for bit.
//!
//! Source of the method: S. Simani, C. Fantuzzi, *Dynamic system identification and model-based
//! fault diagnosis of an industrial gas turbine prototype*, Mechatronics 16 (2006), section 4.2,
//! called *the paper* in this crate; its equation numbers are quoted.

extern crate alloc;

pub mod design;
mod error;
pub mod runtime;

pub use design::{
    Alarm, Bank, BankRun, Calibration, CusumRunLength, EivKalman, Evaluation, ExceedanceRunLength,
    FalseAlarmRate, FalseAlarmSummary, Feature, FilterError, FilterRun, FixedThreshold, Innovation,
    KalmanFilter, MeanTime, NoiseCovariance, ResidualGenerator, ResidualTest, Riccati,
    SUPPORTED_FACTOR, SignatureMatrix, SimulatedRunLength, SimulatedRuns, StatisticKind,
    ThresholdRule, TimeVaryingKalman, Whitening, calibrate, count_alarms, feature,
    mean_delay_bound, place, signature,
};
pub use design::{
    Attempt, Criterion, DataBound, EnergyRatio, ObserverDesign, PoleSearch, RecordPair,
    SearchError, SearchMethod, Sections, Start,
};
pub use design::{PlacementError, SchurPlacement, StabilityBound, place_complex};
pub use error::FdiError;
pub use runtime::{
    Change, ChannelVerdict, Cusum, Decision, Detector, DetectorState, Estimate, Evaluator,
    ExceedanceRun, Glr, Modulus, MovingAverage, Persistence, ResumeError, Sides, Sprt,
    SprtDecision, Statistic, StatisticError, StepError, Verdict, Waveform, WindowedChiSquare,
};
