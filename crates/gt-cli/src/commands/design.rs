//! `gtfdi design`: a model and healthy records to a bank of detectors.

use std::path::Path;

use gt_campaign::paper;
use gt_log::{ModelFile, read_json, write_json};
use gtfdi::core::Dataset;
use gtfdi::fdi::{Bank, FalseAlarmRate, OutputDetector, ResidualGenerator, ThresholdRule};
use serde::Serialize;

use super::SCHEMA_VERSION;
use super::identify::{read, selection};
use crate::Outcome;
use crate::cli::{DesignArgs, GeneratorKind, GlobalArgs, Statistic};
use crate::config::layered;
use crate::failure::Failure;
use crate::output::{number, print, print_json, table};

/// The bank's name, part of its topics in a log.
const BANK_NAME: &str = "observers";
/// The pole of every state where neither the options nor the paper say one.
const DEFAULT_POLE: f64 = 0.5;

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
    out: &'a Path,
}

fn rule(args: &DesignArgs) -> Result<ThresholdRule, Failure> {
    let given = |default: usize| args.consecutive.unwrap_or(default);
    Ok(match (args.exceedance, args.margin, &args.arl0) {
        (_, Some(factor), _) => ThresholdRule::Margin {
            factor,
            consecutive: given(1),
        },
        (_, _, Some(time)) => ThresholdRule::MeanTimeBetweenFalseAlarms {
            hours: parse_hours(time)?,
            consecutive: given(1),
        },
        (share, None, None) => ThresholdRule::Exceedance {
            share: share.unwrap_or(0.01),
            consecutive: given(6),
        },
    })
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

/// The poles of one output's observer with `nx` states.
fn poles(wishes: &[String], output: &str, nx: usize) -> Result<Vec<f64>, Failure> {
    let number = |text: &str| {
        text.trim().parse::<f64>().map_err(|_| {
            Failure::input(format!(
                "--poles: expected a number or TAG=NUMBER, found `{text}`"
            ))
        })
    };
    let mut common = Vec::new();
    for wish in wishes {
        match wish.split_once('=') {
            Some((tag, value)) if tag.trim() == output => return Ok(vec![number(value)?; nx]),
            Some((_, value)) => drop(number(value)?),
            None => common.push(number(wish)?),
        }
    }
    match common.len() {
        0 => Ok(vec![
            paper::observer_pole(output).unwrap_or(DEFAULT_POLE);
            nx
        ]),
        1 => Ok(vec![common[0]; nx]),
        found if found == nx => Ok(common),
        found => Err(Failure::input(format!(
            "--poles: output `{output}` has {nx} states: expected 1 or {nx} poles, found {found}"
        ))),
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
    let rule = rule(&args)?;
    let model = read_json::<ModelFile>(model_path)
        .map_err(Failure::input)?
        .model;
    let wishes = args.poles.clone().unwrap_or_default();
    for tag in wishes
        .iter()
        .filter_map(|wish| wish.split_once('='))
        .map(|(tag, _)| tag.trim())
    {
        if !model.outputs().iter().any(|output| output.name == tag) {
            return Err(Failure::input(format!(
                "--poles: `{tag}` is not an output of {}",
                model_path.display()
            )));
        }
    }

    let names = |signals: &[gtfdi::core::Signal]| {
        signals
            .iter()
            .map(|signal| signal.name.clone())
            .collect::<Vec<_>>()
    };
    let mut healthy: Vec<Dataset> = Vec::new();
    for path in args.healthy.iter().flatten() {
        let rows = args.rows.as_ref().map(|rows| rows.0.clone());
        let wanted = selection(
            names(model.inputs()),
            names(model.outputs()),
            &args.reading,
            rows,
        );
        healthy.push(read(path, &wanted)?.dataset);
    }
    let mut detectors = Vec::new();
    for (index, output) in model.outputs().iter().enumerate() {
        let part = model
            .output_model(index)
            .map_err(|e| Failure::in_file(model_path, e))?;
        let poles = poles(&wishes, &output.name, part.model.nx())?;
        let generator =
            ResidualGenerator::observer(part.model, part.point, &poles).map_err(Failure::input)?;
        let detector =
            OutputDetector::calibrate(generator, &healthy, rule).map_err(Failure::input)?;
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
        out,
    };
    if global.json {
        print_json(&report)?;
    } else {
        print(&text(&report))?;
    }
    Ok(Outcome::Done)
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
            assert_eq!(parse_hours(text).expect(text), hours);
        }
        for bad in ["24", "h", "-1h", "0h", "nanh", "1 fortnight"] {
            assert!(parse_hours(bad).is_err(), "{bad} accepted");
        }
    }

    #[test]
    fn poles_by_tag_win_over_common_ones() {
        let wishes = ["0.6".to_owned(), "t3=0.3".to_owned()];
        assert_eq!(poles(&wishes, "t3", 2).expect("by tag"), [0.3, 0.3]);
        assert_eq!(poles(&wishes, "p7", 2).expect("common"), [0.6, 0.6]);
        assert_eq!(poles(&[], "q_c", 1).expect("the paper's"), [0.7]);
        let error = poles(&["0.1".into(), "0.2".into()], "y", 3).expect_err("two of three");
        assert_eq!(
            error.error().to_string(),
            "--poles: output `y` has 3 states: expected 1 or 3 poles, found 2"
        );
    }
}
