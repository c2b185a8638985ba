//! What can go wrong in the service.

use std::path::{Path, PathBuf};

use gt_log::LogError;
use thiserror::Error;

use crate::pipeline::MachineError;

/// An error of the service.
#[derive(Debug, Error)]
pub enum ServeError {
    /// A file cannot be read or written.
    #[error("{path}: cannot {what}: {cause}", path = .path.display())]
    Io {
        /// `read`, `write` or the like.
        what: &'static str,
        /// The file.
        path: PathBuf,
        /// Why.
        cause: String,
    },
    /// A line of the journal is not an event.
    #[error("{path}: line {line}: expected an event of an alarm: {cause}; move the file away to begin another", path = .path.display())]
    Journal {
        /// The file.
        path: PathBuf,
        /// The line, from 1.
        line: usize,
        /// What is wrong with it.
        cause: String,
    },
    /// An option of the configuration makes no sense.
    #[error("{option}: expected {expected}, found {found}")]
    Option {
        /// The option, with its section.
        option: String,
        /// What it may be.
        expected: String,
        /// What it is.
        found: String,
    },
    /// A configuration that is not TOML, or has keys that there are not.
    #[error("{path}: {cause}", path = .path.display())]
    Config {
        /// The file.
        path: PathBuf,
        /// What is wrong, with its line.
        cause: String,
    },
    /// A machine cannot be set up.
    #[error("machine `{machine}`: {cause}")]
    Machine {
        /// The machine.
        machine: String,
        /// Why.
        cause: MachineError,
    },
    /// Of a file of a detector, a record or a log.
    #[error(transparent)]
    Log(#[from] LogError),
    /// The embedded plant cannot be started.
    #[error("embedded plant: {0}")]
    Plant(#[from] gtfdi::plant::PlantError),
    /// An address cannot be listened on.
    #[error("{option}: cannot listen on {address}: {cause}")]
    Listen {
        /// The option.
        option: &'static str,
        /// The address.
        address: String,
        /// Why.
        cause: std::io::Error,
    },
    /// Something of the operating system failed.
    #[error("{what}: {cause}")]
    System {
        /// What was tried.
        what: &'static str,
        /// Why it failed.
        cause: std::io::Error,
    },
}

impl ServeError {
    pub(crate) fn io(what: &'static str, path: &Path, cause: &std::io::Error) -> Self {
        Self::Io {
            what,
            path: path.to_owned(),
            cause: cause.to_string(),
        }
    }

    pub(crate) fn option(
        option: impl Into<String>,
        expected: impl Into<String>,
        found: impl Into<String>,
    ) -> Self {
        Self::Option {
            option: option.into(),
            expected: expected.into(),
            found: found.into(),
        }
    }
}
