//! What runs beside the plant: residual generation, decision and the detector that joins them.
//!
//! The modules below use `core` and `alloc` only: no clock, no input or output, no randomness, and
//! nothing is allocated after construction. Time is an argument. What is left of this crate without
//! its feature `design` is this module.

// What only the design half makes and calls is idle without it.
#[cfg_attr(not(feature = "design"), allow(dead_code))]
mod detector;
#[cfg_attr(not(feature = "design"), allow(dead_code))]
mod generator;
mod statistic;
mod statistics;

#[cfg(feature = "design")]
pub(crate) use detector::Channel;
pub use detector::{ChannelVerdict, Detector, StepError, Verdict};
#[cfg(feature = "design")]
pub(crate) use generator::Matrices;
pub(crate) use generator::{Generator, Update};
pub use statistic::ExceedanceRun;
pub use statistics::AdaptiveThreshold;
pub use statistics::RunSum;
pub use statistics::ShiryaevRoberts;
pub use statistics::WindowedVariance;
pub use statistics::{
    Change, Cusum, Decision, Glr, LARGEST_SAMPLE, MAX_WINDOW, MovingAverage, Sides, Sprt,
    SprtDecision, Statistic, StatisticError, Waveform, WindowedChiSquare,
};
pub use statistics::{GrowingChiSquare, GrowingVariance, Growth};
pub use statistics::{MAX_LAGS, Whiteness};
