//! `gtfdi design`: a model and healthy records to a bank of generators and tests.

mod generators;
mod isolator;
mod optimisation;
mod pieces;
mod poles;
mod report;
mod search;
mod statistic;

use std::path::{Path, PathBuf};

use gt_campaign::{TestPlan, Watch, in_sample_optimism};
use gt_log::{ModelFile, read_json, write_json};
use gtfdi::core::Dataset;
use gtfdi::fdi::{Bank, FdiError, ObserverDesign, ResidualTest, StatisticError, ThresholdRule};
use gtfdi::ident::{ArxModel, Missing};

use self::generators::{Found, chosen, found_by, parts, without};
use self::optimisation::output_reports;
use self::poles::check_tags;
use self::report::{Report, test_reports, text, unsupported};
use self::search::{Faulty, search};
use super::SCHEMA_VERSION;
use crate::Outcome;
use crate::cli::{DesignArgs, GeneratorKind, GlobalArgs, MissingSamples, Statistic, WatchKind};
use crate::config::layered;
use crate::failure::Failure;
use crate::output::{complain, number, print, print_json};
use crate::record::{check_out, parts as parts_of, read_for, selection_for};

/// Allowances for residuals of a model's own record beyond this are told.
const NOTABLE_OPTIMISM: f64 = 1.02;

fn rule(args: &DesignArgs) -> Result<ThresholdRule, Failure> {
    let given = |default: usize| args.consecutive.unwrap_or(default);
    let rule = match (args.exceedance, &args.arl0) {
        (Some(share), _) => ThresholdRule::Exceedance {
            share,
            consecutive: given(6),
        },
        (None, Some(time)) => ThresholdRule::MeanTimeBetweenFalseAlarms {
            hours: parse_time_hours("arl0", time)?,
            consecutive: given(1),
        },
        (None, None) => args.margin.map_or_else(
            || statistic::name(args.statistic).default_rule(given(1)),
            |factor| ThresholdRule::Margin {
                factor,
                consecutive: given(1),
            },
        ),
    };
    rule.validate().map_err(|error| match error {
        FdiError::Option {
            option,
            expected,
            found,
        } => {
            let flag = match option {
                "share" => "exceedance",
                "factor" => "margin",
                "hours" => "arl0",
                option => option,
            };
            Failure::input(format!("--{flag}: expected {expected}, found {found}"))
        }
        error => Failure::input(error),
    })?;
    Ok(rule)
}

fn plan(args: &DesignArgs) -> Result<TestPlan, Failure> {
    Ok(TestPlan {
        statistic: statistic::statistic(args)?,
        rule: rule(args)?,
        watch: match args.watch {
            None | Some(WatchKind::Outputs) => Watch::Outputs,
            Some(WatchKind::Joint) => Watch::Joint,
            Some(WatchKind::Both) => Watch::Both,
        },
    })
}

/// The time span of an option, such as `24h`, `30min`, `90s` or `2d`, in hours.
fn parse_time_hours(option: &str, text: &str) -> Result<f64, Failure> {
    let units = [
        ("min", 1.0 / 60.0),
        ("h", 1.0),
        ("s", 1.0 / 3600.0),
        ("d", 24.0),
    ];
    units
        .iter()
        .find_map(|(unit, hours)| {
            let value: f64 = text.trim().strip_suffix(unit)?.trim().parse().ok()?;
            (value.is_finite() && value > 0.0).then_some(value * hours)
        })
        .ok_or_else(|| {
            Failure::input(format!(
                "--{option}: expected a positive time such as 24h, 30min or 90s, found `{text}`"
            ))
        })
}

/// A refusal of the design for `output` that names the option or the file to blame.
fn refused(
    error: &FdiError,
    args: &DesignArgs,
    output: &str,
    paths: &[&Path],
    healthy: &[Dataset],
) -> Failure {
    let record = match error {
        FdiError::PoleCount { .. } | FdiError::PoleOutside { .. } | FdiError::Placement(_) => {
            return Failure::input(format!("--poles: output `{output}`: {error}"));
        }
        FdiError::HealthyTotal { share, .. } => {
            return Failure::input(format!("--exceedance {share}: {error}"));
        }
        FdiError::HealthyHours { .. } => {
            let time = args.arl0.as_deref().unwrap_or_default();
            return Failure::input(format!("--arl0 {time}: {error}"));
        }
        FdiError::Statistic(StatisticError::Window { .. }) => {
            return Failure::input(format!("--window: {error}"));
        }
        FdiError::HealthySamples { record, .. } => Some(*record),
        FdiError::SampleTime { found_s, .. } => healthy
            .iter()
            .position(|data| data.sample_time_s().to_bits() == found_s.to_bits()),
        _ => None,
    };
    match record.and_then(|record| paths.get(record)) {
        Some(path) => Failure::in_file(path, format!("output `{output}`: {error}")),
        None => Failure::input(format!("output `{output}`: {error}")),
    }
}

/// What must be given.
struct Asked<'a> {
    model_path: &'a PathBuf,
    out: &'a PathBuf,
    healthy_paths: Vec<&'a Path>,
    generator: GeneratorKind,
}

/// What is given, where nothing is missing and no two options exclude each other.
fn asked(args: &DesignArgs) -> Result<Asked<'_>, Failure> {
    let model_path = args
        .model
        .as_ref()
        .ok_or_else(|| Failure::missing("--model", "--model model.json"))?;
    let out = args
        .out
        .as_ref()
        .ok_or_else(|| Failure::missing("--out", "--out bank.json"))?;
    let healthy_paths: Vec<&Path> = args
        .healthy
        .iter()
        .flatten()
        .map(PathBuf::as_path)
        .collect();
    if healthy_paths.is_empty() {
        return Err(Failure::missing("--healthy", "--healthy run.csv"));
    }
    let generator = args.generator.unwrap_or(GeneratorKind::Observer);
    if generator == GeneratorKind::Kalman && args.poles.is_some() {
        return Err(Failure::input(
            "--poles: expected with --generator observer, found kalman, which chooses its own",
        ));
    }
    if args.unknown.is_some() && generator != GeneratorKind::Kalman {
        return Err(Failure::input(
            "--unknown: expected with --generator kalman, found observer",
        ));
    }
    match &args.faults {
        Some(_) => isolator::refuse_others(args)?,
        None => isolator::refuse_own(args)?,
    }
    Ok(Asked {
        model_path,
        out,
        healthy_paths,
        generator,
    })
}

/// Runs the verb.
pub fn run(args: &DesignArgs, global: &GlobalArgs) -> Result<Outcome, Failure> {
    let Some(mut args) = layered("design", args, global)? else {
        return Ok(Outcome::Done);
    };
    args.unknown = args.unknown.filter(|unknown| !unknown.is_empty());
    let Asked {
        model_path,
        out,
        healthy_paths,
        generator,
    } = asked(&args)?;
    let search = search(&args, generator)?;
    let plan = plan(&args)?;
    let faulty_paths = search::paths(&args);
    let faults: Vec<&Path> = args.faults.iter().map(PathBuf::as_path).collect();
    let inputs = [
        &[model_path.as_path()],
        &healthy_paths[..],
        &faulty_paths,
        &faults,
    ];
    check_out(out, &inputs.concat())?;
    let file = read_json::<ModelFile>(model_path).map_err(Failure::input)?;
    let noise = file.eiv().map_err(|e| Failure::in_file(model_path, e))?;
    let model = &file.model;
    let wishes = args.poles.clone().unwrap_or_default();
    check_tags(&wishes, model.outputs(), model_path)?;

    if let Some(faults_path) = &args.faults {
        let work = isolator::Work {
            args: &args,
            global,
            file: &file,
            noise: noise.as_ref(),
            model_path,
            healthy_paths: &healthy_paths,
            faults_path,
            out,
        };
        return work.run();
    }
    // With --faulty they are pairs, and split together.
    let splits = search.is_none();
    let mut healthy = read_healthy(&args, &file, model_path, &healthy_paths, splits)?;
    let faulty = match &search {
        Some(search) => {
            let faulty = read_faulty(&args, search.skip_samples, model, model_path, &mut healthy)?;
            Some((search, faulty))
        }
        None => None,
    };
    let Healthy {
        paths: healthy_paths,
        records: healthy,
        in_sample,
        mut warnings,
    } = healthy;
    let parts = parts(model).map_err(|error| Failure::in_file(model_path, error))?;
    let Found {
        generators,
        searched,
    } = match (faulty, &args.unknown) {
        (_, Some(unknown)) => without(unknown, model, noise.as_ref(), model_path)?,
        (Some((search, mut faulty)), None) => {
            let found = found_by(search, parts, &mut faulty, &healthy, &healthy_paths)?;
            warnings.append(&mut faulty.warnings);
            found
        }
        (None, None) => chosen(generator, model, noise.as_ref(), parts, &wishes)?
            .map_err(|(name, error)| refused(&error, &args, &name, &healthy_paths, &healthy))?,
    };
    let tests = plan
        .tests(model, &generators, &healthy, &in_sample)
        .map_err(|(name, error)| refused(&error, &args, &name, &healthy_paths, &healthy))?;
    let useless = tests
        .iter()
        .filter_map(|test| useless(test, model, &searched, &healthy));
    let found: Vec<String> = useless
        .chain(tests.iter().filter_map(unsupported))
        .collect();
    for warning in &found {
        complain(&format!("warning: {warning}"));
    }
    warnings.extend(found);
    let bank = Bank::new(bank_name(generator), generators, tests).map_err(Failure::input)?;
    write_json(out, &bank).map_err(Failure::failed)?;
    let report = Report {
        schema_version: SCHEMA_VERSION,
        generator,
        statistic: args.statistic.unwrap_or(Statistic::Threshold),
        healthy_records: healthy.len(),
        unknown: args.unknown.as_deref().unwrap_or_default(),
        outputs: output_reports(model, &searched),
        detectors: test_reports(&bank),
        warnings,
        out,
    };
    tell(&report, global)?;
    Ok(Outcome::Done)
}

fn tell(report: &Report, global: &GlobalArgs) -> Result<(), Failure> {
    if global.json {
        print_json(report)
    } else {
        print(&text(report))
    }
}

/// The faulty records of the healthy ones, split with them where samples are missing and that is how
/// they are taken.
fn read_faulty<'a>(
    args: &'a DesignArgs,
    skip_samples: usize,
    model: &ArxModel,
    model_path: &'a Path,
    healthy: &mut Healthy<'a>,
) -> Result<Faulty<'a>, Failure> {
    let mut faulty = Faulty::read(args, model, model_path)?;
    faulty.compare(&healthy.records, &healthy.paths);
    if args.reading.missing == Some(MissingSamples::Break) {
        let shortest = skip_samples + 2 * model.max_lag() + 1;
        faulty.split(healthy, shortest)?;
    }
    Ok(faulty)
}

/// Healthy records.
struct Healthy<'a> {
    /// The file of each.
    paths: Vec<&'a Path>,
    records: Vec<Dataset>,
    /// Whether the model was identified from each.
    in_sample: Vec<bool>,
    warnings: Vec<String>,
}

/// Reads them; where they are split, samples that may be missing end one record and begin another.
fn read_healthy<'a>(
    args: &DesignArgs,
    file: &ModelFile,
    model_path: &Path,
    paths: &[&'a Path],
    splits: bool,
) -> Result<Healthy<'a>, Failure> {
    let model = &file.model;
    let rows = args.rows.as_ref().map(|rows| rows.0.clone());
    let wanted = selection_for(model, &args.reading, rows)?;
    let optimism = in_sample_optimism(model).into_iter().fold(1.0, f64::max);
    let mut healthy = Healthy {
        paths: Vec::new(),
        records: Vec::new(),
        in_sample: Vec::new(),
        warnings: Vec::new(),
    };
    for path in paths {
        let read = read_for(path, &wanted, model_path, model.sample_time_s())?;
        let own = file.input_sha256.as_ref() == Some(&read.imported.sha256);
        healthy.warnings.extend(read.warnings);
        if own && optimism > NOTABLE_OPTIMISM {
            let warning = format!(
                "{}: the model was identified from this record, whose residuals are smaller than \
                 those of any other: they count up to {} times; another healthy record would need \
                 no such allowance",
                path.display(),
                number(Some(optimism))
            );
            complain(&format!("warning: {warning}"));
            healthy.warnings.push(warning);
        }
        let whole = read.imported.dataset;
        let missing = if splits {
            wanted.missing
        } else {
            Missing::Refuse
        };
        let parts = parts_of(path, whole, missing)?;
        for part in parts {
            healthy.paths.push(path);
            healthy.in_sample.push(own);
            healthy.records.push(part);
        }
    }
    Ok(healthy)
}

/// The bank's name, part of its topics in a log.
fn bank_name(generator: GeneratorKind) -> &'static str {
    match generator {
        GeneratorKind::Observer => "observers",
        GeneratorKind::Kalman => "filters",
    }
}

/// What to say of a limit on the residual as it is beyond everything that its output did. Where
/// poles were searched, the criterion says how the fault stands out of what they amplify.
fn useless(
    test: &ResidualTest,
    model: &ArxModel,
    searched: &[Option<ObserverDesign>],
    healthy: &[Dataset],
) -> Option<String> {
    if test.evaluation.whitening.is_some() {
        return None;
    }
    let outputs = model.outputs().iter();
    let index = outputs
        .map(|signal| &signal.name)
        .position(|name| *name == test.name)?;
    if searched.get(index).is_some_and(Option::is_some) {
        return None;
    }
    let (name, limit) = (&test.name, test.threshold.limit);
    let values = healthy.iter().map(|data| data.y().row(index));
    let high = values.clone().map(|row| row.max()).fold(f64::MIN, f64::max);
    let low = values.map(|row| row.min()).fold(f64::MAX, f64::min);
    (limit > high - low).then(|| {
        format!(
            "`{name}`: the limit {} is beyond the output's whole healthy range {}: slower poles \
             amplify the model's error, faster ones (nearer 0) do not",
            number(Some(limit)),
            number(Some(high - low))
        )
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn spans_of_time_carry_their_unit() {
        for (text, hours) in [("24h", 24.0), ("30min", 0.5), ("90 s", 0.025), ("2d", 48.0)] {
            let found = parse_time_hours("arl0", text).expect(text);
            // One product and one quotient by 60 or 3600.
            assert!((found - hours).abs() < 1e-15 * hours, "{text}: {found}");
        }
        for bad in ["24", "h", "-1h", "0h", "nanh", "1 fortnight"] {
            assert!(parse_time_hours("arl0", bad).is_err(), "{bad} accepted");
        }
    }
}
