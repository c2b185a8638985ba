//! `gtfdi design`: a model and healthy records to a bank of detectors.

use std::path::{Path, PathBuf};

use gt_log::{ModelFile, read_json, write_json};
use gtfdi::core::Dataset;
use gtfdi::fdi::{
    Bank, FalseAlarmRate, FdiError, OutputDetector, ResidualGenerator, ThresholdRule,
};
use serde::Serialize;

use super::SCHEMA_VERSION;
use super::poles::{check_tags, poles};
use crate::Outcome;
use crate::cli::{DesignArgs, GeneratorKind, GlobalArgs, Statistic};
use crate::config::layered;
use crate::failure::Failure;
use crate::output::{complain, number, print, print_json, table};
use crate::record::{check_out, read_for, selection_for};

/// The bank's name, part of its topics in a log.
const BANK_NAME: &str = "observers";

#[derive(Serialize)]
struct DetectorReport<'a> {
    output: &'a str,
    poles: &'a [f64],
    limit: f64,
    consecutive: usize,
    settle_samples: usize,
    exceedance_share_cross_validated: f64,
    false_alarms_in_sample: FalseAlarmRate,
    false_alarms_cross_validated: FalseAlarmRate,
}

#[derive(Serialize)]
struct Report<'a> {
    schema_version: u32,
    generator: GeneratorKind,
    statistic: Statistic,
    healthy_records: usize,
    detectors: Vec<DetectorReport<'a>>,
    warnings: Vec<String>,
    out: &'a Path,
}

fn rule(args: &DesignArgs) -> Result<ThresholdRule, Failure> {
    let given = |default: usize| args.consecutive.unwrap_or(default);
    let rule = match (args.exceedance, &args.arl0) {
        (Some(share), _) => ThresholdRule::Exceedance {
            share,
            consecutive: given(6),
        },
        (None, Some(time)) => ThresholdRule::MeanTimeBetweenFalseAlarms {
            hours: parse_hours(time)?,
            consecutive: given(1),
        },
        (None, None) => ThresholdRule::Margin {
            factor: args.margin.unwrap_or(ThresholdRule::DEFAULT_MARGIN),
            consecutive: given(1),
        },
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

/// A time span such as `24h`, `30min`, `90s` or `2d`, in hours.
fn parse_hours(text: &str) -> Result<f64, Failure> {
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
                "--arl0: expected a positive time such as 24h, 30min or 90s, found `{text}`"
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
        FdiError::PoleCount { .. } | FdiError::PoleOutside { .. } => {
            return Failure::input(format!("--poles: output `{output}`: {error}"));
        }
        FdiError::HealthyTotal { share, .. } => {
            return Failure::input(format!("--exceedance {share}: {error}"));
        }
        FdiError::HealthyHours { .. } => {
            let time = args.arl0.as_deref().unwrap_or_default();
            return Failure::input(format!("--arl0 {time}: {error}"));
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

/// Runs the verb.
pub fn run(args: &DesignArgs, global: &GlobalArgs) -> Result<Outcome, Failure> {
    let defaults = DesignArgs {
        generator: Some(GeneratorKind::Observer),
        statistic: Some(Statistic::Threshold),
        ..DesignArgs::default()
    };
    let Some(args) = layered("design", args, &defaults, global)? else {
        return Ok(Outcome::Done);
    };
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
    let rule = rule(&args)?;
    check_out(out, &[&[model_path.as_path()], &healthy_paths[..]].concat())?;
    let model = read_json::<ModelFile>(model_path)
        .map_err(Failure::input)?
        .model;
    let wishes = args.poles.clone().unwrap_or_default();
    check_tags(&wishes, model.outputs(), model_path)?;

    let rows = args.rows.as_ref().map(|rows| rows.0.clone());
    let wanted = selection_for(&model, &args.reading, rows);
    let mut healthy: Vec<Dataset> = Vec::new();
    let mut warnings = Vec::new();
    for path in &healthy_paths {
        let read = read_for(path, &wanted, model_path, model.sample_time_s())?;
        healthy.push(read.imported.dataset);
        warnings.extend(read.warnings);
    }
    let mut detectors = Vec::new();
    for (index, output) in model.outputs().iter().enumerate() {
        let part = model
            .output_model(index)
            .map_err(|e| Failure::in_file(model_path, e))?;
        let poles = poles(&wishes, &output.name, part.model.nx())?;
        let detector = ResidualGenerator::observer(part.model, part.point, &poles)
            .and_then(|generator| OutputDetector::calibrate(generator, &healthy, rule))
            .map_err(|error| refused(&error, &args, &output.name, &healthy_paths, &healthy))?;
        if let Some(warning) = useless(&detector, index, &healthy) {
            complain(&format!("warning: {warning}"));
            warnings.push(warning);
        }
        detectors.push(detector);
    }
    let bank = Bank::new(BANK_NAME, detectors).map_err(Failure::input)?;
    write_json(out, &bank).map_err(Failure::failed)?;
    let report = Report {
        schema_version: SCHEMA_VERSION,
        generator: GeneratorKind::Observer,
        statistic: Statistic::Threshold,
        healthy_records: healthy.len(),
        detectors: bank.detectors().iter().map(detector_report).collect(),
        warnings,
        out,
    };
    if global.json {
        print_json(&report)?;
    } else {
        print(&text(&report))?;
    }
    Ok(Outcome::Done)
}

/// What to say of a limit beyond everything that the output, row `index` of the records, did.
fn useless(detector: &OutputDetector, index: usize, healthy: &[Dataset]) -> Option<String> {
    let (name, limit) = (detector.name(), detector.threshold.limit);
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

fn detector_report(detector: &OutputDetector) -> DetectorReport<'_> {
    let rates = &detector.false_alarms;
    DetectorReport {
        output: detector.name(),
        poles: detector.generator.poles(),
        limit: detector.threshold.limit,
        consecutive: detector.threshold.consecutive,
        settle_samples: detector.generator.settle_samples(),
        exceedance_share_cross_validated: rates.cross_validated_exceedance_share,
        false_alarms_in_sample: rates.in_sample,
        false_alarms_cross_validated: rates.cross_validated,
    }
}

fn text(report: &Report) -> String {
    let rows: Vec<Vec<String>> = report
        .detectors
        .iter()
        .map(|detector| {
            let rate = &detector.false_alarms_cross_validated;
            vec![
                detector.output.to_owned(),
                number(Some(detector.limit)),
                detector.consecutive.to_string(),
                number(Some(100.0 * detector.exceedance_share_cross_validated)),
                format!("{} in {} h", rate.alarms, number(Some(rate.hours))),
                format!(
                    "{} ({} .. {})",
                    number(Some(rate.per_hour)),
                    number(Some(rate.per_hour_low)),
                    number(Some(rate.per_hour_high))
                ),
            ]
        })
        .collect();
    format!(
        "{}: {} detectors from {} healthy records; rates are cross-validated, with 95 % intervals\n{}",
        report.out.display(),
        report.detectors.len(),
        report.healthy_records,
        table(
            &[
                "output",
                "limit",
                "in a row",
                "above limit %",
                "false alarms",
                "per hour"
            ],
            &rows
        )
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn spans_of_time_carry_their_unit() {
        for (text, hours) in [("24h", 24.0), ("30min", 0.5), ("90 s", 0.025), ("2d", 48.0)] {
            let found = parse_hours(text).expect(text);
            // One product and one quotient by 60 or 3600.
            assert!((found - hours).abs() < 1e-15 * hours, "{text}: {found}");
        }
        for bad in ["24", "h", "-1h", "0h", "nanh", "1 fortnight"] {
            assert!(parse_hours(bad).is_err(), "{bad} accepted");
        }
    }
}
