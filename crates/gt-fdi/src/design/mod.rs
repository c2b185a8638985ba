//! From models and healthy records to a bank of detectors, and what the bank can tell apart.

mod bank;
mod calibration;
mod channels;
mod eiv_kalman;
mod false_alarm;
mod filter_error;
mod gains;
mod generator;
mod innovation;
mod kalman;
mod noise;
mod observer;
mod riccati;
mod settling;
mod signature;
mod threshold;
mod time_varying;

pub use bank::{Alarm, Bank, BankRun, OutputDetector, SCHEMA_VERSION};
pub use calibration::{Calibration, FalseAlarmSummary, calibrate};
pub use eiv_kalman::EivKalman;
pub use false_alarm::{FalseAlarmRate, count_alarms};
pub use filter_error::FilterError;
pub use generator::{MAX_SETTLE_SAMPLES, ResidualGenerator, SETTLE_LEVEL};
pub use innovation::Innovation;
pub use kalman::{FilterRun, KalmanFilter};
pub use noise::{DEFINITENESS_TOLERANCE, NoiseCovariance, SYMMETRY_TOLERANCE};
pub use observer::{MAX_OBSERVABILITY_CONDITION, place};
pub use riccati::{MAX_CLOSED_LOOP_RADIUS, MAX_DOUBLINGS, MAX_RICCATI_RESIDUAL, Riccati};
pub use signature::{Feature, SignatureMatrix, feature, signature};
pub use threshold::{FixedThreshold, ThresholdRule};
pub use time_varying::TimeVaryingKalman;
