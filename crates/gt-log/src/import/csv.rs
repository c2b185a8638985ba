//! CSV files.

use std::collections::HashSet;
use std::path::Path;

use gt_core::Signal;

use super::number::{Numerals, is_decimal};
use super::rows::{Rows, delimiter, is_plain_number, lines, outside_quotes};
use super::sheet::{Cell, Sheet};
use super::{Decimal, Reading, ReadingError, Warning};
use crate::{LogError, Place};

/// Lines that are looked at for a header that does not stand first.
const PREAMBLE: usize = 200;
/// The longest text that is taken for a unit.
const LONGEST_UNIT: usize = 24;

/// The rows of a CSV file below its header.
pub(crate) struct CsvSheet<'a> {
    path: &'a Path,
    rows: Rows<'a>,
    header: Vec<Signal>,
    line: u64,
    has_record: bool,
    /// What the file does not say but shows.
    pub(crate) dialect: Dialect<'a>,
}

/// How a CSV file is written.
#[derive(Debug, Clone)]
pub(crate) struct Dialect<'a> {
    /// From the header on.
    body: &'a [u8],
    /// The line of the header's text, from 1.
    line: u64,
    pub(crate) delimiter: u8,
    pub(crate) decimal: Decimal,
    /// The line of the units below the header.
    pub(crate) unit_line: Option<u64>,
    /// What the user should know of that.
    pub(crate) warnings: Vec<Warning>,
}

impl<'a> CsvSheet<'a> {
    /// Reads the header of UTF-8 text.
    pub(crate) fn open(
        path: &'a Path,
        bytes: &'a [u8],
        reading: &Reading,
    ) -> Result<Self, LogError> {
        let mut dialect = Dialect::of(path, bytes, reading)?;
        let mut rows = dialect.rows(path);
        let (line, mut header) = header(path, &mut rows, dialect.delimiter)?;
        if reading.header_line.is_none() {
            dialect.check_preamble(path, line, header.len())?;
        }
        dialect.find_decimal(path, reading)?;
        if let Some((line, units)) = dialect.units(path, header.len(), reading)? {
            for (signal, unit) in header.iter_mut().zip(units) {
                signal.unit = unit;
            }
            rows.next()?;
            dialect.unit_line = Some(line);
            dialect.warnings.push(Warning::UnitRow { line });
        }
        Ok(Self {
            path,
            rows,
            header,
            line,
            has_record: false,
            dialect,
        })
    }
}

impl Sheet for CsvSheet<'_> {
    fn header(&self) -> &[Signal] {
        &self.header
    }

    fn rewind(&mut self) -> Result<(), LogError> {
        self.rows = self.dialect.rows(self.path);
        self.rows.first()?;
        if self.dialect.unit_line.is_some() {
            self.rows.next()?;
        }
        Ok(())
    }

    fn advance(&mut self) -> Result<bool, LogError> {
        let Some((line, has_record)) = self.rows.next()? else {
            return Ok(false);
        };
        (self.line, self.has_record) = (line, has_record);
        Ok(true)
    }

    fn place(&self) -> Place {
        Place::Line(self.line)
    }

    fn fields(&self) -> usize {
        if self.has_record {
            return self.rows.record().len();
        }
        // In a file of one column a blank line is an empty cell.
        usize::from(self.header.len() == 1)
    }

    fn cell(&self, column: usize) -> Cell<'_> {
        let record = self.has_record.then(|| self.rows.record());
        Cell::Text(
            record
                .and_then(|record| record.get(column))
                .unwrap_or_default(),
        )
    }
}

impl<'a> Dialect<'a> {
    fn of(path: &Path, bytes: &'a [u8], reading: &Reading) -> Result<Self, LogError> {
        let (line, offset) = match reading.header_line {
            Some(wanted) => start_of(bytes, wanted).map_err(|e| LogError::reading(path, e))?,
            None => (1, 0),
        };
        let mut dialect = Self {
            body: &bytes[offset..],
            line,
            delimiter: b',',
            decimal: Decimal::Point,
            unit_line: None,
            warnings: Vec::new(),
        };
        let mut filled = lines(dialect.body).filter(|(.., line)| !line.trim_ascii().is_empty());
        let first = filled.next();
        // Spreadsheets may say their separator in a line of its own.
        let told = first.and_then(|(.., text)| match text.trim_ascii() {
            [b's', b'e', b'p', b'=', told] => Some(*told),
            _ => None,
        });
        let header = if told.is_some() { filled.next() } else { first };
        let shown = header.and_then(|(.., text)| delimiter(text));
        let alone = match reading.decimal {
            Some(Decimal::Comma) => b';',
            _ => b',',
        };
        dialect.delimiter = told.or(shown).unwrap_or(alone);
        if let (Some(_), Some((number, offset, _))) = (told, header) {
            (dialect.line, dialect.body) = (dialect.line + number - 1, &dialect.body[offset..]);
        }
        Ok(dialect)
    }

    fn rows(&self, path: &'a Path) -> Rows<'a> {
        Rows::new(path, self.body, self.line, self.delimiter)
    }

    /// Refuses a first row of one field where later ones have many.
    fn check_preamble(&self, path: &Path, line: u64, found: usize) -> Result<(), LogError> {
        if found != 1 {
            return Ok(());
        }
        let filled = lines(self.body)
            .filter(|(.., text)| !text.trim_ascii().is_empty())
            .take(PREAMBLE)
            .map(|(number, _, text)| {
                let mark = delimiter(text).unwrap_or(b',');
                (number, mark, 1 + outside_quotes(text, mark))
            });
        let filled: Vec<(u64, u8, usize)> = filled.collect();
        let guess = filled.windows(2).skip(1).find(|pair| {
            let ((_, mark, fields), (_, next_mark, next_fields)) = (pair[0], pair[1]);
            fields > 1 && (mark, fields) == (next_mark, next_fields)
        });
        // A row of numbers is no header.
        let guess = guess.filter(|pair| {
            let text = lines(self.body).find(|(number, ..)| *number == pair[0].0);
            let text = text.map(|(.., text)| text).unwrap_or_default();
            let mut cells = text.split(|&byte| byte == pair[0].1);
            let is_number = |cell: &[u8]| {
                let cell = std::str::from_utf8(cell).ok().map(str::trim);
                cell.is_some_and(|cell| is_plain_number(cell, pair[0].1))
            };
            !cells.all(is_number)
        });
        match guess {
            None => Ok(()),
            Some(pair) => Err(LogError::reading(
                path,
                ReadingError::Preamble {
                    line,
                    found,
                    guess: self.line + pair[0].0 - 1,
                    fields: pair[0].2,
                },
            )),
        }
    }

    /// Decides between decimal point and decimal comma. A comma that separates fields is none.
    fn find_decimal(&mut self, path: &'a Path, reading: &Reading) -> Result<(), LogError> {
        if let Some(given) = reading.decimal {
            self.decimal = given;
            return Ok(());
        }
        if self.delimiter == b',' || !self.body.contains(&b',') {
            return Ok(());
        }
        let mut rows = self.rows(path);
        rows.first()?;
        let mut commas = 0;
        while let Some((_, has_record)) = rows.next()? {
            if !has_record {
                continue;
            }
            if rows.record().iter().any(|cell| is_decimal(cell, b'.')) {
                return Ok(());
            }
            let record = rows.record().iter();
            commas += record.filter(|cell| is_decimal(cell, b',')).count();
        }
        if commas > 0 {
            self.decimal = Decimal::Comma;
            self.warnings.push(Warning::DecimalComma);
        }
        Ok(())
    }

    /// The row below the header, where it holds units: texts, none of them a number, a time or a
    /// word for a missing value, above a row that has a number.
    fn units(
        &self,
        path: &'a Path,
        count: usize,
        reading: &Reading,
    ) -> Result<Option<(u64, Vec<String>)>, LogError> {
        let numerals = Numerals::new(self.decimal, reading);
        let mut rows = self.rows(path);
        rows.first()?;
        let Some((line, true)) = rows.next()? else {
            return Ok(None);
        };
        let units: Vec<String> = rows
            .record()
            .iter()
            .map(|cell| bare(cell).to_owned())
            .collect();
        let is_unit = |text: &String| {
            text.len() <= LONGEST_UNIT
                && (text.is_empty() || !numerals.is_missing(text) || text == "-")
                && numerals.parse(text).is_none()
                && text.bytes().filter(u8::is_ascii_digit).nth(3).is_none()
        };
        let named = |text: &&String| !text.is_empty() && *text != "-";
        if units.len() != count || !units.iter().all(is_unit) || units.iter().find(named).is_none()
        {
            return Ok(None);
        }
        let Some((_, true)) = rows.next()? else {
            return Ok(None);
        };
        let is_number = |cell: &str| numerals.parse(cell).is_some_and(f64::is_finite);
        let follows = rows.record().iter().any(is_number);
        Ok(follows.then_some((line, units)))
    }
}

/// The number and the offset of a line that is asked for.
fn start_of(bytes: &[u8], wanted: u64) -> Result<(u64, usize), ReadingError> {
    let mut count = 0;
    for (number, offset, _) in lines(bytes) {
        if number == wanted {
            return Ok((number, offset));
        }
        count = number;
    }
    Err(ReadingError::HeaderLine {
        found: wanted,
        lines: count,
    })
}

/// The tags and their line; an unnamed column has an empty one.
fn header(path: &Path, rows: &mut Rows<'_>, delimiter: u8) -> Result<(u64, Vec<Signal>), LogError> {
    let Some(line) = rows.first()? else {
        return Err(LogError::Empty {
            path: path.to_owned(),
        });
    };
    let tags: Vec<&str> = rows.record().iter().map(bare).collect();
    let is_number = |tag: &&str| is_plain_number(tag, delimiter);
    // Plain integers may be names (`0,1,2` is what some tools write).
    if tags.iter().all(is_number) && tags.iter().any(|tag| tag.parse::<i64>().is_err()) {
        let found = tags.join(&char::from(delimiter).to_string());
        return Err(LogError::HeaderOfNumbers {
            path: path.to_owned(),
            line,
            found,
        });
    }
    let mut seen = HashSet::new();
    let mut named = rows.record().iter().filter(|tag| !tag.is_empty());
    if let Some(twice) = named.find(|tag| !seen.insert(*tag)) {
        let (path, column) = (path.to_owned(), twice.to_owned());
        return Err(LogError::DuplicateColumn { path, line, column });
    }
    let signals = tags.into_iter().map(|tag| Signal::new(tag, "")).collect();
    Ok((line, signals))
}

/// The field without quotes: CSV knows them only where no space stands before them.
fn bare(field: &str) -> &str {
    let inner = field
        .strip_prefix('"')
        .and_then(|rest| rest.strip_suffix('"'));
    inner.map_or(field, str::trim)
}
