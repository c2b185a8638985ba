//! From hypotheses, generators and healthy records to a diagnosis of faults.

mod calibrate;
mod detector;
mod drive_noise;
mod effect;
mod isolator;
mod linear;
mod monitor;
mod named;
mod run;
mod wander;

pub use calibrate::IsolationDesign;
pub use detector::{IsolationDetector, IsolationState};
pub use effect::{EffectPair, FaultEffect, FaultHypothesis};
pub use isolator::{ISOLATION_SCHEMA_VERSION, Isolator};
pub use monitor::{IsolationEvent, IsolationMonitor, MonitorState};
pub use named::{NamedAlarm, NamedDiagnosis, NamedHypothesis, NamedPair};
pub use run::{IsolationAlarm, IsolationRun};
