//! What is in a table of data or a topic of a log, and all that is wrong with it.

mod damage;
mod examine;
mod log;
mod reading;
mod resampled;
mod suggest;
mod tag;
mod timing;

use std::path::Path;

use serde::Serialize;

use crate::import::{
    CsvSheet, Numerals, ParquetSheet, Reading, ReadingError, Resampled, Selection, Sheet as _,
    decode,
};
use crate::{Decimal, LogError, sha256_hex, source};
pub use damage::{Damage, DamageKind};
pub use suggest::{Comparison, Confidence, NotCompared, Reason, Suggestion};
pub use tag::{Outlier, Run, TagCheck, TagKind};
pub use timing::{Gap, TimeCheck};

/// What is in a table of data or a topic of a log, and all that is wrong with it.
#[derive(Debug, Clone, PartialEq, Default, Serialize)]
pub struct DataCheck {
    /// `wide`, `long`, or `log` for the messages of a topic.
    pub layout: Option<&'static str>,
    /// The topic of a log.
    pub topic: Option<String>,
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
    /// The data rows, or the messages of the topic.
    pub rows: usize,
    /// What resampling makes of the file, where that is asked for and possible: the times, the tags
    /// and the suggestions are those of the samples then.
    pub resampled: Option<Resampled>,
    /// The times; none without a time column.
    pub time: Option<TimeCheck>,
    /// The tags, in the order of the file.
    pub tags: Vec<TagCheck>,
    /// All that identification would refuse without `--missing` and `--resample`, those of the whole
    /// file first, then in the order of the file, each with what mends it.
    pub damages: Vec<Damage>,
    /// Tags that look like inputs. A suggestion, no more: what a loop sets may follow what it holds.
    pub suggested_inputs: Vec<Suggestion>,
    /// Tags that look like outputs.
    pub suggested_outputs: Vec<Suggestion>,
    /// What was compared to see which tags lead.
    pub comparison: Option<Comparison>,
    /// Why nothing was compared.
    pub not_compared: Option<NotCompared>,
}

/// Examines a `.csv`, `.parquet` or `.mcap` file as `selection` reads it; inputs and outputs are the
/// tags to look at, all where there are none. What cannot be read is a damage of the report, and where
/// the error itself says how to go on (another encoding, another header line, the day first) the rest
/// is examined so.
///
/// With [`Reading::resample`] a table is examined twice: as it stands for what resampling cannot mend,
/// and as the samples that it becomes for all else.
///
/// # Errors
/// A file that is not there or is no table, and options that no file could follow.
pub fn check(path: &Path, selection: &Selection) -> Result<DataCheck, LogError> {
    selection.check()?;
    let refused = |cause| LogError::reading(path, cause);
    let extension = path
        .extension()
        .map(|text| text.to_string_lossy().to_ascii_lowercase());
    let mut report = DataCheck::default();
    let bytes = match extension.as_deref() {
        Some("mcap") => {
            source::open(path)?;
            selection.reading.check_log().map_err(refused)?;
            if let Err(error) = log::examine(path, selection, &mut report) {
                report.damages.push(Damage::of_file(&error));
            }
            return Ok(report);
        }
        Some("csv" | "parquet") => source::read(path)?,
        found => {
            let found = found.map_or("no extension".to_owned(), |found| format!("`.{found}`"));
            return Err(refused(ReadingError::NoTable { found }));
        }
    };
    report.sha256 = sha256_hex(&bytes);
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
    if selection.reading.resample.is_some() {
        resampled::examine(path, &selection, &mut report);
    }
    Ok(report)
}

impl DataCheck {
    /// Suggests roles from the values of the tags, which belong together where they are `aligned`.
    fn suggest(&mut self, values: &[Vec<f64>], aligned: bool) {
        let is_moving = |tag: &TagCheck| tag.kind == TagKind::Number && !tag.constant;
        let moving: Vec<(&str, &[f64])> = self
            .tags
            .iter()
            .zip(values)
            .filter(|(tag, _)| is_moving(tag))
            .map(|(tag, values)| (tag.name.as_str(), values.as_slice()))
            .collect();
        let found = suggest::suggest(&moving, aligned);
        self.suggested_inputs = found.inputs;
        self.suggested_outputs = found.outputs;
        self.comparison = found.comparison;
        self.not_compared = found.not_compared;
    }
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
