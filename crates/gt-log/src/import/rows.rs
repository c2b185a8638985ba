//! The records of a CSV file with their true lines.

use std::collections::VecDeque;
use std::path::Path;

use csv::{ReaderBuilder, StringRecord, Trim};

use crate::LogError;

/// The records of a file with their true lines.
pub(crate) struct Rows<'a> {
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

impl<'a> Rows<'a> {
    /// The records of UTF-8 text that begins at `line`.
    pub(crate) fn new(path: &'a Path, bytes: &'a [u8], line: u64, delimiter: u8) -> Self {
        let reader = ReaderBuilder::new()
            .has_headers(false)
            .flexible(true)
            .trim(Trim::All)
            .delimiter(delimiter)
            .from_reader(bytes);
        let (record, blank) = (StringRecord::new(), VecDeque::new());
        Self {
            path,
            bytes,
            reader,
            record,
            record_line: None,
            blank,
            counted: 0,
            line,
        }
    }

    /// The first record that has a field, and its line; what is blank before it means nothing.
    pub(crate) fn first(&mut self) -> Result<Option<u64>, LogError> {
        if !self.read()? {
            return Ok(None);
        }
        self.blank.clear();
        Ok(self.record_line.take())
    }

    /// Goes to the next data row: its line, and whether it has a record.
    pub(crate) fn next(&mut self) -> Result<Option<(u64, bool)>, LogError> {
        if self.record_line.is_none() && !self.read()? {
            return Ok(None);
        }
        if let Some(line) = self.blank.pop_front() {
            return Ok(Some((line, false)));
        }
        Ok(self.record_line.take().map(|line| (line, true)))
    }

    /// The fields of the last record.
    pub(crate) fn record(&self) -> &StringRecord {
        &self.record
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

/// The lines of a text without their ends, each with its number, from 1, and its offset.
pub(crate) fn lines(bytes: &[u8]) -> impl Iterator<Item = (u64, usize, &[u8])> {
    let mut start = 0;
    let mut number = 0;
    std::iter::from_fn(move || {
        if start >= bytes.len() {
            return None;
        }
        let rest = &bytes[start..];
        let length = rest
            .iter()
            .position(|byte| matches!(byte, b'\n' | b'\r'))
            .unwrap_or(rest.len());
        let end = match rest.get(length..length + 2) {
            Some(b"\r\n") => length + 2,
            _ => length + 1,
        };
        let offset = start;
        start += end;
        number += 1;
        Some((number, offset, &rest[..length]))
    })
}

/// How often a byte stands outside quotes.
pub(crate) fn outside_quotes(line: &[u8], wanted: u8) -> usize {
    let mut quoted = false;
    let mut count = 0;
    for &byte in line {
        quoted ^= byte == b'"';
        count += usize::from(!quoted && byte == wanted);
    }
    count
}

/// The delimiter of a header: a comma, unless it has none, or none but decimal ones beside another:
/// then a semicolon or a tab.
pub(crate) fn delimiter(header: &[u8]) -> Option<u8> {
    let stands = |&byte: &u8| outside_quotes(header, byte) > 0;
    let other = [b';', b'\t'].into_iter().find(stands);
    let is_digit = |place: usize| header.get(place).is_some_and(u8::is_ascii_digit);
    let mut quoted = false;
    let commas = header.iter().enumerate().filter(|&(_, &byte)| {
        quoted ^= byte == b'"';
        !quoted && byte == b','
    });
    let mut places = commas.map(|(place, _)| place);
    let decimal = places.all(|place| place > 0 && is_digit(place - 1) && is_digit(place + 1));
    match other {
        Some(other) if decimal => Some(other),
        _ if stands(&b',') => Some(b','),
        other => other,
    }
}

/// Whether a cell of a header is a number, with a decimal comma where none stands between cells.
pub(crate) fn is_plain_number(cell: &str, delimiter: u8) -> bool {
    cell.parse::<f64>().is_ok()
        || delimiter != b',' && cell.replacen(',', ".", 1).parse::<f64>().is_ok()
}
