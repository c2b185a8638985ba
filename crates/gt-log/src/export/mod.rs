//! Topics of logs into tables.

mod columns;
mod csv;
mod parquet;

use std::ops::Range;
use std::path::Path;

use serde::Serialize;

use crate::LogError;
use columns::{Column, Sheet};

/// What to export of a log.
///
/// | name | default | purpose |
/// |---|---|---|
/// | `topic` | [`DEFAULT_TOPIC`](crate::DEFAULT_TOPIC) | the topic |
/// | `tags` | all | columns, or patterns such as `t*`; of JSON numbers within objects too, as `a.b` |
/// | `rows` | all | rows in the order of time `start..end`, 0-based, half open |
/// | `time` | ISO 8601 | how a CSV file has the time |
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct ExportOptions {
    /// The topic.
    pub topic: Option<String>,
    /// Tags or patterns of the columns; none means all.
    pub tags: Vec<String>,
    /// The rows, which must be there.
    pub rows: Option<Range<usize>>,
    /// How a CSV file has the time.
    pub time: ExportTime,
}

/// How a CSV file has the time.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub enum ExportTime {
    /// ISO 8601 in UTC with nine decimals: `2006-01-18T00:00:00.080000000Z`.
    #[default]
    Iso,
    /// Seconds since the topic's first message, with nine decimals: `0.080000000`.
    Seconds,
}

/// What was exported.
#[derive(Debug, Clone, PartialEq, Eq, Serialize)]
pub struct Exported {
    /// The topic.
    pub topic: String,
    /// The name of the column of the time.
    pub time: String,
    /// The other columns.
    pub columns: Vec<ExportedColumn>,
    /// The rows.
    pub rows: usize,
}

/// A column that was exported.
#[derive(Debug, Clone, PartialEq, Eq, Serialize)]
pub struct ExportedColumn {
    /// Its name.
    pub name: String,
    /// Its unit; empty where the log tells none.
    pub unit: String,
    /// What it holds: `number`, `integer`, `truth` or `text`.
    pub kind: &'static str,
    /// How many of its rows have no value.
    pub absent: usize,
}

/// Writes the messages of a topic to a table, in the order of their publish times (of their log times
/// where the writer left those at zero): `out` ends in `.csv` or `.parquet`.
///
/// The first column is the time, called `time` or, where a field has that name, `timestamp` or
/// `log_time`. Of Protobuf each number, truth value or enumeration is a column, as in
/// [`columns`](crate::columns); of JSON each key of the messages is one, and what lies deeper is its
/// JSON text.
///
/// **CSV**: an absent value is an empty cell, an invalid one `NaN`; numbers have as many digits as
/// bring the same bits back (a NaN other than the usual one comes back as the usual one). An empty
/// text and none look alike.
/// **Parquet**: an absent value is null, an invalid one NaN, to the bit. Time is a timestamp in
/// nanoseconds, UTC.
///
/// The whole topic is held in memory. The file appears when it is whole.
///
/// # Errors
/// [`LogError::ExportExtension`] for another file; [`LogError::UnknownTopic`],
/// [`LogError::NoMessages`], [`LogError::Rows`], [`LogError::Message`] and those of a selection; a
/// log that is broken; a file that cannot be written.
pub fn export(path: &Path, out: &Path, options: &ExportOptions) -> Result<Exported, LogError> {
    let extension = out
        .extension()
        .map(|text| text.to_string_lossy().to_ascii_lowercase());
    let write = match extension.as_deref() {
        Some("csv") => csv::write,
        Some("parquet") => parquet::write,
        _ => {
            return Err(LogError::ExportExtension {
                path: out.to_owned(),
            });
        }
    };
    let table = Sheet::read(path, options)?;
    write(out, &table, options.time)?;
    let column = |own: &Column| ExportedColumn {
        name: own.signal.name.clone(),
        unit: own.signal.unit.clone(),
        kind: own.cells.kind(),
        absent: own.cells.absent(),
    };
    Ok(Exported {
        topic: table.topic,
        time: table.time,
        columns: table.columns.iter().map(column).collect(),
        rows: table.times_ns.len(),
    })
}
