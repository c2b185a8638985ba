//! From models and healthy records to a bank of detectors, and what the bank can tell apart.
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
//! | any [`Statistic`](crate::runtime::Statistic) | [`SimulatedRuns`], with an interval |
//! | none can be faster | [`mean_delay_bound`] |

mod bank;
mod calibration;
mod channels;
mod false_alarm;
mod generator;
mod observer;
mod run_length;
mod signature;
mod threshold;

pub use bank::{Alarm, Bank, BankRun, OutputDetector, SCHEMA_VERSION};
pub use calibration::{Calibration, FalseAlarmSummary, calibrate};
pub use false_alarm::{FalseAlarmRate, count_alarms};
pub use generator::{MAX_SETTLE_SAMPLES, ResidualGenerator, SETTLE_LEVEL};
pub use observer::{MAX_OBSERVABILITY_CONDITION, place};
pub use run_length::{
    CusumRunLength, ExceedanceRunLength, MAX_CONSECUTIVE, MAX_CUSUM_THRESHOLD, MAX_RUN_LENGTH,
    MIN_ALARMS, SimulatedRunLength, SimulatedRuns, mean_delay_bound,
};
pub use signature::{Feature, SignatureMatrix, feature, signature};
pub use threshold::{FixedThreshold, ThresholdRule};
