//! How a verb can end badly, and the exit code of each.

use std::fmt::Display;
use std::path::Path;

use anyhow::anyhow;

/// A failed verb.
#[derive(Debug)]
pub enum Failure {
    /// Usage, configuration or input data: exit code 2.
    Input(anyhow::Error),
    /// Anything else: exit code 1.
    Failed(anyhow::Error),
    /// Stopped by Ctrl-C: exit code 130, as shells give it.
    Stopped(anyhow::Error),
}

impl Failure {
    /// The exit code after Ctrl-C.
    pub const STOPPED: u8 = 130;

    /// A mistake in what was given.
    pub fn input(error: impl Display) -> Self {
        Self::Input(anyhow!("{error}"))
    }

    /// Work that Ctrl-C ended.
    pub fn stopped(error: impl Display) -> Self {
        Self::Stopped(anyhow!("{error}"))
    }

    /// A mistake in a named file.
    pub fn in_file(path: &Path, error: impl Display) -> Self {
        Self::Input(anyhow!("{}: {error}", path.display()))
    }

    /// A failure that is nobody's input.
    pub fn failed(error: impl Display) -> Self {
        Self::Failed(anyhow!("{error}"))
    }

    /// A required option that neither flags, environment nor file gave.
    pub fn missing(option: &str, example: &str) -> Self {
        Self::input(format!("{option}: required, for example {example}"))
    }

    /// The exit code.
    pub fn code(&self) -> u8 {
        match self {
            Self::Input(_) => 2,
            Self::Failed(_) => 1,
            Self::Stopped(_) => Self::STOPPED,
        }
    }

    /// The error to print.
    pub fn error(&self) -> &anyhow::Error {
        match self {
            Self::Input(error) | Self::Failed(error) | Self::Stopped(error) => error,
        }
    }
}
