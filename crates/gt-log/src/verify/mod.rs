//! Whether a log is what the format says it is.

mod chunk;
mod content;
mod problem;
mod summary;
mod walk;

use std::path::Path;

use serde::Serialize;

use crate::LogError;
use crate::raw::RawFile;

pub use problem::{Problem, ProblemKind, Severity};

/// What [`verify`] found.
#[derive(Debug, Clone, PartialEq, Eq, Serialize)]
pub struct Verification {
    /// The file as it was named.
    pub file: String,
    /// Its size in bytes.
    pub size_bytes: u64,
    /// Its SHA-256 in hexadecimal digits.
    pub sha256: String,
    /// Whether there is no damage. Remarks are none.
    pub sound: bool,
    /// The messages that were found.
    pub messages: u64,
    /// Of these, those that were decoded by their schema or as JSON.
    pub decoded_messages: u64,
    /// The encodings of the others: what is in them was not judged.
    pub foreign_encodings: Vec<String>,
    /// The chunks.
    pub chunks: u64,
    /// The attachments.
    pub attachments: u64,
    /// The metadata records.
    pub metadata: u64,
    /// Whether the file has a summary.
    pub summary: bool,
    /// The problems, in the order of the file.
    pub problems: Vec<Problem>,
    /// How many more there are than are listed.
    pub more_problems: u64,
}

/// Reads a whole log and compares it with the format, record by record:
///
/// - the first and last bytes; every record's length and fields;
/// - the checksums of chunks, attachments, data and summary, where they are not zero;
/// - chunks: that they unpack to the size and the times that they say, and hold nothing but schemas,
///   channels and messages;
/// - indexes of messages, chunks, attachments and metadata, statistics and offsets of the summary:
///   that they agree with what is there, and leave nothing out;
/// - schemas and channels: that each is known before its messages and never changes;
/// - messages: that each decodes by its schema, and, as remarks, that the sequence rises and time
///   does not go back on each channel.
///
/// # Errors
/// Only a file that cannot be read: what is wrong with one that can is a [`Problem`].
pub fn verify(path: &Path) -> Result<Verification, LogError> {
    let mut file = RawFile::open(path)?;
    let mut walk = walk::Walk::new(path);
    walk.run(&mut file)?;
    let sha256 = walk.check_sums(&mut file)?;
    Ok(walk.finish(path, file.size(), sha256))
}
