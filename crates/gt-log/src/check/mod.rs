//! What is in a table of data, and all that is wrong with it.

mod damage;
mod examine;
mod tag;
mod timing;

use std::path::Path;

use serde::Serialize;

use crate::import::{
    CsvSheet, Numerals, ParquetSheet, Reading, ReadingError, Selection, Sheet as _, decode,
};
use crate::{Decimal, LogError, sha256_hex, source};
pub use damage::{Damage, DamageKind};
pub use tag::{Outlier, Run, TagCheck, TagKind};
pub use timing::{Gap, TimeCheck};

/// What is in a table of data, and all that is wrong with it.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct DataCheck {
    /// `wide` or `long`.
    pub layout: Option<&'static str>,
    /// The encoding of a CSV file.
    pub encoding: Option<&'static str>,
    /// The separator of a CSV file.
    pub separator: Option<char>,
    /// The decimal sign of a CSV file.
    pub decimal: Option<&'static str>,
    /// The line of a CSV file's units.
    pub unit_line: Option<u64>,
    /// The SHA-256 of the file.
    pub sha256: String,
    /// The data rows.
    pub rows: usize,
    /// The times; none without a time column.
    pub time: Option<TimeCheck>,
    /// The tags, in the order of the file.
    pub tags: Vec<TagCheck>,
    /// All that identification would refuse without `--missing` and `--resample`, those of the whole
    /// file first, then in the order of the file, each with what mends it.
    pub damages: Vec<Damage>,
}

/// Examines a `.csv` or `.parquet` file as `selection` reads it; inputs and outputs are the tags to
/// look at, all where there are none. What cannot be read is a damage of the report, and where the
/// error itself says how to go on (another encoding, another header line, the day first) the rest is
/// examined so.
///
/// # Errors
/// A file that is not there or is no table, and options that no file could follow.
pub fn check(path: &Path, selection: &Selection) -> Result<DataCheck, LogError> {
    selection.check()?;
    let extension = path
        .extension()
        .map(|text| text.to_string_lossy().to_ascii_lowercase());
    let bytes = match extension.as_deref() {
        Some("csv" | "parquet") => source::read(path)?,
        found => {
            let found = found.map_or("no extension".to_owned(), |found| format!("`.{found}`"));
            let cause = ReadingError::NoTable { found };
            return Err(LogError::reading(path, cause));
        }
    };
    let mut report = DataCheck {
        layout: None,
        encoding: None,
        separator: None,
        decimal: None,
        unit_line: None,
        sha256: sha256_hex(&bytes),
        rows: 0,
        time: None,
        tags: Vec::new(),
        damages: Vec::new(),
    };
    let mut selection = selection.clone();
    // Each retry takes one of three obstacles away.
    for _ in 0..4 {
        let result = match extension.as_deref() {
            Some("parquet") => examine_parquet(path, &bytes, &selection, &mut report),
            _ => examine_csv(path, &bytes, &selection, &mut report),
        };
        let Err(error) = result else { break };
        let is_passable = pass_over(&error, &mut selection.reading);
        report.damages.push(Damage::of_file(&error));
        if !is_passable {
            break;
        }
    }
    Ok(report)
}

/// Takes what an error says how to do; false where it says nothing.
fn pass_over(error: &LogError, reading: &mut Reading) -> bool {
    match error {
        LogError::NotText { found, .. } if *found != 0 && reading.encoding.is_none() => {
            reading.encoding = Some("windows-1252".to_owned());
            true
        }
        LogError::Reading { cause, .. } => match &**cause {
            ReadingError::Preamble { guess, .. } => {
                reading.header_line = Some(*guess);
                true
            }
            ReadingError::DayOrMonth { day_first, .. } => {
                reading.time_format = Some(day_first.clone());
                true
            }
            _ => false,
        },
        _ => false,
    }
}

fn examine_csv(
    path: &Path,
    bytes: &[u8],
    selection: &Selection,
    report: &mut DataCheck,
) -> Result<(), LogError> {
    let reading = &selection.reading;
    let encoding = reading.encoding();
    let text = decode(path, bytes, encoding.map_err(LogError::option)?)?;
    report.encoding = Some(text.encoding);
    let mut sheet = CsvSheet::open(path, &text.bytes, reading)?;
    report.separator = Some(char::from(sheet.dialect.delimiter));
    report.decimal = Some(match sheet.dialect.decimal {
        Decimal::Point => "point",
        Decimal::Comma => "comma",
    });
    report.unit_line = sheet.dialect.unit_line;
    let numerals = Numerals::new(sheet.dialect.decimal, reading);
    examine::examine(path, &mut sheet, &numerals, selection, report)
}

fn examine_parquet(
    path: &Path,
    bytes: &[u8],
    selection: &Selection,
    report: &mut DataCheck,
) -> Result<(), LogError> {
    let mut sheet = ParquetSheet::open(path, bytes.to_vec())?;
    let numerals = Numerals::new(Decimal::Point, &selection.reading);
    // Nested columns and others that hold no values are named; the rest is examined.
    for column in 0..sheet.header().len() {
        if let Err(error) = sheet.load(&[column]) {
            report.damages.push(Damage::of_file(&error));
        }
    }
    examine::examine(path, &mut sheet, &numerals, selection, report)
}
