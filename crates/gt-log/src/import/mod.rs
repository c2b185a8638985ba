//! Files into datasets.

mod csv;
mod select;

use std::fmt;
use std::ops::Range;
use std::path::Path;

use gt_core::{DataError, Dataset, Signal};
use gtfdi::ident::Missing;

use crate::{LogError, reader};

pub(crate) use select::Columns;

/// The topic that is read where none is named.
pub const DEFAULT_TOPIC: &str = "/plant/measured";

/// What to take from a file.
///
/// | name | default | purpose |
/// |---|---|---|
/// | `inputs`, `outputs` | none | tags, or patterns such as `xmv*`, `y[12]`, `?1` |
/// | `time` | a column called `time`, `timestamp` or `t` | the time column of a CSV file |
/// | `sample_time_s` | from the times | overrides the times in the file |
/// | `topic` | [`DEFAULT_TOPIC`] | the topic of an MCAP log |
/// | `rows` | all | data rows `start..end`, 0-based, half open |
/// | `missing` | refuse | what a cell without a number and a gap in time mean |
///
/// A name that is a tag stands for that tag, whatever characters it has. A pattern gives its
/// matches in the order of the file, without the time column and without tags that the same list
/// has already.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Selection {
    /// Tags or patterns of the inputs.
    pub inputs: Vec<String>,
    /// Tags or patterns of the outputs.
    pub outputs: Vec<String>,
    /// The time column (CSV).
    pub time: Option<String>,
    /// The sample time in seconds.
    pub sample_time_s: Option<f64>,
    /// The topic (MCAP).
    pub topic: Option<String>,
    /// The data rows; the others need not be valid.
    pub rows: Option<Range<usize>>,
    /// With [`Missing::Break`] an empty cell of a CSV file, or one that is NaN, or a field that a
    /// message of a log leaves out, is a sample that is NaN, and a longer step in time is a break of the record (see [`Imported::pieces`]).
    pub missing: Missing,
}

impl Selection {
    fn check(&self) -> Result<(), LogError> {
        match self.sample_time_s {
            Some(found) if !(found.is_finite() && found > 0.0) => {
                Err(LogError::SampleTime { found })
            }
            _ => Ok(()),
        }
    }

    /// The rows to take of `total`.
    pub(crate) fn rows_of(&self, path: &Path, total: usize) -> Result<Range<usize>, LogError> {
        let rows = self.rows.clone().unwrap_or(0..total);
        if rows.start >= rows.end || rows.end > total {
            let (path, start, end) = (path.to_owned(), rows.start, rows.end);
            return Err(LogError::Rows {
                path,
                start,
                end,
                total,
            });
        }
        Ok(rows)
    }
}

/// A record from a file.
#[derive(Debug, Clone, PartialEq)]
pub struct Imported {
    /// The record. Its first sample is at the time in the time column, or else at the number of
    /// rows before it times the sample time.
    pub dataset: Dataset,
    /// The SHA-256 of the whole file, in hexadecimal digits.
    pub sha256: String,
    /// What the user should know.
    pub warnings: Vec<Warning>,
    /// The data rows of the file (messages of the topic), selected or not.
    pub total_rows: usize,
    /// The time of the first sample in nanoseconds since 1970, where the file tells it.
    pub start_unix_ns: Option<i128>,
    /// The samples before which time jumps; none unless breaks are allowed.
    pub gaps: Vec<TimeGap>,
}

/// A sample that comes later than a sample time after the one before it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct TimeGap {
    /// The sample, 0-based.
    pub sample: usize,
    /// Its time since the first sample, in seconds.
    pub since_first_s: f64,
}

impl Imported {
    /// The samples of `rows`, a record of its own from each gap in time on, at its own time.
    ///
    /// # Errors
    /// As [`Dataset::rows`].
    pub fn pieces(&self, rows: Range<usize>) -> Result<Vec<Dataset>, DataError> {
        let start = |sample: usize| -> f64 {
            let before = self.gaps.iter().rev().find(|gap| gap.sample <= sample);
            let (first, since_first_s) =
                before.map_or((0, 0.0), |gap| (gap.sample, gap.since_first_s));
            let steps = (sample - first) as f64;
            self.dataset.start_time_s() + since_first_s + steps * self.dataset.sample_time_s()
        };
        let inside = self.gaps.iter().map(|gap| gap.sample);
        let inside = inside.filter(|sample| (rows.start + 1..rows.end).contains(sample));
        let bounds: Vec<usize> = [rows.start]
            .into_iter()
            .chain(inside)
            .chain([rows.end])
            .collect();
        let piece = |ends: &[usize]| {
            let data = self.dataset.rows(ends[0]..ends[1])?;
            Ok(data.starting_at(start(ends[0])))
        };
        bounds.windows(2).map(piece).collect()
    }
}

/// What the user should know of a record that could be read.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Warning {
    /// Neither a time column nor a sample time: the sample time is set to 1.
    TimeInSamples,
    /// Values that are NaN: the sensor gave nothing valid.
    InvalidSamples {
        /// The tag.
        column: String,
        /// How many there are.
        count: usize,
    },
}

impl fmt::Display for Warning {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::TimeInSamples => f.write_str(
                "no column named time, timestamp or t and no sample time given: time is counted \
                 in samples (sample time 1)",
            ),
            Self::InvalidSamples { column, count } => {
                write!(f, "`{column}` has {count} samples that are not valid (NaN)")
            }
        }
    }
}

/// The file types that can be read.
enum Format {
    Csv,
    Mcap,
}

impl Format {
    fn of(path: &Path) -> Result<Self, LogError> {
        let extension = path
            .extension()
            .map(|text| text.to_string_lossy().to_ascii_lowercase());
        match extension.as_deref() {
            Some("csv") => Ok(Self::Csv),
            Some("mcap") => Ok(Self::Mcap),
            Some("parquet") => Err(LogError::Parquet {
                path: path.to_owned(),
            }),
            found => {
                let found = found.map_or("no extension".to_owned(), |found| format!("`.{found}`"));
                Err(LogError::Extension {
                    path: path.to_owned(),
                    found,
                })
            }
        }
    }
}

/// Reads a `.csv` or `.mcap` file into a dataset.
///
/// **CSV**: a header row of tags, then rows of cells; commas, or where the header has none,
/// semicolons or tabs. Only the selected columns and the time column are read as numbers. The time
/// column holds seconds or ISO 8601 times (without an offset they are taken as UTC), strictly
/// increasing and uniform within [`UNIFORM_TOLERANCE`](crate::UNIFORM_TOLERANCE), but for gaps where
/// [`Selection::missing`] allows them. A column that is
/// selected as a signal is not taken for the time by its name alone.
///
/// **MCAP**: the messages of one topic in the order of their publish times (of their log times where
/// the writer left those at zero), whatever the chunks. Protobuf with its descriptor, of this or any
/// other writer, and JSON: numbers, truth values and enumerations, those of nested messages as `a.b`,
/// of arrays as `a[0]`. NaN stays NaN; a selected field that is absent is an error, or with
/// [`Missing::Break`] a sample that is NaN.
///
/// # Errors
/// [`LogError`] names the file, the line or time, the column, what was expected and what was found.
pub fn read_dataset(path: &Path, selection: &Selection) -> Result<Imported, LogError> {
    selection.check()?;
    match Format::of(path)? {
        Format::Csv => csv::read(path, selection),
        Format::Mcap => reader::read_dataset(path, selection),
    }
}

/// The columns of a CSV file, or the numeric fields of a topic of an MCAP log ([`DEFAULT_TOPIC`] where
/// none is named) with their units. Those of arrays and of JSON are looked for in all messages.
///
/// # Errors
/// As [`read_dataset`].
pub fn columns(path: &Path, topic: Option<&str>) -> Result<Vec<Signal>, LogError> {
    match Format::of(path)? {
        Format::Csv => csv::columns(path),
        Format::Mcap => reader::columns(path, topic.unwrap_or(DEFAULT_TOPIC)),
    }
}
