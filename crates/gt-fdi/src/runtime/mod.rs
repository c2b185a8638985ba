//! What runs beside the plant: residual generation, decision and the detector that joins them.
//!
//! The modules below use `core` and `alloc` only: no clock, no input or output, no randomness, and
//! nothing is allocated after construction. Time is an argument.

mod detector;
mod generator;
mod statistic;
mod statistics;

pub(crate) use detector::Channel;
pub use detector::{ChannelVerdict, Detector, StepError, Verdict};
pub(crate) use generator::{Generator, Matrices, Update};
pub use statistic::ExceedanceRun;
pub use statistics::{
    Change, Cusum, Decision, Glr, LARGEST_SAMPLE, MAX_WINDOW, MovingAverage, Sides, Sprt,
    SprtDecision, Statistic, StatisticError, Waveform, WindowedChiSquare,
};
