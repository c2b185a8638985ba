//! The options of `gtfdi design` that search for poles by pairs of records.

use std::path::{Path, PathBuf};

use gtfdi::core::Dataset;
use gtfdi::fdi::{Criterion, FdiError, PoleSearch, RecordPair, SearchError, SearchMethod};
use gtfdi::ident::{ArxModel, Missing};

use super::Healthy;
use super::pieces::pieces;
use crate::cli::{DesignArgs, GeneratorKind, PoleCriterion, PoleSearchKind};
use crate::failure::Failure;
use crate::output::{complain, number};
use crate::record::{parts, read_for, selection_for};

/// The share of equal values below which two records are hardly the same run: before its onset a
/// fault changes nothing, and two runs with other seeds may begin alike.
const TWIN_SHARE: f64 = 0.01;

/// The search that the options ask for; none without `--faulty`.
///
/// # Errors
/// An option of the search without `--faulty`, one that `--faulty` excludes, one out of its range,
/// or fewer healthy records than there are to pair.
pub fn search(args: &DesignArgs, generator: GeneratorKind) -> Result<Option<PoleSearch>, Failure> {
    let count = |paths: &Option<Vec<PathBuf>>| paths.as_ref().map_or(0, Vec::len);
    let (faulty, validating) = (count(&args.faulty), count(&args.validate_faulty));
    if faulty == 0 {
        let needing = [
            ("validate-faulty", validating > 0),
            ("criterion", args.criterion.is_some()),
            ("search", args.search.is_some()),
            ("radius", args.radius.is_some()),
            ("search-skip", args.search_skip.is_some()),
            ("search-seed", args.search_seed.is_some()),
        ];
        return match needing.iter().find(|(_, given)| *given) {
            Some((flag, _)) => Err(Failure::input(format!(
                "--{flag}: expected with --faulty, found no faulty record"
            ))),
            None => Ok(None),
        };
    }
    if generator == GeneratorKind::Kalman {
        return Err(Failure::input(
            "--faulty: expected with --generator observer, found kalman, which chooses its own poles",
        ));
    }
    if let Some(poles) = &args.poles {
        return Err(Failure::input(format!(
            "--poles: expected none with --faulty, which chooses them, found {}",
            poles.join(",")
        )));
    }
    check_counts(count(&args.healthy), faulty, validating)?;
    let criterion = match args.criterion {
        None | Some(PoleCriterion::FaultEnergy) => Criterion::FaultEnergy,
        Some(PoleCriterion::Paper) => Criterion::Paper,
    };
    if criterion == Criterion::Paper && faulty > 1 {
        return Err(Failure::input(format!(
            "--criterion: expected fault-energy with {faulty} records of --faulty, found paper, \
             which is that of 1"
        )));
    }
    let method = match args.search {
        None | Some(PoleSearchKind::Descent) => SearchMethod::Descent,
        Some(PoleSearchKind::Evolution) => SearchMethod::Evolution,
    };
    let defaults = PoleSearch::default();
    let search = PoleSearch {
        criterion,
        method,
        radius: args.radius.unwrap_or(defaults.radius),
        seed: args.search_seed.unwrap_or(defaults.seed),
        skip_samples: args.search_skip.unwrap_or(defaults.skip_samples),
        ..defaults
    };
    search.validate().map_err(|error| match error {
        FdiError::Option {
            option,
            expected,
            found,
        } => Failure::input(format!("--{option}: expected {expected}, found {found}")),
        error => Failure::input(error),
    })?;
    Ok(Some(search))
}

/// Refuses more records with faults than healthy ones that pair with them.
fn check_counts(healthy: usize, faulty: usize, validating: usize) -> Result<(), Failure> {
    if faulty > healthy {
        return Err(Failure::input(format!(
            "--faulty: expected no more records than --healthy, which pair with them, {healthy}, \
             found {faulty}"
        )));
    }
    let left = healthy - faulty;
    if validating > left {
        return Err(Failure::input(format!(
            "--validate-faulty: expected no more records than are left of --healthy after those that \
             pair with --faulty, {left}, found {validating}"
        )));
    }
    Ok(())
}

/// The records with faults: those of `--faulty`, then those of `--validate-faulty`.
pub struct Faulty<'a> {
    paths: Vec<&'a Path>,
    training: usize,
    records: Vec<Dataset>,
    /// What the user should know of them, as it was printed.
    pub warnings: Vec<String>,
}

impl<'a> Faulty<'a> {
    /// Reads the records as the healthy ones are, for the model in the file `model_path`.
    pub fn read(
        args: &'a DesignArgs,
        model: &ArxModel,
        model_path: &Path,
    ) -> Result<Self, Failure> {
        let rows = args.rows.as_ref().map(|rows| rows.0.clone());
        let wanted = selection_for(model, &args.reading, rows)?;
        let mut found = Self {
            paths: paths(args),
            training: args.faulty.as_ref().map_or(0, Vec::len),
            records: Vec::new(),
            warnings: Vec::new(),
        };
        for path in &found.paths {
            let read = read_for(path, &wanted, model_path, model.sample_time_s())?;
            found.warnings.extend(read.warnings);
            found.records.push(read.imported.dataset);
        }
        Ok(found)
    }

    /// The pairs to choose poles by and those to judge them by.
    pub fn pairs<'b>(
        &'b self,
        healthy: &'b [Dataset],
    ) -> (Vec<RecordPair<'b>>, Vec<RecordPair<'b>>) {
        let pairs = healthy.iter().zip(&self.records);
        let mut training: Vec<RecordPair> = pairs
            .map(|(healthy, faulty)| RecordPair { healthy, faulty })
            .collect();
        let validation = training.split_off(self.training);
        (training, validation)
    }

    /// Warns of records that have next to nothing in common with the healthy ones that they pair with.
    pub fn compare(&mut self, healthy: &[Dataset], healthy_paths: &[&Path]) {
        let pairs = healthy.iter().zip(healthy_paths);
        let mut warnings = Vec::new();
        for ((record, path), (healthy, healthy_path)) in
            self.records.iter().zip(&self.paths).zip(pairs)
        {
            let share = shared(healthy, record);
            if share >= TWIN_SHARE {
                continue;
            }
            let warning = format!(
                "{}: {} % of its values are those of {} at the same time: the two do not look like \
                 the same run with and without a fault, and their difference not like what the fault \
                 does",
                path.display(),
                number(Some(100.0 * share)),
                healthy_path.display()
            );
            warnings.push(warning);
        }
        for warning in warnings {
            self.warn(warning);
        }
    }

    /// Splits pairs where either record misses a sample, and healthy records without a partner where
    /// they do. Pieces of pairs of fewer samples than `shortest` are left out where there are others.
    ///
    /// # Errors
    /// An infinite sample, or no sample of all channels.
    pub fn split(&mut self, healthy: &mut Healthy<'a>, shortest: usize) -> Result<(), Failure> {
        let mut split = Healthy {
            paths: Vec::new(),
            records: Vec::new(),
            in_sample: Vec::new(),
            warnings: std::mem::take(&mut healthy.warnings),
        };
        let (mut paths, mut records, mut training) = (Vec::new(), Vec::new(), 0);
        for (index, whole) in healthy.records.iter().enumerate() {
            let path = healthy.paths[index];
            let mut take = |data: Dataset| {
                split.paths.push(path);
                split.in_sample.push(healthy.in_sample[index]);
                split.records.push(data);
            };
            let Some((own, faulty)) = self.paths.get(index).zip(self.records.get(index)) else {
                let parts = parts(path, whole.clone(), Missing::Break)?;
                parts.into_iter().for_each(take);
                continue;
            };
            for (left, right) in pieces(path, whole, (own, faulty), shortest)? {
                take(left);
                paths.push(*own);
                records.push(right);
                training += usize::from(index < self.training);
            }
        }
        (self.paths, self.records, self.training) = (paths, records, training);
        *healthy = split;
        Ok(())
    }

    /// Prints a warning and keeps it.
    pub fn warn(&mut self, warning: String) {
        complain(&format!("warning: {warning}"));
        self.warnings.push(warning);
    }

    /// A refusal of the search for the observer of `output` that names the option or file to blame.
    pub fn refused(&self, error: &FdiError, output: &str, healthy: &[&Path]) -> Failure {
        let position = |set: &str, pair: usize| {
            if set == "training" {
                pair
            } else {
                self.training + pair
            }
        };
        let blamed = match error {
            FdiError::Search(SearchError::Length { set, pair, .. }) => {
                self.paths.get(position(set, *pair))
            }
            FdiError::Search(SearchError::TooShort { set, pair, .. }) => {
                healthy.get(position(set, *pair))
            }
            FdiError::Search(SearchError::NotFinite {
                set, pair, record, ..
            }) => {
                let paths = if *record == "healthy" {
                    healthy
                } else {
                    &self.paths
                };
                paths.get(position(set, *pair))
            }
            FdiError::SampleTime { found_s, .. } => {
                let of = |data: &Dataset| data.sample_time_s().to_bits() == found_s.to_bits();
                let position = self.records.iter().position(of);
                position.and_then(|record| self.paths.get(record))
            }
            FdiError::Search(SearchError::Energy { set, .. }) => {
                let flag = if *set == "training" {
                    "faulty"
                } else {
                    "validate-faulty"
                };
                return Failure::input(format!("--{flag}: output `{output}`: {error}"));
            }
            _ => None,
        };
        match blamed {
            Some(path) => Failure::in_file(path, format!("output `{output}`: {error}")),
            None => Failure::input(format!("output `{output}`: {error}")),
        }
    }
}

/// The files of the records with faults, those of `--faulty` first.
pub fn paths(args: &DesignArgs) -> Vec<&Path> {
    let faulty = args.faulty.iter().chain(&args.validate_faulty).flatten();
    faulty.map(PathBuf::as_path).collect()
}

/// The share of values that are the same in both records.
fn shared(left: &Dataset, right: &Dataset) -> f64 {
    let sides = [(left.u(), right.u()), (left.y(), right.y())];
    // A sample a column: the same places hold the same channel and sample.
    let values = sides.into_iter().flat_map(|(l, r)| l.iter().zip(r.iter()));
    let (equal, all) = values.fold((0_usize, 0_usize), |(equal, all), (l, r)| {
        (equal + usize::from(l.to_bits() == r.to_bits()), all + 1)
    });
    equal as f64 / all as f64
}
