//! One process at a time in a folder.

use std::fs::{File, TryLockError};
use std::path::Path;

use crate::error::CampaignError;

/// The lock's name.
pub(super) const NAME: &str = "campaign.lock";

/// Locks a folder as long as the file that it gives is open; a process that ends lets go, however it
/// ends.
///
/// # Errors
/// [`CampaignError::Busy`] where another process has it, [`CampaignError::Folder`].
pub(super) fn lock(path: &Path) -> Result<File, CampaignError> {
    let lock_path = path.join(NAME);
    let failed = |source| CampaignError::Folder {
        path: lock_path.clone(),
        source,
    };
    let file = File::create(&lock_path).map_err(failed)?;
    match file.try_lock() {
        Ok(()) => Ok(file),
        Err(TryLockError::WouldBlock) => Err(CampaignError::Busy {
            path: path.to_owned(),
        }),
        // A file system without locks has nobody who could hold one.
        Err(TryLockError::Error(source)) if source.kind() == std::io::ErrorKind::Unsupported => {
            Ok(file)
        }
        Err(TryLockError::Error(source)) => Err(failed(source)),
    }
}
