//! Doors to parsers that are private, for the fuzz targets alone.

#![allow(clippy::expect_used)] // a failed promise is what is looked for

use std::path::Path;

use crate::http::Access;
use crate::journal::JournalFile;
use crate::service::turbine_hub;
use crate::source::message::{Origin, read};

/// Reads a message of the embedded turbine, under the topic of a tag or none.
pub fn read_message(bytes: &[u8], tag: Option<&str>) {
    let origin = Origin { machine: None, tag };
    let _ = read(&turbine_hub(), bytes, origin, 1_700_000_000_000_000_000);
}

/// Opens a journal; one that can be opened holds the same when it is opened again.
pub fn open_journal(path: &Path) {
    if let Ok((journal, before)) = JournalFile::open(path) {
        drop(journal);
        let (_, after) = JournalFile::open(path).expect("what was written can be read");
        assert!(before.alarms().eq(after.alarms()));
    }
}

/// Reads tokens.
pub fn read_tokens(path: &Path) {
    let _ = Access::read(path);
}
