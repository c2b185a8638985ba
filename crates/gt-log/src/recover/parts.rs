//! Files that a process left behind when it died.

use std::fs::{self, File, TryLockError};
use std::path::{Path, PathBuf};

use super::{Recovery, recover};
use crate::LogError;
use crate::rotating_log::began_ns;

/// What became of a file that was left behind.
#[derive(Debug)]
pub struct PartRecovery {
    /// The file, `NAME.mcap.part`.
    pub part: PathBuf,
    /// What was written to `NAME.mcap`, or why there is none; the `.part` stays then.
    pub outcome: Result<Recovery, LogError>,
}

/// Recovers each `.part` that a [`RotatingLog`](crate::RotatingLog) of this folder and stem left
/// behind when its process died: what was flushed is in `NAME.mcap`, and the `.part` is gone. One that
/// a process still writes is left alone, as is one beside a file of its name.
///
/// # Errors
/// A folder that cannot be listed.
pub fn recover_parts(folder: &Path, stem: &str) -> Result<Vec<PartRecovery>, LogError> {
    let listing = fs::read_dir(folder).map_err(|cause| LogError::io(folder, "list", cause))?;
    let mut names: Vec<String> = listing
        .flatten()
        .filter_map(|entry| entry.file_name().into_string().ok())
        .filter(|name| {
            let whole = name.strip_suffix(".part");
            whole.is_some_and(|whole| began_ns(stem, whole).is_some())
        })
        .collect();
    names.sort_unstable();
    let mut found = Vec::new();
    for name in names {
        let part = folder.join(&name);
        let whole = part.with_extension("");
        if whole.exists() || is_written(&part) {
            continue;
        }
        let outcome = recover(&part, &whole).and_then(|recovery| {
            fs::remove_file(&part).map_err(|cause| LogError::io(&part, "remove", cause))?;
            Ok(recovery)
        });
        found.push(PartRecovery { part, outcome });
    }
    Ok(found)
}

/// Whether a process holds the lock that a [`RotatingLog`](crate::RotatingLog) has on its open file.
fn is_written(part: &Path) -> bool {
    let Ok(file) = File::open(part) else {
        return true;
    };
    // Given back when the file is closed.
    matches!(file.try_lock(), Err(TryLockError::WouldBlock))
}
