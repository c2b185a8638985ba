//! The errors of this crate.

use std::fmt;
use std::io;
use std::path::{Path, PathBuf};

use gt_core::DataError;

use crate::import::ReadingError;

/// Why a file could not be read or written.
///
/// The text is complete: it carries its cause, so there is no `source` that would say it twice.
#[derive(Debug, thiserror::Error)]
pub enum LogError {
    /// There is no such file.
    #[error("{}: there is no such file", path.display())]
    NotFound {
        /// The file.
        path: PathBuf,
    },
    /// A directory where a file was expected.
    #[error("{}: expected a file, found a directory", path.display())]
    Directory {
        /// The directory.
        path: PathBuf,
    },
    /// The operating system refused.
    #[error("{}: could not {action}: {cause}", path.display())]
    Io {
        /// The file.
        path: PathBuf,
        /// What was tried.
        action: &'static str,
        /// What the operating system said.
        cause: io::Error,
    },
    /// A file type that no reader knows, by its extension.
    #[error("{}: expected a file that ends in .csv, .parquet or .mcap, found {found}", path.display())]
    Extension {
        /// The file.
        path: PathBuf,
        /// The extension found, in words.
        found: String,
    },

    /// Bytes that are not UTF-8 text.
    #[error(
        "{}: line {line}: expected UTF-8 text, found the byte 0x{found:02x} at offset {offset} \
         (a binary file, or text in another encoding: --encoding windows-1252, --encoding utf-16le)",
        path.display()
    )]
    NotText {
        /// The file.
        path: PathBuf,
        /// The line, from 1.
        line: u64,
        /// The offset of the byte, from 0.
        offset: usize,
        /// The byte.
        found: u8,
    },
    /// A file without a header.
    #[error("{}: expected a header row of tags, found an empty file", path.display())]
    Empty {
        /// The file.
        path: PathBuf,
    },
    /// A first row of numbers where the tags should be.
    #[error(
        "{}: line {line}: expected a header row of tags, found the numbers `{found}`",
        path.display()
    )]
    HeaderOfNumbers {
        /// The file.
        path: PathBuf,
        /// The line, from 1.
        line: u64,
        /// The row.
        found: String,
    },
    /// A header and nothing else.
    #[error("{}: expected data rows below the header, found none", path.display())]
    NoRows {
        /// The file.
        path: PathBuf,
    },
    /// Two columns of one name.
    #[error("{}: line {line}: expected every tag once, found `{column}` twice", path.display())]
    DuplicateColumn {
        /// The file.
        path: PathBuf,
        /// The line of the header.
        line: u64,
        /// The tag.
        column: String,
    },
    /// A row with more or fewer fields than the header.
    #[error("{}: line {line}: expected {expected} fields, found {found}", path.display())]
    Ragged {
        /// The file.
        path: PathBuf,
        /// The line, from 1.
        line: u64,
        /// The fields of the header.
        expected: usize,
        /// The fields of the row.
        found: usize,
    },
    /// A cell that is no finite number.
    #[error("{}: {place}, column `{column}`: {problem}", path.display())]
    Cell {
        /// The file.
        path: PathBuf,
        /// The row.
        place: Place,
        /// The tag.
        column: String,
        /// What was expected and what was found.
        problem: CellProblem,
    },

    /// A file that cannot be read as it was asked to be.
    #[error("{}: {cause}", path.display())]
    Reading {
        /// The file.
        path: PathBuf,
        /// What is wrong.
        cause: Box<ReadingError>,
    },
    /// An option of reading that no file could follow.
    #[error("{cause}")]
    Option {
        /// What is wrong.
        cause: Box<ReadingError>,
    },

    /// A name that no column has.
    #[error("{}: expected a column `{column}`, found {}", path.display(), list(available))]
    UnknownColumn {
        /// The file.
        path: PathBuf,
        /// The name asked for.
        column: String,
        /// The columns there are.
        available: Vec<String>,
    },
    /// A pattern that no column matches.
    #[error(
        "{}: expected a column that matches `{pattern}`, found {}",
        path.display(),
        list(available)
    )]
    NoMatch {
        /// The file.
        path: PathBuf,
        /// The pattern.
        pattern: String,
        /// The columns there are.
        available: Vec<String>,
    },
    /// A pattern that cannot be read.
    #[error("expected a pattern like `xmv*` or `y[12]`, found `{pattern}`: {cause}")]
    Pattern {
        /// The pattern.
        pattern: String,
        /// What is wrong with it.
        cause: &'static str,
    },
    /// One tag selected twice on one side.
    #[error("{}: `{column}` is selected twice as {side}; expected once", path.display())]
    SelectedTwice {
        /// The file.
        path: PathBuf,
        /// The tag.
        column: String,
        /// `input` or `output`.
        side: &'static str,
    },
    /// One tag as input and as output.
    #[error(
        "{}: `{column}` is selected as input and as output; expected one of them",
        path.display()
    )]
    InputAndOutput {
        /// The file.
        path: PathBuf,
        /// The tag.
        column: String,
    },
    /// Neither inputs nor outputs selected.
    #[error(
        "{}: expected inputs or outputs to be selected, found neither; there are {}",
        path.display(),
        list(available)
    )]
    NothingSelected {
        /// The file.
        path: PathBuf,
        /// The columns there are.
        available: Vec<String>,
    },
    /// Rows that the file does not have.
    #[error(
        "{}: expected rows A:B with 0 <= A < B <= {total}, found {start}:{end} \
         (0-based, half open)",
        path.display()
    )]
    Rows {
        /// The file.
        path: PathBuf,
        /// The first row asked for.
        start: usize,
        /// One past the last row asked for.
        end: usize,
        /// The rows there are.
        total: usize,
    },

    /// Time stands still or goes backwards.
    #[error(
        "{}: {place}: expected a time after {previous_s} s, found {found_s} s; \
         name another time column, or give the sample time",
        path.display()
    )]
    TimeNotIncreasing {
        /// The file.
        path: PathBuf,
        /// The row.
        place: Place,
        /// The time of the row before, in seconds.
        previous_s: f64,
        /// The time of this row, in seconds.
        found_s: f64,
    },
    /// A step in time that differs from the others.
    #[error(
        "{}: {place}: expected a step of {expected_s} s (within {tolerance} of it), found \
         {found_s} s; select rows without a gap, or give the sample time{}",
        path.display(),
        resample_advice(*place)
    )]
    TimeNotUniform {
        /// The file.
        path: PathBuf,
        /// The row after the step.
        place: Place,
        /// The median step, in seconds.
        expected_s: f64,
        /// This step, in seconds.
        found_s: f64,
        /// The relative tolerance.
        tolerance: f64,
    },
    /// Too few rows to tell the sample time.
    #[error(
        "{}: expected 2 rows or more to tell the sample time, found {found}; give it",
        path.display()
    )]
    TooFewTimes {
        /// The file.
        path: PathBuf,
        /// The rows there are.
        found: usize,
    },
    /// A sample time that is not positive and finite.
    #[error("expected a positive, finite sample time in seconds, found {found}")]
    SampleTime {
        /// The value.
        found: f64,
    },
    /// A time column for a log, whose messages carry their time.
    #[error(
        "{}: an MCAP log carries its own time; expected no time column, found `{column}`",
        path.display()
    )]
    TimeColumnOfLog {
        /// The file.
        path: PathBuf,
        /// The column asked for.
        column: String,
    },
    /// The record could not be made.
    #[error("{}: {cause}", path.display())]
    Data {
        /// The file.
        path: PathBuf,
        /// What is wrong.
        cause: DataError,
    },

    /// A file that does not begin like an MCAP file.
    #[error("{}: expected an MCAP file, found other first bytes ({found:02x?})", path.display())]
    Magic {
        /// The file.
        path: PathBuf,
        /// The first bytes, 8 at most.
        found: Vec<u8>,
    },
    /// An MCAP file that stops before its end.
    #[error(
        "{}: the log is cut off: expected its closing records, found the end of the file after \
         {size} bytes",
        path.display()
    )]
    Truncated {
        /// The file.
        path: PathBuf,
        /// The bytes there are.
        size: u64,
    },
    /// An MCAP file that breaks the format.
    #[error("{}: expected a sound MCAP file, found: {cause}", path.display())]
    Corrupt {
        /// The file.
        path: PathBuf,
        /// What the reader found.
        cause: mcap::McapError,
    },
    /// A log of a later version, whose content this one would misread.
    #[error(
        "{}: expected a log of version {expected} or before, found version {found}: read it with \
         the gtfdi that wrote it, or a later one",
        path.display()
    )]
    NewerLog {
        /// The file.
        path: PathBuf,
        /// The latest version that is known.
        expected: u64,
        /// What the log says.
        found: String,
    },
    /// A topic that the log does not have.
    #[error("{}: expected a topic `{topic}`, found {}", path.display(), list(available))]
    UnknownTopic {
        /// The file.
        path: PathBuf,
        /// The topic asked for.
        topic: String,
        /// The topics there are.
        available: Vec<String>,
    },
    /// A topic of another encoding.
    #[error("{}: topic `{topic}`: expected {expected}, found `{found}`", path.display())]
    Encoding {
        /// The file.
        path: PathBuf,
        /// The topic.
        topic: String,
        /// What was expected.
        expected: &'static str,
        /// The encoding and schema found.
        found: String,
    },
    /// A schema that cannot be read.
    #[error(
        "{}: topic `{topic}`: expected the descriptor of `{message}`, found: {cause}",
        path.display()
    )]
    Descriptor {
        /// The file.
        path: PathBuf,
        /// The topic.
        topic: String,
        /// The message.
        message: String,
        /// What is wrong.
        cause: String,
    },
    /// A topic without messages.
    #[error("{}: topic `{topic}`: expected messages, found none", path.display())]
    NoMessages {
        /// The file.
        path: PathBuf,
        /// The topic.
        topic: String,
    },
    /// A message without a field that was selected.
    #[error(
        "{}: topic `{topic}`, {time_s} s: expected a value of `{column}`, found none",
        path.display()
    )]
    MissingField {
        /// The file.
        path: PathBuf,
        /// The topic.
        topic: String,
        /// The tag.
        column: String,
        /// Seconds since the topic's first message.
        time_s: f64,
    },
    /// A message that cannot be decoded.
    #[error(
        "{}: topic `{topic}`, {time_s} s: expected a message of its schema, found: {cause}",
        path.display()
    )]
    Message {
        /// The file.
        path: PathBuf,
        /// The topic.
        topic: String,
        /// Seconds since the topic's first message.
        time_s: f64,
        /// What is wrong.
        cause: String,
    },
    /// An attachment that the log does not have.
    #[error("{}: expected an attachment `{name}`, found {}", path.display(), list(available))]
    UnknownAttachment {
        /// The file.
        path: PathBuf,
        /// The name asked for.
        name: String,
        /// The attachments there are.
        available: Vec<String>,
    },

    /// JSON that cannot be read.
    #[error("{}: {}{cause}", path.display(), json_place(*line, *column))]
    Json {
        /// The file.
        path: PathBuf,
        /// The line, from 1; 0 where the whole document does not fit.
        line: usize,
        /// The column, from 1.
        column: usize,
        /// What was expected and found.
        cause: String,
    },
    /// A value that cannot be written as JSON.
    #[error("{}: expected a value that JSON can hold, found: {cause}", path.display())]
    NotJson {
        /// The file.
        path: PathBuf,
        /// What is wrong.
        cause: String,
    },

    /// A record that does not fit the detector whose verdicts are written.
    #[error("{}: could not write the verdicts: {cause}", path.display())]
    Unfit {
        /// The file.
        path: PathBuf,
        /// What does not fit.
        cause: String,
    },

    /// The log could not be written.
    #[error("{}: could not write the log: {cause}", path.display())]
    Write {
        /// The file.
        path: PathBuf,
        /// What the writer said.
        cause: mcap::McapError,
    },
    /// A topic added twice.
    #[error("expected every topic once, found `{topic}` twice")]
    DuplicateTopic {
        /// The topic.
        topic: String,
    },
    /// A topic of another writer.
    #[error("expected one of the {expected} topics of this log, found the number {found}")]
    ForeignTopic {
        /// The topics of this log.
        expected: usize,
        /// The number found.
        found: usize,
    },
    /// A message name that Protobuf does not allow.
    #[error("expected a message name of letters, digits and _, found `{found}`")]
    MessageName {
        /// The name.
        found: String,
    },
    /// A tag used twice in a topic.
    #[error("topic `{topic}`: expected every tag once, found `{field}` twice")]
    DuplicateField {
        /// The topic.
        topic: String,
        /// The tag.
        field: String,
    },
    /// A message with a wrong number of values.
    #[error("topic `{topic}`: expected {expected} values, found {found}")]
    FieldCount {
        /// The topic.
        topic: String,
        /// The fields of the topic.
        expected: usize,
        /// The values given.
        found: usize,
    },

    /// A topic whose messages have no number.
    #[error(
        "{}: topic `{topic}`: expected messages with numbers, found none; `gtfdi log info` lists \
         the fields of every topic",
        path.display()
    )]
    NoNumber {
        /// The file.
        path: PathBuf,
        /// The topic.
        topic: String,
    },
    /// There is no room left.
    #[error(
        "{}: the disk is full: could not {action}; make room, files that are whole stay whole",
        path.display()
    )]
    NoSpace {
        /// The file.
        path: PathBuf,
        /// What was tried.
        action: &'static str,
    },
    /// An option of a rotating log.
    #[error("rotation: {option}: expected {expected}, found {found}")]
    Rotation {
        /// The option.
        option: &'static str,
        /// What was expected.
        expected: String,
        /// What was found.
        found: String,
    },
    /// A table of another type, by its extension.
    #[error("{}: expected a file to write that ends in .csv or .parquet", path.display())]
    ExportExtension {
        /// The file.
        path: PathBuf,
    },
    /// A time that a table cannot hold.
    #[error(
        "{}: {place}: expected a time that the table can hold, found {found_ns} ns since 1970; \
         select other rows, or write CSV with the time in seconds",
        path.display()
    )]
    TimeOutOfRange {
        /// The file.
        path: PathBuf,
        /// The row.
        place: Place,
        /// The time.
        found_ns: u64,
    },
    /// A log that is to be mended onto itself.
    #[error(
        "{}: expected another file to write than the one that is read; give another name",
        path.display()
    )]
    SameFile {
        /// The file.
        path: PathBuf,
    },
    /// A file in which no record of an MCAP file is found.
    #[error(
        "{}: expected the records of an MCAP file, found none in {size} bytes",
        path.display()
    )]
    NothingToRecover {
        /// The file.
        path: PathBuf,
        /// Its bytes.
        size: u64,
    },
}

impl LogError {
    pub(crate) fn reading(path: &Path, cause: ReadingError) -> Self {
        Self::Reading {
            path: path.to_owned(),
            cause: Box::new(cause),
        }
    }

    pub(crate) fn option(cause: ReadingError) -> Self {
        let cause = Box::new(cause);
        Self::Option { cause }
    }

    pub(crate) fn io(path: &Path, action: &'static str, cause: io::Error) -> Self {
        let path = path.to_owned();
        match cause.kind() {
            io::ErrorKind::NotFound if action == "open" => Self::NotFound { path },
            io::ErrorKind::IsADirectory => Self::Directory { path },
            _ if is_full(&cause) => Self::NoSpace { path, action },
            _ => Self::Io {
                path,
                action,
                cause,
            },
        }
    }
}

/// Whether there is no room left.
pub(crate) fn is_full(cause: &io::Error) -> bool {
    matches!(
        cause.kind(),
        io::ErrorKind::StorageFull | io::ErrorKind::QuotaExceeded
    )
}

/// What is wrong with a cell.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum CellProblem {
    /// Nothing in it.
    Empty,
    /// Something else than a number.
    Text(String),
    /// NaN or infinity.
    NotFinite(String),
    /// A word for a missing value, where none may be missing.
    Bad(String),
    /// A number whose digits are grouped.
    Thousands(String),
    /// A decimal comma where the file has decimal points.
    Comma(String),
    /// Something else than a time.
    Time(String),
    /// Something else than a time of the file's form.
    TimeFormat {
        /// The cell.
        found: String,
        /// The form, in words.
        expected: String,
    },
    /// Nothing that names a tag.
    NoTag(String),
    /// Something else than a quality.
    Quality(String),
    /// A bad reading, where none may be missing.
    BadQuality(String),
    /// A local time that clocks pass over.
    NoSuchTime {
        /// The time.
        found: String,
        /// The time zone.
        zone: String,
    },
}

impl CellProblem {
    /// Whether it is a sample that is missing, which may be.
    pub fn is_missing(&self) -> bool {
        match self {
            Self::Empty | Self::Bad(_) => true,
            Self::NotFinite(cell) => cell.parse::<f64>().is_ok_and(f64::is_nan),
            _ => false,
        }
    }
}

impl fmt::Display for CellProblem {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Empty => f.write_str("expected a finite number, found an empty cell"),
            Self::Text(found) | Self::NotFinite(found) => {
                write!(f, "expected a finite number, found `{found}`")
            }
            Self::Bad(found) => {
                write!(
                    f,
                    "expected a finite number, found `{found}`, a word for none"
                )
            }
            Self::Thousands(found) => write!(
                f,
                "expected a number without separators of thousands, found `{found}`; export it \
                 without them"
            ),
            Self::Comma(found) => write!(
                f,
                "expected a number with a decimal point, found `{found}`; if the comma is the \
                 decimal sign, give --decimal comma"
            ),
            Self::Time(found) => {
                write!(
                    f,
                    "expected seconds or an ISO 8601 time, all alike, found `{found}`; another \
                     form is read with --time-format"
                )
            }
            Self::TimeFormat { found, expected } => {
                write!(f, "expected {expected}, found `{found}`")
            }
            Self::NoTag(found) => write!(f, "expected a tag, found {found}"),
            Self::Quality(found) => write!(
                f,
                "expected Good, Uncertain, Bad or an OPC quality (192 and above good, 64 to 127 \
                 uncertain, below 64 bad), found `{found}`"
            ),
            Self::BadQuality(found) => {
                write!(
                    f,
                    "expected a reading that is not bad, found the quality `{found}`"
                )
            }
            Self::NoSuchTime { found, zone } => write!(
                f,
                "expected a time that {zone} has, found {found}, which is passed over when clocks \
                 are put forward; give the zone the times were written in (--time-zone)"
            ),
        }
    }
}

/// Where in a file a row stands.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Place {
    /// A line of text, from 1.
    Line(u64),
    /// A message of the topic in the order of time, from 0.
    Message(usize),
    /// A row of a table, from 0.
    Row(usize),
}

impl fmt::Display for Place {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Line(line) => write!(f, "line {line}"),
            Self::Message(index) => write!(f, "message {index}"),
            Self::Row(index) => write!(f, "row {index}"),
        }
    }
}

/// Names for a message: all of them up to a point, then how many more.
fn list(names: &[String]) -> String {
    const SHOWN: usize = 60;
    if names.is_empty() {
        return "none".to_owned();
    }
    let shown = names
        .iter()
        .take(SHOWN)
        .map(String::as_str)
        .collect::<Vec<_>>()
        .join(", ");
    match names.len().checked_sub(SHOWN) {
        Some(more) if more > 0 => format!("{shown} and {more} more"),
        _ => shown,
    }
}

/// What else there is for the times of a table.
fn resample_advice(place: Place) -> &'static str {
    match place {
        Place::Message(_) => "",
        Place::Line(_) | Place::Row(_) => "; --resample makes samples of one period",
    }
}

/// Where a JSON document does not fit, ready to stand before the cause.
fn json_place(line: usize, column: usize) -> String {
    if line == 0 {
        String::new()
    } else {
        format!("line {line}, column {column}: ")
    }
}
