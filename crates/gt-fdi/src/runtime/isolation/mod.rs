//! Which fault: evidence for hypotheses, gathered sample by sample.

mod core;
mod diagnosis;
mod drive;
mod joint_whitener;
mod memory;
mod profile;
mod suffix;
#[cfg(test)]
mod tests;

pub use self::core::IsolationVerdict;
pub(crate) use self::core::{Core, CoreParts, HypothesisKind, HypothesisParts, LevelParts};
pub(crate) use diagnosis::DiagnosisOptions;
pub use diagnosis::{Diagnosis, Finding, Hypothesis, Pair};
pub(crate) use drive::{Drive, DriveParts};
pub(crate) use joint_whitener::{JointWhitener, JointWhitenerParts};
