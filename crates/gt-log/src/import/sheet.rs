//! Tables of cells, whatever kind of file they come from.

use std::fmt;

use gt_core::Signal;

use crate::{LogError, Place};

/// A cell as the file has it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) enum Cell<'a> {
    /// Text, without blanks around it.
    Text(&'a str),
    /// A number.
    Number(f64),
    /// Nanoseconds since 1970.
    Instant(i128),
    /// Nanoseconds from 1970 to a local time, as if it were UTC.
    Local(i128),
    /// Nothing.
    Nothing,
}

impl fmt::Display for Cell<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Text(text) => f.write_str(text),
            Self::Number(number) => write!(f, "{number}"),
            Self::Instant(ns) | Self::Local(ns) => write!(f, "a time ({ns} ns since 1970)"),
            Self::Nothing => f.write_str("nothing"),
        }
    }
}

/// A table that is read row by row.
pub(crate) trait Sheet {
    /// The tags; an unnamed column has an empty one.
    fn header(&self) -> &[Signal];

    /// Makes the cells of some columns ready; those of others may be empty.
    fn load(&mut self, columns: &[usize]) -> Result<(), LogError> {
        let _ = columns;
        Ok(())
    }

    /// Goes back to before the first data row.
    fn rewind(&mut self) -> Result<(), LogError>;

    /// Goes to the next data row; false after the last one.
    fn advance(&mut self) -> Result<bool, LogError>;

    /// Where the row stands.
    fn place(&self) -> Place;

    /// The fields of the row.
    fn fields(&self) -> usize;

    /// A cell of the row; empty text beyond its fields.
    fn cell(&self, column: usize) -> Cell<'_>;
}
