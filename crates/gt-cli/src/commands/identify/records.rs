//! The records behind a model: what it is fitted to, and what it is judged on.

use std::ops::Range;
use std::path::{Path, PathBuf};

use gt_log::{Imported, LogError, Resampled, Selection};
use gtfdi::core::Dataset;
use gtfdi::ident::{IdentError, Missing, RecordOrigin, unbroken};
use serde::Serialize;

use super::blocks::Blocks;
use super::hint::hint;
use crate::cli::{ErrorModel, IdentifyArgs, Method};
use crate::failure::Failure;
use crate::record::{check_out, read, selection, unreadable};

/// A file that was read.
#[derive(Serialize)]
pub struct Source {
    pub data: PathBuf,
    train_rows: Option<[usize; 2]>,
    validation_rows: Option<[usize; 2]>,
    pub input_sha256: String,
    /// What resampling made of the file.
    resampled: Option<Resampled>,
    /// The line that was taken out.
    pub trend: Option<Slopes>,
}

/// The slopes that were taken out of a record.
pub type Slopes = Vec<Slope>;

/// The slope that was taken out of a channel.
#[derive(Serialize)]
pub struct Slope {
    pub signal: String,
    pub per_s: f64,
}

/// What is fitted to and judged on; every piece is without gaps unless those are refused.
pub struct Records {
    pub train: Vec<Dataset>,
    pub validation: Vec<Dataset>,
    /// What a single validation record is to the fit.
    pub origin: RecordOrigin,
    /// The records of the fit.
    pub sources: Vec<Source>,
    pub holdout: Option<Source>,
    pub warnings: Vec<String>,
    /// The option that asks for the validation rows.
    validated: String,
    /// Whether the fit can be held by a ridge.
    takes_ridge: bool,
    /// Whether lines in time are taken out.
    detrends: bool,
}

impl Records {
    /// Reads all records, after a look at the files that are to be written.
    pub fn read(args: &IdentifyArgs) -> Result<Self, Failure> {
        let paths = args.data.as_deref().unwrap_or_default();
        if paths.is_empty() {
            return Err(Failure::missing("DATA", "gtfdi identify run.csv"));
        }
        let inputs = args.inputs.clone().unwrap_or_default();
        let outputs = args.outputs.clone();
        let outputs = outputs.ok_or_else(|| Failure::missing("--outputs", "--outputs y"))?;
        if args.holdout.is_some() && args.validate.is_some() {
            return Err(Failure::input(
                "--holdout: expected without --validate, found both",
            ));
        }
        let all: Vec<&Path> = paths
            .iter()
            .chain(&args.holdout)
            .map(PathBuf::as_path)
            .collect();
        for out in args.out.iter().chain(&args.plot) {
            check_out(out, &all)?;
        }
        let blocks = Blocks::of(args);
        let wanted = selection(inputs, outputs, &args.reading, blocks.window.clone())?;
        let mut records = Self {
            train: Vec::new(),
            validation: Vec::new(),
            origin: blocks.origin(args.holdout.is_some()),
            sources: Vec::new(),
            holdout: None,
            warnings: Vec::new(),
            validated: match (&args.holdout, &args.validate) {
                (Some(path), _) => format!("--holdout {}", path.display()),
                (None, Some(rows)) => format!("--validate {rows}"),
                (None, None) => "the training rows".to_owned(),
            },
            takes_ridge: !matches!(args.method, Some(Method::Eiv | Method::Frisch))
                && args.stable.is_none()
                && args.dc_gain.is_none()
                && args.equation_errors != Some(ErrorModel::Correlated),
            detrends: args.detrend == Some(true),
        };
        for path in paths {
            records.add(path, &wanted, &blocks, args.holdout.is_none())?;
        }
        if let Some(path) = &args.holdout {
            records.add_holdout(path, &wanted)?;
        }
        if records.train.is_empty() {
            return Err(records.in_files("expected samples of all channels, found none"));
        }
        Ok(records)
    }

    fn add(
        &mut self,
        path: &Path,
        wanted: &Selection,
        blocks: &Blocks,
        validates: bool,
    ) -> Result<(), Failure> {
        let mut imported = self.import(path, wanted, |error| match error {
            LogError::Rows { total, .. } => blocks.beyond(path, *total),
            _ => None,
        })?;
        if let Some(failure) = blocks.beyond(path, imported.total_rows) {
            return Err(failure);
        }
        let shift = blocks.window.as_ref().map_or(0, |window| window.start);
        let whole = shift..shift + imported.dataset.len();
        let train = blocks.train.clone().unwrap_or(whole);
        let validation = blocks.validate.clone().unwrap_or_else(|| train.clone());
        let within = |rows: &Range<usize>| rows.start - shift..rows.end - shift;
        let trend = self.detrend(path, &mut imported, within(&train))?;
        let pieces = |rows: &Range<usize>| pieces(path, &imported, within(rows), wanted.missing);
        self.train.extend(pieces(&train)?);
        if validates {
            self.validation.extend(pieces(&validation)?);
        }
        self.sources.push(Source {
            data: path.to_owned(),
            train_rows: Some([train.start, train.end]),
            validation_rows: validates.then_some([validation.start, validation.end]),
            input_sha256: imported.sha256,
            resampled: imported.resampled,
            trend,
        });
        Ok(())
    }

    fn add_holdout(&mut self, path: &Path, wanted: &Selection) -> Result<(), Failure> {
        let whole = Selection {
            rows: None,
            ..wanted.clone()
        };
        let mut imported = self.import(path, &whole, |_| None)?;
        let rows = 0..imported.dataset.len();
        let trend = self.detrend(path, &mut imported, rows.clone())?;
        self.validation = pieces(path, &imported, rows.clone(), wanted.missing)?;
        self.holdout = Some(Source {
            data: path.to_owned(),
            train_rows: None,
            validation_rows: Some([rows.start, rows.end]),
            input_sha256: imported.sha256,
            resampled: imported.resampled,
            trend,
        });
        Ok(())
    }

    /// Takes the trend of some samples out of a record, where that is asked for.
    fn detrend(
        &self,
        path: &Path,
        imported: &mut Imported,
        samples: Range<usize>,
    ) -> Result<Option<Slopes>, Failure> {
        if !self.detrends {
            return Ok(None);
        }
        let data = &imported.dataset;
        let part = data.rows(samples);
        let trend = part.map_err(|error| Failure::in_file(path, error))?.trend();
        let flat = data.detrended(&trend);
        let slopes = trend.u_slope_per_s.iter().chain(&trend.y_slope_per_s);
        let names = data.inputs().iter().chain(data.outputs());
        let slopes = names.zip(slopes).map(|(signal, &slope)| Slope {
            signal: signal.name.clone(),
            per_s: slope,
        });
        let slopes = slopes.collect();
        imported.dataset = flat.map_err(|error| Failure::in_file(path, error))?;
        Ok(Some(slopes))
    }

    fn import(
        &mut self,
        path: &Path,
        wanted: &Selection,
        known: impl Fn(&LogError) -> Option<Failure>,
    ) -> Result<Imported, Failure> {
        let found = read(path, wanted)
            .map_err(|error| known(&error).unwrap_or_else(|| unreadable(&error)))?;
        self.warnings.extend(found.warnings);
        Ok(found.imported)
    }

    /// The records that are fitted to.
    pub fn train(&self) -> Vec<&Dataset> {
        self.train.iter().collect()
    }

    /// The records that the model is judged on.
    pub fn validation(&self) -> Vec<&Dataset> {
        self.validation.iter().collect()
    }

    /// The longest record that is fitted to.
    pub fn longest(&self) -> Option<&Dataset> {
        self.train.iter().max_by_key(|data| data.len())
    }

    /// The samples that are fitted to.
    pub fn samples(&self) -> usize {
        self.train.iter().map(Dataset::len).sum()
    }

    /// Whether rows are validated on that no fit has seen.
    pub fn has_fresh_rows(&self) -> bool {
        self.holdout.is_some()
            || self.sources.iter().all(|source| {
                let rows = [source.train_rows, source.validation_rows];
                matches!(rows, [Some(a), Some(b)] if a[1] <= b[0] || b[1] <= a[0])
            })
    }

    /// The one record that `option` takes.
    pub fn one<'a>(option: &str, what: &str, found: &'a [Dataset]) -> Result<&'a Dataset, Failure> {
        match found {
            [only] => Ok(only),
            found => Err(Failure::input(format!(
                "{option}: expected one {what} record without a break, found {}; plain least \
                 squares (--method arx) takes several",
                found.len()
            ))),
        }
    }

    /// A mistake in the records, by the file that has it where that can be told.
    pub fn refused(&self, error: &IdentError) -> Failure {
        let text = match hint(error, self.takes_ridge) {
            Some(hint) => format!("{error}; {hint}"),
            None => error.to_string(),
        };
        let odd = match error {
            IdentError::SampleTime { found, .. } => self
                .train
                .iter()
                .position(|data| data.sample_time_s().to_bits() == found.to_bits())
                .filter(|_| self.train.len() == self.sources.len()),
            _ => None,
        };
        match odd.and_then(|index| self.sources.get(index)) {
            Some(source) => Failure::in_file(&source.data, text),
            None => self.in_files(&text),
        }
    }

    /// A mistake in the records that the model is judged on.
    pub fn refused_validation(&self, error: &IdentError) -> Failure {
        self.in_files(&format!("{}: {error}", self.validated))
    }

    fn in_files(&self, text: &str) -> Failure {
        let names: Vec<String> = self
            .sources
            .iter()
            .map(|source| source.data.display().to_string())
            .collect();
        Failure::input(format!("{}: {text}", names.join(", ")))
    }

    /// The records as a warning begins with them.
    pub fn name(&self) -> String {
        match &self.sources[..] {
            [only] => only.data.display().to_string(),
            several => format!("{} records", several.len()),
        }
    }
}

impl Source {
    /// The rows of the file that were fitted to.
    pub fn train_rows(&self) -> Option<[usize; 2]> {
        self.train_rows
    }

    /// The rows of the file that the model is judged on.
    pub fn validation_rows(&self) -> Option<[usize; 2]> {
        self.validation_rows
    }
}

/// The parts of some samples without gaps in time and, where those break the record, missing samples.
fn pieces(
    path: &Path,
    imported: &Imported,
    samples: Range<usize>,
    missing: Missing,
) -> Result<Vec<Dataset>, Failure> {
    let pieces = imported.pieces(samples);
    let pieces = pieces.map_err(|error| Failure::in_file(path, error))?;
    if missing == Missing::Refuse {
        return Ok(pieces);
    }
    let parts: Result<Vec<_>, _> = pieces.iter().map(unbroken).collect();
    let parts = parts.map_err(|error| Failure::in_file(path, error))?;
    Ok(parts.into_iter().flatten().collect())
}
