//! From models and healthy records to a bank of detectors, and what the bank can tell apart.

mod bank;
mod calibration;
mod channels;
mod false_alarm;
mod generator;
mod observer;
mod signature;
mod threshold;

pub use bank::{Alarm, Bank, BankRun, OutputDetector, SCHEMA_VERSION};
pub use calibration::{Calibration, FalseAlarmSummary, calibrate};
pub use false_alarm::{FalseAlarmRate, count_alarms};
pub use generator::{MAX_SETTLE_SAMPLES, ResidualGenerator, SETTLE_LEVEL};
pub use observer::{MAX_OBSERVABILITY_CONDITION, place};
pub use signature::{Feature, SignatureMatrix, feature, signature};
pub use threshold::{FixedThreshold, ThresholdRule};
