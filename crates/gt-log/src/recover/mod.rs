//! Mending logs that were cut off or changed.

mod claims;
mod copy;
mod definitions;
mod parts;
mod resync;
mod survey;

use std::collections::BTreeMap;
use std::path::Path;

use serde::Serialize;
use sha2::{Digest, Sha256};

use crate::LogError;
use crate::raw::RawFile;
use crate::source::hex;

use copy::copy;
pub use parts::{PartRecovery, recover_parts};
use survey::Survey;

/// What [`recover`] found and wrote.
#[derive(Debug, Clone, PartialEq, Eq, Serialize)]
pub struct Recovery {
    /// The file that was read, as it was named.
    pub file: String,
    /// Its size in bytes.
    pub size_bytes: u64,
    /// Its SHA-256 in hexadecimal digits.
    pub sha256: String,
    /// The file that was written, as it was named.
    pub out: String,
    /// Whether nothing was lost and the end of the file was there.
    pub sound: bool,
    /// Whether the end of the file was there: the end of its data, the footer and the last bytes.
    pub closed: bool,
    /// The messages that were written.
    pub messages: u64,
    /// The chunks whose messages were all written.
    pub whole_chunks: u64,
    /// Whether the messages of a chunk that is cut off were written as far as they go. Its checksum
    /// is that of the whole chunk, so that nothing vouches for them.
    pub cut_chunk: bool,
    /// The messages among these that do not decode by their schema: the checksum of their chunk says
    /// that they are as they were written.
    pub undecoded_messages: u64,
    /// The channels that were written, for the same reason, though their schema describes no messages
    /// of their encoding.
    pub undecoded_channels: u64,
    /// The metadata records that were written, by name.
    pub metadata: Vec<String>,
    /// The attachments that were written, by name.
    pub attachments: Vec<String>,
    /// The topics with what was written of them, by name.
    pub topics: Vec<RecoveredTopic>,
    /// The bytes that could not be used.
    pub lost_bytes: u64,
    /// What was lost, in the order of the file.
    pub losses: Vec<Loss>,
}

/// What was written of a topic.
#[derive(Debug, Clone, PartialEq, Eq, Serialize)]
pub struct RecoveredTopic {
    /// The topic.
    pub topic: String,
    /// Its messages.
    pub messages: u64,
    /// Its earliest log time in nanoseconds since 1970.
    pub first_ns: Option<u64>,
    /// Its latest log time in nanoseconds since 1970.
    pub last_ns: Option<u64>,
}

/// A part of a file that could not be used.
#[derive(Debug, Clone, PartialEq, Eq, Serialize)]
pub struct Loss {
    /// Where it begins in the file.
    pub offset: u64,
    /// How many bytes it has.
    pub bytes: u64,
    /// What it is.
    pub kind: LossKind,
    /// The earliest log time of its messages in nanoseconds since 1970, where the file tells it.
    pub first_ns: Option<u64>,
    /// The latest log time of its messages in nanoseconds since 1970, where the file tells it.
    pub last_ns: Option<u64>,
    /// What is wrong with it, in words.
    pub cause: String,
}

/// What was lost.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum LossKind {
    /// A chunk with all its messages.
    Chunk,
    /// The end of a chunk.
    EndOfChunk,
    /// An attachment.
    Attachment,
    /// A record of a kind that this version does not know.
    UnknownRecord,
    /// A record without the definition that it needs, such as a message of a channel that is lost.
    Undefined,
    /// A message that does not decode and for which no checksum vouches.
    Message,
    /// Bytes that are no record.
    Bytes,
}

impl LossKind {
    /// The kind in words.
    pub fn words(self) -> &'static str {
        match self {
            Self::Chunk => "chunk",
            Self::EndOfChunk => "end of a chunk",
            Self::Attachment => "attachment",
            Self::UnknownRecord => "unknown record",
            Self::Undefined => "without definition",
            Self::Message => "message",
            Self::Bytes => "bytes",
        }
    }
}

/// Writes all that is sound in `path` to `out`: the schemas, channels, metadata and attachments, and
/// every message of every chunk that is whole; of a chunk that is cut off by the end of the file the
/// messages before the cut, as far as its blocks can be unpacked.
///
/// A chunk that is whole but whose checksum does not match is left out with all its messages: nothing
/// tells which of them are right. Where there is no checksum (a chunk that is cut off, a message outside
/// a chunk, another writer's), a message is written if it decodes by its schema. Definitions are taken
/// from wherever they stand, the summary included; of several for one id, one with a checksum counts
/// before one that describes messages, and that before the others, which are lost. `path` may be a `NAME.part` that a crash left behind, and `out` its `NAME`.
///
/// The result has a summary of its own, and the metadata record `gtfdi.recovery` says what it was
/// made from and what was lost. The same file gives the same bytes.
///
/// # Errors
/// [`LogError::SameFile`] where `out` is `path`; [`LogError::NothingToRecover`] where no record of
/// an MCAP file is found; a file that cannot be read or written. There is then no `out`.
pub fn recover(path: &Path, out: &Path) -> Result<Recovery, LogError> {
    let mut file = RawFile::open(path)?;
    if let (Ok(from), Ok(to)) = (path.canonicalize(), out.canonicalize())
        && from == to
    {
        let path = path.to_owned();
        return Err(LogError::SameFile { path });
    }
    let mut survey = Survey::of(&mut file)?;
    if survey.pieces.is_empty() && survey.channels.is_empty() && survey.header.is_none() {
        return Err(LogError::NothingToRecover {
            path: path.to_owned(),
            size: file.size(),
        });
    }
    let sha256 = check_sums(&mut file, &mut survey)?;
    copy(path, &mut file, survey, out, sha256)
}

/// The file's SHA-256. Where every record is in its place but the checksum of them all does not
/// match, a record without a checksum of its own was changed: that is told.
fn check_sums(file: &mut RawFile, survey: &mut Survey) -> Result<String, LogError> {
    let mut sha = Sha256::new();
    let mut crc = crc32fast::Hasher::new();
    let end = survey.data_end.map_or(0, |(offset, _)| offset);
    let mut left = end;
    let size = file.size();
    file.blocks(size, |block| {
        sha.update(block);
        let own = usize::try_from(left).unwrap_or(usize::MAX).min(block.len());
        crc.update(&block[..own]);
        left -= own as u64;
    })?;
    let found = crc.finalize();
    let expected = survey.data_end.map(|(_, crc)| crc).filter(|crc| *crc != 0);
    survey.vouched = expected == Some(found);
    if let Some(expected) = expected
        && expected != found
        && survey.losses.is_empty()
    {
        survey.losses.push(Loss {
            offset: 0,
            bytes: 0,
            kind: LossKind::Bytes,
            first_ns: None,
            last_ns: None,
            cause: format!(
                "the data have the CRC {found:08x}, expected {expected:08x}: something without a \
                 checksum of its own was changed (a metadata record, an index, a message outside \
                 a chunk); it is written as it stands, where it decodes"
            ),
        });
    }
    Ok(hex(&sha.finalize()))
}

/// What the metadata record of a recovered log says.
fn provenance(size: u64, sha256: &str, losses: &[Loss]) -> BTreeMap<String, String> {
    let lost: u64 = losses.iter().map(|loss| loss.bytes).sum();
    let mut values = BTreeMap::from([
        ("source_sha256".to_owned(), sha256.to_owned()),
        ("source_bytes".to_owned(), size.to_string()),
        ("lost_bytes".to_owned(), lost.to_string()),
        ("version".to_owned(), env!("CARGO_PKG_VERSION").to_owned()),
    ]);
    let listed = losses.iter().take(1000).enumerate();
    values.extend(listed.map(|(index, loss)| {
        let text = format!(
            "{} at {}, {} bytes: {}",
            loss.kind.words(),
            loss.offset,
            loss.bytes,
            loss.cause
        );
        (format!("loss_{:04}", index + 1), text)
    }));
    values
}

/// Whether the file begins as an MCAP file does.
fn has_magic(file: &mut RawFile) -> Result<bool, LogError> {
    Ok(file.read(0, mcap::MAGIC.len() as u64)? == mcap::MAGIC)
}
