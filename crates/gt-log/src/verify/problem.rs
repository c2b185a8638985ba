//! What is wrong with a log.

use serde::Serialize;

/// Something that a log should not have.
#[derive(Debug, Clone, PartialEq, Eq, Serialize)]
pub struct Problem {
    /// The offset of the record in the file, or of the chunk that holds it.
    pub offset: u64,
    /// Whether the log is damaged.
    pub severity: Severity,
    /// What it is about.
    pub kind: ProblemKind,
    /// What was expected and what was found.
    pub text: String,
}

/// How bad a problem is.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Severity {
    /// The log breaks the format, or its parts do not agree.
    Damage,
    /// The format allows it, and a reader should know.
    Remark,
}

/// What a problem is about.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum ProblemKind {
    /// The first or the last bytes.
    Magic,
    /// A record: its length, its fields, its place.
    Record,
    /// A chunk.
    Chunk,
    /// An attachment.
    Attachment,
    /// A schema or a channel.
    Definition,
    /// A message.
    Message,
    /// An index.
    Index,
    /// The statistics.
    Statistics,
    /// The checksum of the data or of the summary.
    Checksum,
    /// The order of messages.
    Order,
}

impl ProblemKind {
    /// The kind in a word.
    pub fn word(self) -> &'static str {
        match self {
            Self::Magic => "magic",
            Self::Record => "record",
            Self::Chunk => "chunk",
            Self::Attachment => "attachment",
            Self::Definition => "definition",
            Self::Message => "message",
            Self::Index => "index",
            Self::Statistics => "statistics",
            Self::Checksum => "checksum",
            Self::Order => "order",
        }
    }
}

/// More problems than these are counted, not listed.
const LISTED: usize = 1000;

/// The problems of a file.
#[derive(Debug, Default)]
pub(super) struct Problems {
    pub(super) listed: Vec<Problem>,
    pub(super) more: u64,
    pub(super) damaged: bool,
}

impl Problems {
    pub(super) fn damage(&mut self, offset: u64, kind: ProblemKind, text: impl Into<String>) {
        self.damaged = true;
        self.push(offset, Severity::Damage, kind, text.into());
    }

    pub(super) fn remark(&mut self, offset: u64, kind: ProblemKind, text: impl Into<String>) {
        self.push(offset, Severity::Remark, kind, text.into());
    }

    fn push(&mut self, offset: u64, severity: Severity, kind: ProblemKind, text: String) {
        if self.listed.len() < LISTED {
            self.listed.push(Problem {
                offset,
                severity,
                kind,
                text,
            });
        } else {
            self.more += 1;
        }
    }
}
