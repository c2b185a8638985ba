//! From hypotheses, generators and healthy records to a diagnosis of faults.

mod calibrate;
mod drive_noise;
mod effect;
mod isolator;
mod linear;
mod run;

pub use calibrate::IsolationDesign;
pub use effect::{EffectPair, FaultEffect, FaultHypothesis};
pub use isolator::{ISOLATION_SCHEMA_VERSION, Isolator};
pub use run::{IsolationDetector, IsolationEvent, IsolationRun};
