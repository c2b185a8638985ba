//! What is wrong with a file, and what mends it.

use serde::Serialize;

use crate::error::CellProblem;
use crate::{LogError, Place, ReadingError};

/// Something that identification would refuse.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Damage {
    /// What kind of thing.
    pub kind: DamageKind,
    /// The line of a text, from 1.
    pub line: Option<u64>,
    /// The row of a table, from 0.
    pub row: Option<usize>,
    /// The tag or column.
    pub tag: Option<String>,
    /// What was expected and what was found, with the file's name and the place.
    pub text: String,
    /// The option that mends it; none where only the file can.
    pub mended_by: Option<&'static str>,
}

/// Kinds of damages.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum DamageKind {
    /// The file cannot be read as it is.
    File,
    /// A row with more or fewer fields than the header.
    Row,
    /// A cell with nothing in it, or with a word for that.
    Missing,
    /// A cell that is no finite number.
    Number,
    /// A time that is none, or none that the zone has.
    Time,
    /// A time that repeats the one before.
    Duplicate,
    /// A time before the one before.
    Backward,
    /// A step in time longer than the others.
    Gap,
    /// A step in time shorter than the others.
    Step,
    /// A reading of bad quality, or a quality that is none.
    Quality,
    /// A row of a reading without a tag.
    Tag,
}

impl Damage {
    /// The damage that keeps a file from being read.
    pub(super) fn of_file(error: &LogError) -> Self {
        let mended_by = match error {
            LogError::NotText { .. } => Some("--encoding"),
            LogError::UnknownTopic { .. } | LogError::NoNumber { .. } => Some("--topic"),
            LogError::Reading { cause, .. } => match &**cause {
                ReadingError::Undecodable { .. } => Some("--encoding"),
                ReadingError::Preamble { .. } => Some("--header-line"),
                ReadingError::DayOrMonth { .. } => Some("--time-format"),
                ReadingError::OwnTimes { .. } => Some("--resample"),
                _ => None,
            },
            _ => None,
        };
        let line = match error {
            LogError::NotText { line, .. }
            | LogError::HeaderOfNumbers { line, .. }
            | LogError::DuplicateColumn { line, .. } => Some(*line),
            LogError::Reading { cause, .. } => match **cause {
                ReadingError::Preamble { line, .. } | ReadingError::Undecodable { line, .. } => {
                    Some(line)
                }
                _ => None,
            },
            _ => None,
        };
        Self {
            kind: DamageKind::File,
            line,
            row: None,
            tag: None,
            text: error.to_string(),
            mended_by,
        }
    }

    /// A damage at a place.
    pub(super) fn at(
        kind: DamageKind,
        place: Place,
        tag: Option<&str>,
        error: &LogError,
        mended_by: Option<&'static str>,
    ) -> Self {
        let (line, row) = match place {
            Place::Line(line) => (Some(line), None),
            Place::Row(row) | Place::Message(row) => (None, Some(row)),
        };
        Self {
            kind,
            line,
            row,
            tag: tag.map(str::to_owned),
            text: error.to_string(),
            mended_by,
        }
    }

    /// A damage of a cell.
    pub(super) fn of_cell(place: Place, error: &LogError) -> Self {
        let LogError::Cell {
            column, problem, ..
        } = error
        else {
            return Self::at(DamageKind::Row, place, None, error, None);
        };
        let (kind, mended_by) = match problem {
            found if found.is_missing() => (DamageKind::Missing, Some("--missing")),
            CellProblem::BadQuality(_) => (DamageKind::Quality, Some("--missing")),
            CellProblem::Quality(_) => (DamageKind::Quality, None),
            CellProblem::Text(_) => (DamageKind::Number, Some("--bad-values")),
            CellProblem::Comma(_) => (DamageKind::Number, Some("--decimal")),
            CellProblem::Empty
            | CellProblem::Bad(_)
            | CellProblem::NotFinite(_)
            | CellProblem::Thousands(_) => (DamageKind::Number, None),
            CellProblem::Time(_) | CellProblem::TimeFormat { .. } => {
                (DamageKind::Time, Some("--time-format"))
            }
            CellProblem::NoSuchTime { .. } => (DamageKind::Time, Some("--time-zone")),
            CellProblem::NoTag(_) => (DamageKind::Tag, None),
        };
        Self::at(kind, place, Some(column), error, mended_by)
    }
}
