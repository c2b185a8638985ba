//! Files that appear whole or not at all.

use std::ffi::OsString;
use std::fs::{self, File};
use std::io::Write;
use std::path::{Path, PathBuf};

use crate::LogError;

/// A file under construction, `NAME.part`. Dropped before [`Part::publish`], it is removed.
#[derive(Debug)]
pub(crate) struct Part {
    target: PathBuf,
    temporary: PathBuf,
    /// A second handle, to wait for the disk while the first is inside a writer.
    handle: File,
    published: bool,
}

impl Part {
    /// Opens `NAME.part`; one that a crash left behind is overwritten.
    pub(crate) fn create(target: &Path) -> Result<(Self, File), LogError> {
        Self::create_with(target, ".part")
    }

    /// Opens the target's name with `suffix` behind it, for work that may read `NAME.part`.
    pub(crate) fn create_with(target: &Path, suffix: &str) -> Result<(Self, File), LogError> {
        if target.is_dir() {
            return Err(LogError::Directory {
                path: target.to_owned(),
            });
        }
        let mut part = OsString::from(target);
        part.push(suffix);
        let temporary = PathBuf::from(part);
        let file =
            File::create(&temporary).map_err(|cause| LogError::io(&temporary, "create", cause))?;
        let handle = file
            .try_clone()
            .map_err(|cause| LogError::io(&temporary, "open", cause))?;
        Ok((
            Self {
                target: target.to_owned(),
                temporary,
                handle,
                published: false,
            },
            file,
        ))
    }

    /// Waits until what was written is on the disk.
    pub(crate) fn sync(&self) -> Result<(), LogError> {
        self.handle
            .sync_all()
            .map_err(|cause| LogError::io(&self.temporary, "sync", cause))
    }

    /// The bytes that were written so far.
    pub(crate) fn size(&self) -> Result<u64, LogError> {
        let metadata = self.handle.metadata();
        metadata
            .map(|own| own.len())
            .map_err(|cause| LogError::io(&self.temporary, "read the size", cause))
    }

    /// Leaves the file under its temporary name when it is dropped.
    pub(crate) fn keep(&mut self) {
        self.published = true;
    }

    /// The file's final name.
    pub(crate) fn target(&self) -> &Path {
        &self.target
    }

    /// Puts the bytes on the disk and gives the file its name.
    pub(crate) fn publish(mut self, file: File) -> Result<(), LogError> {
        drop(file);
        self.sync()?;
        fs::rename(&self.temporary, &self.target)
            .map_err(|cause| LogError::io(&self.target, "rename the finished file", cause))?;
        self.published = true;
        sync_directory(&self.target)
    }
}

impl Drop for Part {
    fn drop(&mut self) {
        if !self.published {
            // Nobody is left to hear of a failure here, and the name says what the rest is.
            let _ = fs::remove_file(&self.temporary);
        }
    }
}

/// The new name survives a power failure only when the directory is on the disk too.
#[cfg(unix)]
fn sync_directory(target: &Path) -> Result<(), LogError> {
    let directory = match target.parent() {
        Some(parent) if !parent.as_os_str().is_empty() => parent,
        _ => Path::new("."),
    };
    match File::open(directory).and_then(|directory| directory.sync_all()) {
        // Some file systems have no such thing; the file itself is whole and named.
        Err(cause)
            if matches!(
                cause.kind(),
                std::io::ErrorKind::InvalidInput
                    | std::io::ErrorKind::Unsupported
                    | std::io::ErrorKind::PermissionDenied
            ) =>
        {
            Ok(())
        }
        Err(cause) => Err(LogError::io(directory, "sync the directory", cause)),
        Ok(()) => Ok(()),
    }
}

#[cfg(not(unix))]
#[expect(clippy::unnecessary_wraps, reason = "the same signature as on Unix")]
fn sync_directory(_target: &Path) -> Result<(), LogError> {
    Ok(())
}

/// Writes `bytes` to `path`: as `path.part`, on the disk, then renamed. A reader sees the old file
/// or the new one, never half of either.
///
/// # Errors
/// [`LogError::Io`] or [`LogError::Directory`]; the old file is then untouched.
pub fn write_atomically(path: &Path, bytes: &[u8]) -> Result<(), LogError> {
    let (part, mut file) = Part::create(path)?;
    file.write_all(bytes)
        .map_err(|cause| LogError::io(path, "write", cause))?;
    part.publish(file)
}
