//! What the fuzz targets share: a file of the bytes, and bytes read as numbers.

use std::path::Path;
use std::sync::LazyLock;

use tempfile::TempDir;

// In memory where the system has such a folder: a target runs thousands of times a second.
static FOLDER: LazyLock<TempDir> = LazyLock::new(|| {
    let memory = Path::new("/dev/shm");
    let made = if memory.is_dir() {
        TempDir::new_in(memory)
    } else {
        TempDir::new()
    };
    made.expect("a temporary folder")
});

/// Writes the bytes to a file of this name and hands its path on.
pub fn with_file<T>(name: &str, bytes: &[u8], read: impl FnOnce(&Path) -> T) -> T {
    let path = FOLDER.path().join(name);
    std::fs::write(&path, bytes).expect("a file in a temporary folder");
    read(&path)
}

/// The folder of [`with_file`].
pub fn folder() -> &'static Path {
    FOLDER.path()
}

/// Bytes as choices and numbers; after the last one comes 0.
#[derive(Debug)]
pub struct Bytes<'a>(pub &'a [u8]);

impl Bytes<'_> {
    /// The next byte.
    pub fn byte(&mut self) -> u8 {
        let Some((first, rest)) = self.0.split_first() else {
            return 0;
        };
        self.0 = rest;
        *first
    }

    /// The next eight bytes.
    pub fn bits(&mut self) -> u64 {
        (0..8).fold(0, |bits, _| bits << 8 | u64::from(self.byte()))
    }

    /// A number: any at all, or one of those that are near what machines measure.
    pub fn number(&mut self) -> f64 {
        match self.byte() % 8 {
            0 => f64::from_bits(self.bits()),
            1 => f64::NAN,
            2 => f64::MAX,
            3 => 0.0,
            _ => (f64::from(self.byte()) - 128.0) * 10.0_f64.powi(i32::from(self.byte() % 9) - 4),
        }
    }

    /// Whether there are bytes left.
    pub fn is_empty(&self) -> bool {
        self.0.is_empty()
    }
}
