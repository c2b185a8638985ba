//! How the cells of a file are to be understood.

use encoding_rs::Encoding;
use jiff::tz::{TimeZone, TimeZoneDatabase};

use super::{ReadingError, Resample, TagMap};

/// What a file does not say of itself. The errors name these options as the command line does.
///
/// | name | default | purpose |
/// |---|---|---|
/// | `encoding` | UTF-8, or by a byte-order mark | a label of the Encoding standard: `windows-1252` |
/// | `decimal` | recognised | the decimal sign of a CSV file |
/// | `header_line` | 1 | the line of a CSV file's header, from 1 |
/// | `bad_values` | none | further words for a missing value |
/// | `time_zone` | UTC | the zone of times without an offset: `Europe/Rome` |
/// | `time_format` | recognised | how times are written: `%d/%m/%Y %H:%M:%S`, or `excel` for its days |
/// | `layout` | recognised | a column for each tag, or a row for each reading |
/// | `resample` | none | how readings at any times become samples of one period |
/// | `tags` | none | names, units and ranges of the tags |
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Reading {
    /// The encoding of a CSV file.
    pub encoding: Option<String>,
    /// The decimal sign of a CSV file.
    pub decimal: Option<Decimal>,
    /// The line of a CSV file's header, from 1; what stands before it is passed over.
    pub header_line: Option<u64>,
    /// Words for a missing value, beside those that are known; their case does not matter.
    pub bad_values: Vec<String>,
    /// The time zone of times that have no offset.
    pub time_zone: Option<String>,
    /// The format of the times, in the letters of strptime.
    pub time_format: Option<String>,
    /// What the rows are.
    pub layout: Option<Layout>,
    /// How readings become samples of one period.
    pub resample: Option<Resample>,
    /// Names, units and ranges of the tags. What is selected is named by it.
    pub tags: Option<TagMap>,
}

/// What the rows of a table are.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Layout {
    /// A row for each time, with a column for each tag.
    Wide,
    /// A row for each reading: tag, time, value and, where there is one, quality.
    Long,
}

/// The sign between whole and fraction.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Decimal {
    /// `1.5`
    Point,
    /// `1,5`
    Comma,
}

impl Reading {
    /// Refuses what could not be followed in any file.
    pub(super) fn check(&self) -> Result<(), ReadingError> {
        if let Some(resample) = &self.resample {
            resample.check()?;
        }
        self.encoding()?;
        self.zone()?;
        if self.header_line == Some(0) {
            return Err(ReadingError::HeaderLineZero);
        }
        if let Some(found) = self.bad_values.iter().find(|word| is_number(word)) {
            let found = found.clone();
            return Err(ReadingError::BadValue { found });
        }
        Ok(())
    }

    /// Refuses what a Parquet file, which says that itself, cannot follow.
    pub(super) fn check_parquet(&self) -> Result<(), ReadingError> {
        let given = [
            ("encoding", self.encoding.is_some()),
            ("decimal", self.decimal.is_some()),
            ("header-line", self.header_line.is_some()),
        ];
        match given.into_iter().find(|(_, is_given)| *is_given) {
            Some((option, _)) => Err(ReadingError::OnlyForText { option }),
            None => Ok(()),
        }
    }

    /// Refuses what a log, which says all of that itself, cannot follow.
    pub(crate) fn check_log(&self) -> Result<(), ReadingError> {
        let given = [
            ("encoding", self.encoding.is_some()),
            ("decimal", self.decimal.is_some()),
            ("header-line", self.header_line.is_some()),
            ("bad-values", !self.bad_values.is_empty()),
            ("time-zone", self.time_zone.is_some()),
            ("time-format", self.time_format.is_some()),
            ("layout", self.layout.is_some()),
            ("resample", self.resample.is_some()),
            ("tags", self.tags.is_some()),
        ];
        match given.into_iter().find(|(_, is_given)| *is_given) {
            Some((option, _)) => Err(ReadingError::NotForLogs { option }),
            None => Ok(()),
        }
    }

    /// The encoding that is asked for.
    pub(crate) fn encoding(&self) -> Result<Option<&'static Encoding>, ReadingError> {
        let Some(label) = &self.encoding else {
            return Ok(None);
        };
        let found = Encoding::for_label(label.as_bytes());
        found.map(Some).ok_or_else(|| ReadingError::Encoding {
            found: label.clone(),
        })
    }

    /// The zone of times without an offset. The zones are those that are built in, so that a file
    /// means the same on every machine.
    pub(super) fn zone(&self) -> Result<TimeZone, ReadingError> {
        let Some(name) = &self.time_zone else {
            return Ok(TimeZone::UTC);
        };
        let found = TimeZoneDatabase::bundled().get(name);
        found.map_err(|_| ReadingError::TimeZone {
            found: name.clone(),
        })
    }
}

fn is_number(word: &str) -> bool {
    word.trim()
        .parse::<f64>()
        .is_ok_and(|value| !value.is_nan())
}
