//! Files into datasets.

mod csv;
mod error;
mod gather;
mod grid;
mod instant;
mod long;
mod number;
mod parquet;
mod parquet_column;
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
mod wide;

use std::fmt;
use std::ops::Range;
use std::path::Path;

use gt_core::{DataError, Dataset, Signal};
use gtfdi::ident::Missing;
use nalgebra::DMatrix;

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
pub use reading::{Decimal, Layout, Reading};
pub use resample::{Resample, ResampleMethod, Resampled, ResampledTag};
pub(crate) use select::Columns;
pub use tags::TagMap;

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
    /// for a missing value (`Bad`, `No Data`) is a sample that is NaN, and a longer step in time is a
    /// break of the record (see [`Imported::pieces`]).
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
    /// What resampling made of the file, where it was asked for.
    pub resampled: Option<Resampled>,
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
    /// All that the user should know, a line each: the warnings and what resampling did.
    pub fn remarks(&self) -> Vec<String> {
        let warnings = self.warnings.iter().map(ToString::to_string);
        let tags = self.resampled.iter().flat_map(|done| &done.tags);
        warnings
            .chain(tags.map(|tag| format!("resampled {}", tag.text())))
            .collect()
    }

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

impl Imported {
    /// The record without gaps: the samples that are not there are missing ones (NaN).
    ///
    /// # Errors
    /// [`ReadingError::OddGap`] for a gap that is no whole number of sample times,
    /// [`ReadingError::LongGap`] for more samples than anyone wants.
    pub fn filled(mut self, path: &Path) -> Result<Self, LogError> {
        const MOST_SAMPLES: f64 = 5e7;
        const WHOLE: f64 = 0.05;
        if self.gaps.is_empty() {
            return Ok(self);
        }
        let data = &self.dataset;
        let period_s = data.sample_time_s();
        let mut absent = vec![0; data.len()];
        let (mut sample, mut since_first_s) = (0, 0.0);
        let mut total = data.len() as f64;
        for gap in &self.gaps {
            let before_s = since_first_s + (gap.sample - 1 - sample) as f64 * period_s;
            let steps = (gap.since_first_s - before_s) / period_s;
            let cause = |found| match found {
                None => ReadingError::LongGap {
                    seconds: gap.since_first_s - before_s,
                    most: MOST_SAMPLES,
                },
                Some(steps) => ReadingError::OddGap {
                    sample: gap.sample,
                    steps,
                    period_s,
                },
            };
            if (steps - steps.round()).abs() > WHOLE {
                return Err(LogError::reading(path, cause(Some(steps))));
            }
            total += steps.round() - 1.0;
            if total > MOST_SAMPLES {
                return Err(LogError::reading(path, cause(None)));
            }
            absent[gap.sample] = whole(steps) - 1;
            (sample, since_first_s) = (gap.sample, gap.since_first_s);
        }
        let spread = |from: &DMatrix<f64>| {
            let mut values = Vec::with_capacity(from.nrows() * from.ncols());
            for (column, &absent) in from.column_iter().zip(&absent) {
                values.extend(std::iter::repeat_n(f64::NAN, absent * from.nrows()));
                values.extend(column.iter());
            }
            let len = data.len() + absent.iter().sum::<usize>();
            DMatrix::from_vec(from.nrows(), len, values)
        };
        let (u, y) = (spread(data.u()), spread(data.y()));
        let (inputs, outputs) = (data.inputs().to_vec(), data.outputs().to_vec());
        let start_time_s = data.start_time_s();
        let filled = Dataset::new(inputs, outputs, u, y, period_s);
        let filled = filled.map_err(|cause| LogError::Data {
            path: path.to_owned(),
            cause,
        })?;
        self.dataset = filled.starting_at(start_time_s);
        self.gaps.clear();
        Ok(self)
    }
}

/// A number of steps, which is checked to be one.
#[expect(
    clippy::cast_possible_truncation,
    clippy::cast_sign_loss,
    reason = "a cast saturates"
)]
fn whole(steps: f64) -> usize {
    steps.round().max(1.0) as usize
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
    /// A word for a missing value.
    BadWord {
        /// The tag.
        column: String,
        /// The word, as it stands.
        word: String,
        /// How many there are.
        count: usize,
    },
    /// A comma was taken for the decimal sign.
    DecimalComma,
    /// A row below the header was taken for the units.
    UnitRow {
        /// Its line, from 1.
        line: u64,
    },
    /// Numbers were taken for times since 1970.
    EpochTimes {
        /// The time column.
        column: String,
        /// `seconds`, `milliseconds` and so on.
        unit: &'static str,
    },
    /// A format of the times was found out.
    TimesRead {
        /// The time column.
        column: String,
        /// The format.
        format: String,
    },
    /// Readings of uncertain quality, which are kept.
    Uncertain {
        /// The tag.
        column: String,
        /// How many there are.
        count: usize,
    },
    /// Readings outside their range, which are missing.
    OutOfRange {
        /// The tag.
        column: String,
        /// How many there are.
        count: usize,
    },
    /// Times that the time zone has twice were told apart by their order.
    Folded {
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
            Self::BadWord {
                column,
                word,
                count,
            } => write!(f, "`{column}`: {count} times `{word}`, read as missing"),
            Self::DecimalComma => {
                f.write_str("the comma is taken for the decimal sign; --decimal says otherwise")
            }
            Self::UnitRow { line } => write!(f, "line {line} is taken for the units"),
            Self::EpochTimes { column, unit } => write!(
                f,
                "the numbers of `{column}` are taken for {unit} since 1970; --sample-time does \
                 without them"
            ),
            Self::TimesRead { column, format } => write!(
                f,
                "the times of `{column}` are read as `{format}`; --time-format says otherwise"
            ),
            Self::Uncertain { column, count } => {
                write!(f, "`{column}`: {count} readings of uncertain quality, kept")
            }
            Self::OutOfRange { column, count } => write!(
                f,
                "`{column}`: {count} readings outside the range of the tags' file, read as missing"
            ),
            Self::Folded { count } => write!(
                f,
                "{count} times of the hour that comes twice when clocks are put back are told \
                 apart by their order"
            ),
        }
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
/// **MCAP**: the messages of one Protobuf topic in the order of their publish times (of their log
/// times where the writer left those at zero). NaN stays NaN; a selected field that is absent is an
/// error.
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

/// The columns of a CSV file, or the `double` fields of a topic of an MCAP log ([`DEFAULT_TOPIC`]
/// where none is named) with their units.
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
