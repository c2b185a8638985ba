//! What built this binary.

use serde::Serialize;

/// The version, the commit and the compiler of this build.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
pub struct BuildInfo {
    /// The version of the workspace.
    pub version: &'static str,
    /// The short hash of the commit, or `unknown` where it was built without git.
    pub git: &'static str,
    /// The first line of `rustc --version`.
    pub rustc: &'static str,
}

/// What built this binary.
pub fn build_info() -> BuildInfo {
    BuildInfo {
        version: env!("CARGO_PKG_VERSION"),
        git: env!("GT_LOG_GIT"),
        rustc: env!("GT_LOG_RUSTC"),
    }
}
