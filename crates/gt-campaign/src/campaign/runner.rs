//! Runs on all cores, chunk by chunk.

use std::ops::Range;
use std::path::Path;
use std::sync::atomic::{AtomicU64, Ordering};

use gt_log::DetectorFile;
use gtfdi::plant::{
    Channel, Noise, PlantError, PlantParameters, Run, SAMPLE_TIME_S, Scenario, Variant,
    lanes_at_once, simulate_batch,
};

use super::bank_choice::BankChoice;
use super::check::Problem;
use super::draw::DrawnFault;
use super::folder::{Folder, Found, open, stored_bank};
use super::judge::{Judge, Judgement};
use super::row::{Row, RunFailure};
use super::spec::Spec;
use crate::error::{CampaignError, During as _};
use crate::parallel;
use crate::progress::Progress;

/// A campaign that is ready to run: its specification and the bank that judges.
#[derive(Debug, Clone)]
pub struct Campaign {
    spec: Spec,
    judge: Judge,
    noise: Noise,
    plant: PlantParameters,
}

impl Campaign {
    /// A campaign with a bank or an isolator.
    ///
    /// # Errors
    /// As [`Spec::noise`];
    /// [`CampaignError::Value`] for a bank that reads what the plant has not, or at another sample
    /// time.
    pub fn new(spec: Spec, bank: DetectorFile) -> Result<Self, CampaignError> {
        let refused = |expected: String, found: String| {
            Err(CampaignError::Value(Problem::new("bank", expected, found)))
        };
        // Files carry decimal digits.
        if (bank.sample_time_s() - SAMPLE_TIME_S).abs() > 1e-9 {
            let expected = format!("a sample time of {SAMPLE_TIME_S} s");
            return refused(expected, format!("{} s", bank.sample_time_s()));
        }
        for tag in bank.inputs().iter().chain(&bank.outputs()) {
            let known = Channel::named(tag);
            if !known.is_ok_and(|channel| channel.is_in(Variant::Prototype)) {
                let expected = "channels of the prototype".to_owned();
                return refused(expected, format!("`{tag}`"));
            }
        }
        let noise = spec.noise()?;
        Ok(Self::with_noise(spec, bank, noise))
    }

    /// A campaign of parts that fit each other.
    pub(super) fn with_noise(spec: Spec, bank: DetectorFile, noise: Noise) -> Self {
        let horizon_s = spec.record.horizon_s.unwrap_or(f64::INFINITY);
        Self {
            judge: Judge::new(bank, horizon_s),
            noise,
            plant: PlantParameters::for_maps(spec.plant.map_set),
            spec,
        }
    }

    /// The noise of all records.
    pub(super) fn noise(&self) -> &Noise {
        &self.noise
    }

    /// The specification.
    pub fn spec(&self) -> &Spec {
        &self.spec
    }

    /// The scenario of a run.
    ///
    /// # Errors
    /// As [`Spec::scenario_of`].
    pub fn scenario(&self, run: u64) -> Result<Scenario, PlantError> {
        let drawn = self.spec.draw(run);
        self.spec.scenario_of(run, drawn.as_ref(), &self.noise)
    }

    /// The row of a run, of which it is the same bit for bit whatever runs beside it.
    ///
    /// # Errors
    /// [`CampaignError::Value`] for a run that the campaign does not have; as [`Campaign::rows`].
    pub fn row(&self, run: u64) -> Result<Row, CampaignError> {
        if run >= self.spec.runs {
            let expected = format!("below the number of runs, {}", self.spec.runs);
            return Err(CampaignError::Value(Problem::new("run", expected, run)));
        }
        let mut rows = self.rows(&[run])?;
        rows.pop()
            .ok_or(CampaignError::Stopped { done: 0, total: 1 })
    }

    /// The rows of some runs, in their order, on one core: those of a call are simulated together,
    /// a plant in each lane of a register.
    ///
    /// # Errors
    /// [`CampaignError::Fdi`] for a record that does not fit the bank. A run that fails is a row.
    pub fn rows(&self, runs: &[u64]) -> Result<Vec<Row>, CampaignError> {
        let drawn: Vec<Option<DrawnFault>> = runs.iter().map(|&run| self.spec.draw(run)).collect();
        let scenarios = runs
            .iter()
            .zip(&drawn)
            .map(|(&run, drawn)| self.spec.scenario_of(run, drawn.as_ref(), &self.noise))
            .collect::<Result<Vec<Scenario>, _>>()
            .during("scenario")?;
        let records = simulate_batch(&self.plant, &scenarios);
        let judged = runs.iter().zip(&drawn).zip(records);
        judged
            .map(|((&run, drawn), record)| {
                let fault = drawn.map(|drawn| (drawn.plan.case.name(), drawn.onset_s));
                let outcome: Result<Judgement, RunFailure> = match record {
                    Err(error)
                    | Ok(Run {
                        ended: Some(error), ..
                    }) => Err(RunFailure::from(&error)),
                    Ok(record) => {
                        let judged = self.judge.judge(&record.measured, fault);
                        Ok(judged.during(&format!("run {run}"))?)
                    }
                };
                Ok(Row::new(run, drawn.as_ref(), outcome))
            })
            .collect()
    }

    /// The rows of consecutive runs, on one core; nothing where progress wants the work to end.
    ///
    /// # Errors
    /// As [`Campaign::rows`].
    pub(super) fn rows_of(
        &self,
        runs: Range<u64>,
        progress: &dyn Progress,
    ) -> Result<Option<Vec<Row>>, CampaignError> {
        let runs: Vec<u64> = runs.collect();
        let mut rows = Vec::with_capacity(runs.len());
        for group in runs.chunks(lanes_at_once()) {
            if progress.is_stopped() {
                return Ok(None);
            }
            rows.extend(self.rows(group)?);
        }
        Ok(Some(rows))
    }

    /// Runs what a folder has not, and gives all rows.
    ///
    /// # Errors
    /// [`CampaignError::Stopped`] when progress says so, [`CampaignError::Unfinished`] where a file
    /// could not be written: what is there stays, and the same call goes on from it.
    pub fn fill(
        &self,
        folder: &Folder,
        progress: &dyn Progress,
    ) -> Result<Vec<Row>, CampaignError> {
        if let Some(rows) = folder.finished() {
            folder.remove_chunks()?;
            return Ok(rows);
        }
        let what = "runs";
        let missing = folder.missing()?;
        let length = |chunk: u64| {
            let runs = folder.runs_of(chunk);
            runs.end - runs.start
        };
        let left: u64 = missing.iter().map(|&chunk| length(chunk)).sum();
        let done = AtomicU64::new(self.spec.runs - left);
        #[expect(clippy::cast_possible_truncation, reason = "at most a billion")]
        let report = |done: u64| progress.report(what, done as usize, self.spec.runs as usize);
        report(done.load(Ordering::Relaxed));
        let unfinished = |source: CampaignError| match source {
            stopped @ CampaignError::Stopped { .. } => stopped,
            source => CampaignError::Unfinished {
                folder: folder.path().to_owned(),
                done: done.load(Ordering::Relaxed),
                total: self.spec.runs,
                source: Box::new(source),
            },
        };
        let run = |&chunk: &u64| {
            let rows = self.rows_of(folder.runs_of(chunk), progress)?;
            let rows = rows.ok_or_else(|| CampaignError::Stopped {
                done: done.load(Ordering::Relaxed),
                total: self.spec.runs,
            })?;
            folder.keep(chunk, rows)?;
            let before = done.fetch_add(length(chunk), Ordering::Relaxed);
            report(before + length(chunk));
            Ok(())
        };
        parallel::map(&missing, run).map_err(unfinished)?;
        folder.join().map_err(unfinished)
    }
}

/// Opens or begins the campaign of a file in a folder.
///
/// # Errors
/// As [`Spec::read`], [`Spec::make_bank`] and [`Campaign::new`]; what is wrong with the folder.
pub fn prepare(
    spec_path: &Path,
    folder: &Path,
    progress: &dyn Progress,
) -> Result<(Campaign, Folder), CampaignError> {
    let spec = Spec::read(spec_path)?;
    let bank_text = match spec.bank_file(spec_path) {
        Some(path) => {
            Some(std::fs::read(&path).map_err(|source| CampaignError::SpecFile { path, source })?)
        }
        None => None,
    };
    let (folder, bank) = match open(folder, &spec, bank_text.as_deref())? {
        Found::Campaign(folder, bank) => (folder, *bank),
        Found::Empty(vacant) => {
            let bank = bank_of(&spec, spec_path, progress)?;
            vacant.begin(&spec, |path| match &bank_text {
                Some(text) => Ok(gt_log::write_atomically(path, text)?),
                None => Ok(gt_log::write_json(path, &bank)?),
            })?
        }
    };
    let campaign = Campaign::new(spec, bank).map_err(|error| named(error, spec_path))?;
    Ok((campaign, folder))
}

/// The campaign of a file, to run single runs of; a folder that has it lends its bank.
///
/// # Errors
/// As [`prepare`].
pub fn prepare_single(
    spec_path: &Path,
    folder: Option<&Path>,
    progress: &dyn Progress,
) -> Result<Campaign, CampaignError> {
    let spec = Spec::read(spec_path)?;
    let stored = match folder {
        Some(folder) => stored_bank(folder, &spec)?,
        None => None,
    };
    let bank = match stored {
        Some(bank) => bank,
        None => bank_of(&spec, spec_path, progress)?,
    };
    Campaign::new(spec, bank).map_err(|error| named(error, spec_path))
}

/// The bank of a specification, of its file or made.
fn bank_of(
    spec: &Spec,
    spec_path: &Path,
    progress: &dyn Progress,
) -> Result<DetectorFile, CampaignError> {
    match (&spec.bank, spec.bank_file(spec_path)) {
        (BankChoice::Tests(family), _) => {
            let bank = spec.make_bank(family, &spec.noise()?, progress)?;
            Ok(DetectorFile::Bank(bank))
        }
        (BankChoice::Isolator(family), _) => {
            let isolator = spec.make_isolator(*family, &spec.noise()?, progress)?;
            Ok(DetectorFile::Isolator(Box::new(isolator)))
        }
        (_, Some(path)) => Ok(DetectorFile::read(&path)?),
        (BankChoice::File(path), None) => Ok(DetectorFile::read(path)?),
    }
}

/// A refused value, with the file that it stands in.
fn named(error: CampaignError, path: &Path) -> CampaignError {
    match error {
        CampaignError::Value(problem) => CampaignError::Spec {
            path: path.to_owned(),
            problem,
        },
        error => error,
    }
}
