//! Files into datasets.

mod csv;
mod error;
mod gather;
mod grid;
mod imported;
mod instant;
mod long;
mod number;
mod parquet;
mod parquet_column;
mod parquet_form;
mod quiet;
mod reading;
mod resample;
mod rows;
mod select;
mod sheet;
mod tabular;
mod tags;
mod text;
mod tracks;
mod units;
mod warning;
mod wide;

use std::ops::Range;
use std::path::Path;

use gt_core::Signal;
use gtfdi::ident::Missing;

use crate::{LogError, reader, sha256_hex, source};

pub(crate) use csv::CsvSheet;
pub(crate) use instant::TimeReader;
pub(crate) use long::{Quality, Roles};
pub(crate) use number::{Numerals, Sample};
pub(crate) use parquet::ParquetSheet;
pub(crate) use select::chosen_tags;
pub(crate) use sheet::{Cell, Sheet};
pub(crate) use tabular::{conversions, time_reader};
pub(crate) use tags::Conversion;
pub(crate) use text::decode;
pub(crate) use tracks::Tracks;
pub(crate) use wide::{cell_error, check_count, time_column};

pub use error::ReadingError;
pub use imported::{Imported, TimeGap};
pub use reading::{Decimal, Layout, Reading};
pub use resample::{Resample, ResampleMethod, Resampled, ResampledTag};
pub(crate) use select::Columns;
pub use tags::TagMap;
pub use warning::Warning;

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
/// | `reading` | recognised | how the cells of a file are written, see [`Reading`] |
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
    /// With [`Missing::Break`] an empty cell of a CSV file, one that is NaN or one that holds a word
    /// for a missing value (`Bad`, `No Data`), or a field that a message of a log leaves out, is a
    /// sample that is NaN, and a longer step in time is a break of the record (see
    /// [`Imported::pieces`]).
    pub missing: Missing,
    /// How the cells of a CSV file are to be understood.
    pub reading: Reading,
}

impl Selection {
    /// Refuses what no file could follow.
    pub(crate) fn check(&self) -> Result<(), LogError> {
        self.reading.check().map_err(LogError::option)?;
        if self.reading.resample.is_some() && self.sample_time_s.is_some() {
            return Err(LogError::option(ReadingError::TwoSampleTimes));
        }
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

/// The file types that can be read.
enum Format {
    Csv,
    Mcap,
    Parquet,
}

impl Format {
    fn of(path: &Path) -> Result<Self, LogError> {
        let extension = path
            .extension()
            .map(|text| text.to_string_lossy().to_ascii_lowercase());
        match extension.as_deref() {
            Some("csv") => Ok(Self::Csv),
            Some("mcap") => Ok(Self::Mcap),
            Some("parquet") => Ok(Self::Parquet),
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

/// Reads a `.csv`, `.parquet` or `.mcap` file into a dataset.
///
/// **CSV**: a header row of tags, then rows of cells; commas, or where the header has none,
/// semicolons or tabs. Only the selected columns and the time column are read as numbers. The time
/// column holds seconds or ISO 8601 times (without an offset they are taken as UTC), strictly
/// increasing and uniform within [`UNIFORM_TOLERANCE`](crate::UNIFORM_TOLERANCE), but for gaps where
/// [`Selection::missing`] allows them. A column that is
/// selected as a signal is not taken for the time by its name alone.
///
/// **Parquet**: the same, wide or long, from columns of numbers, texts (words for missing values),
/// booleans and times; nulls are missing.
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
        Format::Csv => read_csv(path, selection),
        Format::Mcap => {
            let refused = |cause| LogError::reading(path, cause);
            selection.reading.check_log().map_err(refused)?;
            reader::read_dataset(path, selection)
        }
        Format::Parquet => read_parquet(path, selection),
    }
}

/// The columns of a CSV file, or the numeric fields of a topic of an MCAP log ([`DEFAULT_TOPIC`] where
/// none is named) with their units. Those of arrays and of JSON are looked for in all messages.
///
/// # Errors
/// As [`read_dataset`].
pub fn columns(path: &Path, topic: Option<&str>) -> Result<Vec<Signal>, LogError> {
    match Format::of(path)? {
        Format::Csv => csv_columns(path, &Reading::default()),
        Format::Mcap => reader::columns(path, topic.unwrap_or(DEFAULT_TOPIC)),
        Format::Parquet => {
            let sheet = ParquetSheet::open(path, source::read(path)?)?;
            Ok(sheet.header().to_vec())
        }
    }
}

fn read_csv(path: &Path, selection: &Selection) -> Result<Imported, LogError> {
    let bytes = source::read(path)?;
    let reading = &selection.reading;
    let encoding = reading.encoding().map_err(LogError::option)?;
    let text = text::decode(path, &bytes, encoding)?;
    let mut sheet = CsvSheet::open(path, &text.bytes, reading)?;
    let numerals = Numerals::new(sheet.dialect.decimal, reading);
    let warnings = sheet.dialect.warnings.clone();
    let mut imported = tabular::read(path, &mut sheet, &numerals, selection, sha256_hex(&bytes))?;
    imported.warnings.splice(0..0, warnings);
    Ok(imported)
}

fn read_parquet(path: &Path, selection: &Selection) -> Result<Imported, LogError> {
    let reading = &selection.reading;
    let refused = |cause| LogError::reading(path, cause);
    reading.check_parquet().map_err(refused)?;
    let bytes = source::read(path)?;
    let sha256 = sha256_hex(&bytes);
    let mut sheet = ParquetSheet::open(path, bytes)?;
    let numerals = Numerals::new(Decimal::Point, reading);
    tabular::read(path, &mut sheet, &numerals, selection, sha256)
}

/// The tags of a CSV file's header.
fn csv_columns(path: &Path, reading: &Reading) -> Result<Vec<Signal>, LogError> {
    let bytes = source::read(path)?;
    let text = text::decode(path, &bytes, None)?;
    let sheet = CsvSheet::open(path, &text.bytes, reading)?;
    let mut header = sheet.header().to_vec();
    header.retain(|signal| !signal.name.is_empty());
    Ok(header)
}
