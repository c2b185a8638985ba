//! What runs beside the plant: residual generation, decision and the detector that joins them.
//!
//! The modules below use `core` and `alloc` only: no clock, no input or output, no randomness, and
//! nothing is allocated after construction. Time is an argument. What is left of this crate without
//! its feature `design` is this module.

// What only the design half makes and calls is idle without it.
#![cfg_attr(not(feature = "design"), allow(dead_code, unused_imports))]

mod blocks;
mod channel;
mod clock;
mod columns;
mod detector;
mod detector_state;
mod evaluator;
mod exceedance_run;
pub(crate) mod fingerprint;
mod fleet;
mod generator;
mod isolation;
mod kernel;
pub(crate) mod lanes;
mod last_row;
mod rows;
mod statistics;
mod whitener;
pub(crate) mod wide;

pub use channel::ChannelVerdict;
pub(crate) use channel::{Channel, ChannelParts};
pub(crate) use clock::Clock;
pub use clock::StepError;
pub(crate) use detector::Parts;
pub use detector::{Detector, Verdict};
pub use detector_state::{DetectorState, ResumeError};
pub use evaluator::{Estimate, Evaluator, Modulus};
pub use exceedance_run::{ExceedanceRun, Persistence};
pub use fleet::{Fleet, FleetError};
pub(crate) use generator::{Generator, Matrices, Update};
pub(crate) use isolation::{
    Core, CoreParts, DiagnosisOptions, Drive, DriveParts, DriveSums, HypothesisKind,
    HypothesisParts, JointWhitener, JointWhitenerParts, LAGS, LagParts, LevelParts, Recall,
};
pub use isolation::{Diagnosis, Finding, Hypothesis, IsolationVerdict, Pair};
pub(crate) use rows::Rows;
pub use statistics::AdaptiveThreshold;
pub use statistics::CusumFleet;
pub use statistics::RunSum;
pub use statistics::ShiryaevRoberts;
pub use statistics::WindowedVariance;
pub use statistics::{
    Change, Cusum, Decision, Glr, LARGEST_SAMPLE, MAX_WINDOW, MovingAverage, Sides, Sprt,
    SprtDecision, Statistic, StatisticError, Waveform, WindowedChiSquare,
};
pub use statistics::{GrowingChiSquare, GrowingVariance, Growth};
pub use statistics::{MAX_LAGS, Whiteness};
pub(crate) use whitener::{Whitener, Whitening};
