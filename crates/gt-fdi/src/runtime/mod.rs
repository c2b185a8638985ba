//! What runs beside the plant: residual generation, decision and the detector that joins them.
//!
//! The modules below use `core` and `alloc` only: no clock, no input or output, no randomness, and
//! nothing is allocated after construction. Time is an argument.

mod detector;
mod generator;
mod statistic;

pub(crate) use detector::Channel;
pub use detector::{ChannelVerdict, Detector, StepError, Verdict};
pub(crate) use generator::{Generator, Matrices, Update};
pub use statistic::ExceedanceRun;
