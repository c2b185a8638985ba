//! Which fault: evidence for hypotheses, gathered sample by sample.

mod core;
mod diagnosis;
mod drive;
mod joint_whitener;
mod lag;
mod limiter;
mod memory;
mod pairs;
mod profile;
mod recall;
mod score;
mod suffix;
#[cfg(test)]
mod tests;

pub use self::core::IsolationVerdict;
pub(crate) use self::core::{
    Core, CoreParts, DriveSums, HypothesisKind, HypothesisParts, LevelParts,
};
pub(crate) use diagnosis::DiagnosisOptions;
pub use diagnosis::{Diagnosis, Finding, Hypothesis, Pair};
pub(crate) use drive::{Drive, DriveParts};
pub(crate) use joint_whitener::{JointWhitener, JointWhitenerParts};
pub(crate) use lag::{LAGS, LagParts};
pub(crate) use recall::Recall;
