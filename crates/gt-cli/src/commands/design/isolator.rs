//! A design whose detector names faults.

use std::path::{Path, PathBuf};

use gt_campaign::{
    FaultDescription, FaultDescriptions, IsolatorPlan, PairRecords, joint_kalman_generator,
};
use gt_log::{ModelFile, write_json};
use gtfdi::fdi::{FaultEffect, FdiError, Isolator, MeanTime, ResidualGenerator, SUPPORTED_FACTOR};
use gtfdi::ident::Missing;
use gtfdi::ident::eiv::EivModel;
use serde::Serialize;

use super::generators::{chosen, parts};
use super::pieces::pieces;
use super::report::promised;
use super::{Healthy, parse_time_hours, read_healthy, refused};
use crate::Outcome;
use crate::cli::{DesignArgs, GeneratorKind, GlobalArgs, Statistic};
use crate::commands::SCHEMA_VERSION;
use crate::failure::Failure;
use crate::output::{complain, number, print, print_json, table};
use crate::record::{read_for, selection_for};

/// A hypothesis with its limit.
#[derive(Serialize)]
struct FaultReport<'a> {
    name: &'a str,
    unit: &'a str,
    both_signs: bool,
    effect: &'a FaultEffect,
    limit: f64,
    mean_time_between_false_alarms: MeanTime,
}

/// The result of the verb.
#[derive(Serialize)]
struct Report<'a> {
    schema_version: u32,
    generator: GeneratorKind,
    healthy_records: usize,
    /// Order of the joint autoregression that whitens the residuals.
    whitening_order: usize,
    settle_samples: usize,
    faults: Vec<FaultReport<'a>>,
    /// Of the statistic for a change in any direction.
    any_direction_limit: f64,
    any_direction_mean_time: MeanTime,
    warnings: Vec<String>,
    out: &'a Path,
}

/// What the verb works with, checked.
pub struct Work<'a> {
    pub args: &'a DesignArgs,
    pub global: &'a GlobalArgs,
    pub file: &'a ModelFile,
    pub noise: Option<&'a EivModel>,
    pub model_path: &'a Path,
    pub healthy_paths: &'a [&'a Path],
    pub faults_path: &'a Path,
    pub out: &'a Path,
}

/// Refuses options that say how the tests of a bank are made.
pub fn refuse_others(args: &DesignArgs) -> Result<(), Failure> {
    let given = [
        ("--statistic", args.statistic != Some(Statistic::Threshold)),
        ("--watch", args.watch.is_some()),
        ("--unknown", args.unknown.is_some()),
        ("--exceedance", args.exceedance.is_some()),
        ("--margin", args.margin.is_some()),
        ("--consecutive", args.consecutive.is_some()),
        ("--faulty", args.faulty.is_some()),
        ("--validate-faulty", args.validate_faulty.is_some()),
    ];
    match given.iter().find(|(_, given)| *given) {
        Some((option, _)) => Err(Failure::input(format!(
            "{option}: expected without --faults, whose likelihood ratios have limits by --arl0"
        ))),
        None => Ok(()),
    }
}

/// Refuses options that only an isolator has.
pub fn refuse_own(args: &DesignArgs) -> Result<(), Failure> {
    let given = [
        ("--confidence", args.confidence.is_some()),
        ("--longest", args.longest.is_some()),
        ("--limiter", args.limiter.is_some()),
    ];
    match given.iter().find(|(_, given)| *given) {
        Some((option, _)) => Err(Failure::input(format!(
            "{option}: expected with --faults, found none"
        ))),
        None => Ok(()),
    }
}

/// Reads the descriptions of the faults.
fn descriptions(path: &Path) -> Result<Vec<FaultDescription>, Failure> {
    let text = std::fs::read_to_string(path).map_err(|error| Failure::in_file(path, error))?;
    let described: FaultDescriptions =
        toml::from_str(&text).map_err(|error| Failure::in_file(path, error))?;
    described
        .check()
        .map_err(|error| Failure::in_file(path, error))?;
    Ok(described.faults)
}

fn plan(args: &DesignArgs) -> Result<IsolatorPlan, Failure> {
    let mut plan = IsolatorPlan {
        limiter: args.limiter,
        ..IsolatorPlan::default()
    };
    if let Some(time) = &args.arl0 {
        plan.arl0_hours = parse_time_hours("arl0", time)?;
    }
    if let Some(time) = &args.longest {
        plan.longest_s = 3600.0 * parse_time_hours("longest", time)?;
    }
    if let Some(confidence) = args.confidence {
        plan.confidence = confidence;
    }
    Ok(plan)
}

impl Work<'_> {
    /// Designs, writes and reports.
    pub fn run(&self) -> Result<Outcome, Failure> {
        let plan = plan(self.args)?;
        let described = descriptions(self.faults_path)?;
        let generator = self.args.generator.unwrap_or(GeneratorKind::Observer);
        let Healthy {
            paths: healthy_paths,
            records: healthy,
            mut warnings,
            ..
        } = read_healthy(
            self.args,
            self.file,
            self.model_path,
            self.healthy_paths,
            true,
        )?;
        let faults = described
            .into_iter()
            .map(|fault| {
                let records = self.pairs(&fault, &mut warnings)?;
                Ok((fault, records))
            })
            .collect::<Result<Vec<_>, Failure>>()?;
        let generators = match (generator, self.noise) {
            (GeneratorKind::Kalman, Some(noise)) => {
                let joint = joint_kalman_generator(noise);
                vec![joint.map_err(|error| Failure::in_file(self.model_path, error))?]
            }
            _ => self.generators(generator)?,
        };
        let name = match generator {
            GeneratorKind::Observer => "observers",
            GeneratorKind::Kalman => "filters",
        };
        let isolator = plan
            .design(name, generators, self.noise, &faults, &healthy)
            .map_err(|(fault, error)| self.refused(fault.as_deref(), &error, &healthy_paths))?;
        let unsupported: Vec<String> = unsupported(&isolator).collect();
        for warning in &unsupported {
            complain(&format!("warning: {warning}"));
        }
        warnings.extend(unsupported);
        write_json(self.out, &isolator).map_err(Failure::failed)?;
        let report = self.report(&isolator, generator, healthy.len(), warnings);
        if self.global.json {
            print_json(&report)?;
        } else {
            print(&text(&report))?;
        }
        Ok(Outcome::Done)
    }

    fn generators(&self, kind: GeneratorKind) -> Result<Vec<ResidualGenerator>, Failure> {
        let model = &self.file.model;
        let parts = parts(model).map_err(|error| Failure::in_file(self.model_path, error))?;
        let wishes = self.args.poles.clone().unwrap_or_default();
        let found = chosen(kind, model, self.noise, parts, &wishes)?
            .map_err(|(name, error)| refused(&error, self.args, &name, self.healthy_paths, &[]))?;
        Ok(found.generators)
    }

    /// The records of a fault's pairs; paths are beside the file of faults.
    fn pairs(
        &self,
        fault: &FaultDescription,
        warnings: &mut Vec<String>,
    ) -> Result<Vec<PairRecords>, Failure> {
        let model = &self.file.model;
        let wanted = selection_for(model, &self.args.reading, None)?;
        let folder = self.faults_path.parent().unwrap_or(Path::new(""));
        let mut read = |path: &PathBuf| {
            let path = folder.join(path);
            let read = read_for(&path, &wanted, self.model_path, model.sample_time_s())?;
            warnings.extend(read.warnings);
            Ok::<_, Failure>(read.imported.dataset)
        };
        let breaks = wanted.missing == Missing::Break;
        let mut pairs = Vec::new();
        for pair in &fault.pairs {
            let (healthy, faulty) = (read(&pair.healthy)?, read(&pair.faulty)?);
            if healthy.len() != faulty.len() {
                return Err(Failure::in_file(
                    &folder.join(&pair.faulty),
                    format!(
                        "fault `{}`: expected the {} samples of {}, found {}",
                        fault.name,
                        healthy.len(),
                        pair.healthy.display(),
                        faulty.len()
                    ),
                ));
            }
            let records = if breaks {
                let path = folder.join(&pair.healthy);
                let other = folder.join(&pair.faulty);
                pieces(&path, &healthy, (&other, &faulty), model.max_lag() + 2)?
            } else {
                vec![(healthy, faulty)]
            };
            pairs.extend(records.into_iter().map(|(healthy, faulty)| PairRecords {
                sizes: pair.sizes(&faulty),
                healthy,
                faulty,
            }));
        }
        Ok(pairs)
    }

    /// A refusal that names the fault, the option or the file to blame.
    fn refused(&self, fault: Option<&str>, error: &FdiError, healthy: &[&Path]) -> Failure {
        if let Some(fault) = fault {
            return Failure::in_file(self.faults_path, format!("fault `{fault}`: {error}"));
        }
        match error {
            FdiError::Hypothesis { .. } | FdiError::MissingTags { .. } => {
                Failure::in_file(self.faults_path, error)
            }
            FdiError::Option { option, .. } => {
                let flag = match *option {
                    "arl0_hours" => "arl0",
                    "longest_s" => "longest",
                    option => option,
                };
                Failure::input(format!("--{flag}: {error}"))
            }
            FdiError::HealthySamples { record, .. } => match healthy.get(*record) {
                Some(path) => Failure::in_file(path, error),
                None => Failure::input(error),
            },
            error => Failure::input(format!("--healthy: {error}")),
        }
    }

    fn report<'a>(
        &'a self,
        isolator: &'a Isolator,
        generator: GeneratorKind,
        healthy_records: usize,
        warnings: Vec<String>,
    ) -> Report<'a> {
        let last = isolator.hypotheses().len();
        let limits = isolator.limits().iter().zip(isolator.mean_times());
        Report {
            schema_version: SCHEMA_VERSION,
            generator,
            healthy_records,
            whitening_order: isolator.whitening().order(),
            settle_samples: isolator.settle_samples(),
            faults: isolator
                .hypotheses()
                .iter()
                .zip(limits)
                .map(|(own, (limit, mean_time))| FaultReport {
                    name: &own.name,
                    unit: &own.unit,
                    both_signs: own.both_signs,
                    effect: &own.effect,
                    limit: *limit,
                    mean_time_between_false_alarms: *mean_time,
                })
                .collect(),
            any_direction_limit: isolator.limits()[last],
            any_direction_mean_time: isolator.mean_times()[last],
            warnings,
            out: self.out,
        }
    }
}

/// What to say where the healthy records do not support the promise.
fn unsupported(isolator: &Isolator) -> impl Iterator<Item = String> {
    let weakest = isolator
        .mean_times()
        .iter()
        .filter(|own| !own.supported())
        .max_by(|left, right| {
            let needed = |own: &MeanTime| own.healthy_hours_needed;
            needed(left).total_cmp(&needed(right))
        });
    weakest.into_iter().map(|own| {
        format!(
            "{} h of healthy running do not support a mean time between false alarms of {} h for \
             each statistic: {} h would, to within a factor of {SUPPORTED_FACTOR}",
            number(Some(own.healthy_hours)),
            number(Some(own.asked_hours)),
            number(Some(own.healthy_hours_needed)),
        )
    })
}

fn text(report: &Report) -> String {
    let mut rows: Vec<Vec<String>> = report
        .faults
        .iter()
        .map(|fault| {
            let what = match fault.effect {
                FaultEffect::Outputs { changes, .. } => changes
                    .iter()
                    .map(|(tag, change)| format!("{tag} {}", number(Some(*change))))
                    .collect::<Vec<_>>()
                    .join(", "),
                FaultEffect::ActuatorLag { input, gain, .. } => {
                    format!("lag of {input}, gain {}", number(Some(*gain)))
                }
            };
            vec![
                fault.name.to_owned(),
                fault.unit.to_owned(),
                what,
                number(Some(fault.limit)),
                promised(&fault.mean_time_between_false_alarms),
            ]
        })
        .collect();
    rows.push(vec![
        "any other".to_owned(),
        String::new(),
        String::new(),
        number(Some(report.any_direction_limit)),
        promised(&report.any_direction_mean_time),
    ]);
    format!(
        "{}: {} faults, limits from {} healthy records\n{}",
        report.out.display(),
        report.faults.len(),
        report.healthy_records,
        table(
            &[
                "fault",
                "unit",
                "changes for one unit",
                "limit",
                "hours between false alarms"
            ],
            &rows
        )
    )
}
