//! CSV files.

use std::collections::{HashSet, VecDeque};
use std::path::Path;

use csv::{ReaderBuilder, StringRecord, Trim};
use gt_core::Signal;
use gtfdi::ident::Missing;
use jiff::Timestamp;
use jiff::civil::DateTime;
use jiff::tz::TimeZone;

use super::select::{Columns, names};
use super::{Imported, Selection, Warning};
use crate::error::CellProblem;
use crate::table::Table;
use crate::time::{Clock, Uniform};
use crate::{LogError, Place, sha256_hex, source};

/// Names that make a column the time, first come first served.
const TIME_NAMES: [&str; 3] = ["time", "timestamp", "t"];

/// Reads the selected columns.
pub(super) fn read(path: &Path, selection: &Selection) -> Result<Imported, LogError> {
    let bytes = source::read(path)?;
    let mut rows = Rows::open(path, &bytes)?;
    let header = rows.header()?;
    let time = time_column(path, &header, selection)?;
    let columns = Columns::resolve(path, &header, time, selection)?;
    let mut table = Table::new(&columns, &header);
    // A sample time that is given makes the times in the file of no interest.
    let time = time.filter(|_| selection.sample_time_s.is_none());

    let wanted = selection.rows.clone().unwrap_or(0..usize::MAX);
    let mut clock = None;
    let mut lines = Vec::new();
    let mut total_rows = 0;
    while let Some(row) = rows.next()? {
        if wanted.contains(&total_rows) {
            let row = Cells {
                path,
                header: &header,
                row,
            };
            row.check_count()?;
            let sample: Result<Vec<f64>, _> = columns
                .all()
                .map(|c| row.sample(c, selection.missing))
                .collect();
            table.push(sample?);
            if let Some(column) = time {
                row.push_time(column, &mut clock)?;
            }
            lines.push(row.row.line);
        }
        total_rows += 1;
    }
    if total_rows == 0 {
        return Err(LogError::NoRows {
            path: path.to_owned(),
        });
    }
    let rows = selection.rows_of(path, total_rows)?;

    let mut warnings = Vec::new();
    let mut start_time_s = None;
    let mut start_unix_ns = None;
    let uniform = match (selection.sample_time_s, &clock) {
        (Some(given), _) => Uniform::given(given),
        (None, Some(clock)) => {
            match clock {
                Clock::Seconds(times) => start_time_s = times.first().copied(),
                Clock::Nanoseconds(times) => start_unix_ns = times.first().copied(),
            }
            clock.uniform(path, selection.missing, |row| Place::Line(lines[row]))?
        }
        (None, None) => {
            warnings.push(Warning::TimeInSamples);
            Uniform::given(1.0)
        }
    };
    let start_time_s = start_time_s.unwrap_or(rows.start as f64 * uniform.sample_time_s);
    warnings.extend(table.invalid_samples());
    let dataset = table.into_dataset(path, uniform.sample_time_s, start_time_s)?;
    let sha256 = sha256_hex(&bytes);
    Ok(Imported {
        dataset,
        sha256,
        warnings,
        total_rows,
        start_unix_ns,
        gaps: uniform.gaps,
    })
}

/// The tags of the header.
pub(super) fn columns(path: &Path) -> Result<Vec<Signal>, LogError> {
    let bytes = source::read(path)?;
    let mut rows = Rows::open(path, &bytes)?;
    let mut header = rows.header()?;
    header.retain(|signal| !signal.name.is_empty());
    Ok(header)
}

/// The position of the time column, where there is one.
fn time_column(
    path: &Path,
    header: &[Signal],
    selection: &Selection,
) -> Result<Option<usize>, LogError> {
    if let Some(name) = &selection.time {
        let index = header.iter().position(|signal| signal.name == *name);
        return index.map(Some).ok_or_else(|| LogError::UnknownColumn {
            path: path.to_owned(),
            column: name.clone(),
            available: names(header),
        });
    }
    // `T` may be a temperature: who selects it by name says so.
    let is_signal = |name: &String| {
        selection
            .inputs
            .iter()
            .chain(&selection.outputs)
            .any(|s| s == name)
    };
    Ok(TIME_NAMES.iter().find_map(|time| {
        header
            .iter()
            .position(|s| s.name.eq_ignore_ascii_case(time) && !is_signal(&s.name))
    }))
}

/// The records of a file with their true lines.
struct Rows<'a> {
    path: &'a Path,
    bytes: &'a [u8],
    reader: csv::Reader<&'a [u8]>,
    record: StringRecord,
    /// The line of `record`; `None` once it has been handed out.
    record_line: Option<u64>,
    /// Lines without a field before `record`. At the end of the file they mean nothing; before a
    /// record each is a row, for otherwise a lost sample would pass unseen.
    blank: VecDeque<u64>,
    /// Line ends before this offset are counted in `line`.
    counted: usize,
    /// The line at `counted`, from 1.
    line: u64,
}

/// A row with its line, from 1.
struct Row<'r> {
    line: u64,
    /// `None` for a blank line.
    record: Option<&'r StringRecord>,
}

impl<'a> Rows<'a> {
    fn open(path: &'a Path, bytes: &'a [u8]) -> Result<Self, LogError> {
        const BYTE_ORDER_MARK: &[u8] = &[0xef, 0xbb, 0xbf];
        check_text(path, bytes)?;
        let bytes = bytes.strip_prefix(BYTE_ORDER_MARK).unwrap_or(bytes);
        let reader = ReaderBuilder::new()
            .has_headers(false)
            .flexible(true)
            .trim(Trim::All)
            .delimiter(delimiter(bytes))
            .from_reader(bytes);
        let (record, blank) = (StringRecord::new(), VecDeque::new());
        Ok(Self {
            path,
            bytes,
            reader,
            record,
            record_line: None,
            blank,
            counted: 0,
            line: 1,
        })
    }

    /// The tags; an unnamed column has an empty one.
    fn header(&mut self) -> Result<Vec<Signal>, LogError> {
        if !self.read()? {
            return Err(LogError::Empty {
                path: self.path.to_owned(),
            });
        }
        self.blank.clear();
        let line = self.record_line.take().unwrap_or(1);
        let tags: Vec<&str> = self.record.iter().map(bare).collect();
        let is_number = |tag: &&str| tag.parse::<f64>().is_ok();
        // Plain integers may be names (`0,1,2` is what some tools write).
        if tags.iter().all(is_number) && tags.iter().any(|tag| tag.parse::<i64>().is_err()) {
            let found = tags.join(",");
            return Err(LogError::HeaderOfNumbers {
                path: self.path.to_owned(),
                line,
                found,
            });
        }
        let mut seen = HashSet::new();
        if let Some(twice) = self
            .record
            .iter()
            .find(|tag| !tag.is_empty() && !seen.insert(*tag))
        {
            let (path, column) = (self.path.to_owned(), twice.to_owned());
            return Err(LogError::DuplicateColumn { path, line, column });
        }
        Ok(tags.into_iter().map(|tag| Signal::new(tag, "")).collect())
    }

    /// The next data row.
    fn next(&mut self) -> Result<Option<Row<'_>>, LogError> {
        if self.record_line.is_none() && !self.read()? {
            return Ok(None);
        }
        if let Some(line) = self.blank.pop_front() {
            return Ok(Some(Row { line, record: None }));
        }
        let record = Some(&self.record);
        Ok(self.record_line.take().map(|line| Row { line, record }))
    }

    /// Reads the next record that has a field into `record`; blank lines before it go to `blank`.
    fn read(&mut self) -> Result<bool, LogError> {
        loop {
            let found = self
                .reader
                .read_record(&mut self.record)
                .map_err(|cause| LogError::io(self.path, "read", cause.into()))?;
            if !found {
                return Ok(false);
            }
            let start = self.record.position().map_or(0, csv::Position::byte);
            self.advance(usize::try_from(start).unwrap_or(usize::MAX));
            if self.record.len() == 1 && self.record.get(0) == Some("") {
                self.blank.push_back(self.line);
            } else {
                self.record_line = Some(self.line);
                return Ok(true);
            }
        }
    }

    /// Moves the count of lines to a record that the reader began at `start`. The line ends it
    /// begins with are those of blank lines, or the second half of the previous record's CR LF.
    fn advance(&mut self, start: usize) {
        while let Some(&byte) = self.bytes.get(self.counted) {
            let next = self.bytes.get(self.counted + 1);
            let before = self
                .counted
                .checked_sub(1)
                .and_then(|index| self.bytes.get(index));
            let ends_line = byte == b'\n' || (byte == b'\r' && next != Some(&b'\n'));
            if self.counted >= start {
                if !matches!(byte, b'\n' | b'\r') {
                    break;
                }
                let is_tail = self.counted == start && byte == b'\n' && before == Some(&b'\r');
                if ends_line && !is_tail {
                    self.blank.push_back(self.line);
                }
            }
            self.line += u64::from(ends_line);
            self.counted += 1;
        }
    }
}

/// Refuses what is not UTF-8 text. A NUL is valid UTF-8, but no text has one (UTF-16 has many).
fn check_text(path: &Path, bytes: &[u8]) -> Result<(), LogError> {
    let nul = bytes.iter().position(|&byte| byte == 0);
    let invalid = std::str::from_utf8(bytes)
        .err()
        .map(|cause| cause.valid_up_to());
    let Some(offset) = nul.into_iter().chain(invalid).min() else {
        return Ok(());
    };
    let line = bytes[..offset].split(|&byte| byte == b'\n').count() as u64;
    Err(LogError::NotText {
        path: path.to_owned(),
        line,
        offset,
        found: bytes[offset],
    })
}

/// The field without quotes: CSV knows them only where no space stands before them.
fn bare(field: &str) -> &str {
    let inner = field
        .strip_prefix('"')
        .and_then(|rest| rest.strip_suffix('"'));
    inner.map_or(field, str::trim)
}

/// A comma, unless the header has none: then a semicolon or a tab.
fn delimiter(bytes: &[u8]) -> u8 {
    let header = bytes
        .split(|&byte| matches!(byte, b'\n' | b'\r'))
        .find(|line| !line.trim_ascii().is_empty())
        .unwrap_or_default();
    let mut quoted = false;
    let outside: Vec<u8> = header
        .iter()
        .copied()
        .filter(|&byte| {
            quoted ^= byte == b'"';
            !quoted
        })
        .collect();
    [b',', b';', b'\t']
        .into_iter()
        .find(|byte| outside.contains(byte))
        .unwrap_or(b',')
}

/// A data row that knows its header.
struct Cells<'r> {
    path: &'r Path,
    header: &'r [Signal],
    row: Row<'r>,
}

impl Cells<'_> {
    fn check_count(&self) -> Result<(), LogError> {
        let expected = self.header.len();
        let found = match self.row.record {
            Some(record) => record.len(),
            // In a file of one column a blank line is an empty cell.
            None => usize::from(expected == 1),
        };
        if found == expected {
            return Ok(());
        }
        Err(LogError::Ragged {
            path: self.path.to_owned(),
            line: self.row.line,
            expected,
            found,
        })
    }

    fn cell(&self, column: usize) -> &str {
        self.row
            .record
            .and_then(|record| record.get(column))
            .unwrap_or_default()
    }

    fn problem(&self, column: usize, problem: CellProblem) -> LogError {
        LogError::Cell {
            path: self.path.to_owned(),
            line: self.row.line,
            column: self.header[column].name.clone(),
            problem,
        }
    }

    fn number(&self, column: usize) -> Result<f64, LogError> {
        let cell = self.cell(column);
        let problem = match cell.parse::<f64>() {
            Ok(value) if value.is_finite() => return Ok(value),
            Ok(_) => CellProblem::NotFinite(cell.to_owned()),
            Err(_) if cell.is_empty() => CellProblem::Empty,
            Err(_) => CellProblem::Text(cell.to_owned()),
        };
        Err(self.problem(column, problem))
    }

    /// The number of a cell; NaN where there is none and that may be.
    fn sample(&self, column: usize, missing: Missing) -> Result<f64, LogError> {
        let cell = self.cell(column);
        let none = cell.is_empty() || cell.parse::<f64>().is_ok_and(f64::is_nan);
        if none && missing == Missing::Break {
            return Ok(f64::NAN);
        }
        self.number(column)
    }

    /// Appends the time of this row. The first row decides whether times are seconds or instants.
    fn push_time(&self, column: usize, clock: &mut Option<Clock>) -> Result<(), LogError> {
        let cell = self.cell(column);
        let seconds = cell.parse::<f64>().ok();
        let clock = clock.get_or_insert_with(|| match seconds {
            None if instant_ns(cell).is_some() => Clock::Nanoseconds(Vec::new()),
            _ => Clock::Seconds(Vec::new()),
        });
        match clock {
            Clock::Nanoseconds(times) => {
                let not_a_time = || self.problem(column, CellProblem::Time(cell.to_owned()));
                times.push(instant_ns(cell).ok_or_else(not_a_time)?);
            }
            Clock::Seconds(times) => match seconds {
                Some(_) => times.push(self.number(column)?),
                None if cell.is_empty() => return Err(self.problem(column, CellProblem::Empty)),
                None => return Err(self.problem(column, CellProblem::Time(cell.to_owned()))),
            },
        }
        Ok(())
    }
}

/// Nanoseconds since 1970 of an ISO 8601 time; without an offset it is taken as UTC.
fn instant_ns(cell: &str) -> Option<i128> {
    if let Ok(instant) = cell.parse::<Timestamp>() {
        return Some(instant.as_nanosecond());
    }
    let civil = cell.parse::<DateTime>().ok()?;
    civil
        .to_zoned(TimeZone::UTC)
        .ok()
        .map(|zoned| zoned.timestamp().as_nanosecond())
}
