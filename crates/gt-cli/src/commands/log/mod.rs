//! Verbs on logs, one file each.

use gt_log::LogError;

use crate::failure::Failure;

pub mod export;
pub mod info;
pub mod recover;
pub mod verify;

/// What could not be written is nobody's input: the names were checked before.
fn failure(error: LogError) -> Failure {
    match error {
        LogError::Io { .. } | LogError::Write { .. } | LogError::NoSpace { .. } => {
            Failure::failed(error)
        }
        error => Failure::input(error),
    }
}
