//! `gtfdi detect`: a bank or an isolator over a record.

mod isolator;

use std::path::Path;

use gt_campaign::reports::detection_report;
use gt_log::{DetectorFile, Imported, Resampled, RunMetadata, write_verdicts};
use gtfdi::fdi::{Alarm, Bank, FalseAlarmRate, MeanTime, StatisticKind};
use serde::Serialize;

use super::SCHEMA_VERSION;
use super::report_folder::{check_folder, provenance, write_report};
use crate::Outcome;
use crate::cli::{DetectArgs, FailOn, GlobalArgs};
use crate::config::layered;
use crate::failure::Failure;
use crate::output::{complain, number, print, print_json, table};
use crate::record::{Read, check_out, read_for, selection};

/// An alarm with every key that a verdict will have; what is not computed yet is null.
#[derive(Serialize)]
struct AlarmReport<'a> {
    time_s: f64,
    first_exceedance_s: f64,
    end_s: Option<f64>,
    fault: Option<&'a str>,
    tag: &'a str,
    statistic: f64,
    threshold: f64,
    onset_s: Option<f64>,
    magnitude: Option<f64>,
    probability: Option<f64>,
}

#[derive(Serialize)]
struct OutputReport<'a> {
    name: &'a str,
    statistic: &'a StatisticKind,
    threshold: f64,
    consecutive: usize,
    judged_samples: usize,
    exceedance_share: Option<f64>,
    alarms: usize,
    false_alarms_per_hour: FalseAlarmRate,
    mean_time_between_false_alarms: Option<MeanTime>,
}

#[derive(Serialize)]
struct Report<'a> {
    schema_version: u32,
    samples: usize,
    sample_time_s: f64,
    alarms: Vec<AlarmReport<'a>>,
    outputs: Vec<OutputReport<'a>>,
    /// Of all tests together, counted by cross-validation when the bank was designed.
    false_alarms_per_hour: FalseAlarmRate,
    input_sha256: &'a str,
    /// What resampling made of the record.
    resampled: Option<&'a Resampled>,
    warnings: Vec<String>,
    out: Option<&'a Path>,
    /// Where the page is.
    #[serde(rename = "report")]
    folder: Option<&'a Path>,
}

/// Runs the verb.
pub fn run(args: &DetectArgs, global: &GlobalArgs) -> Result<Outcome, Failure> {
    let Some(args) = layered("detect", args, global)? else {
        return Ok(Outcome::Done);
    };
    let path = args
        .data
        .as_ref()
        .ok_or_else(|| Failure::missing("DATA", "gtfdi detect run.csv"))?;
    let bank_path = args
        .bank
        .as_ref()
        .ok_or_else(|| Failure::missing("--bank", "--bank bank.json"))?;
    if let Some(out) = &args.out {
        check_out(out, &[path, bank_path])?;
    }
    if let Some(folder) = &args.report {
        check_folder(folder)?;
    }
    let rows = args.rows.as_ref().map(|rows| rows.0.clone());
    let detector = DetectorFile::read(bank_path).map_err(Failure::input)?;
    let wanted = selection(detector.inputs(), detector.outputs(), &args.reading, rows)?;
    let read = read_for(path, &wanted, bank_path, detector.sample_time_s())?;
    let found = match detector {
        DetectorFile::Bank(bank) => detect(&bank, path, read, &args, global)?,
        DetectorFile::Isolator(isolator) => {
            let Read { imported, warnings } = read;
            let report = isolator::detect(&isolator, path, &imported, warnings, &args)?;
            if global.json {
                print_json(&report)?;
            } else {
                print(&isolator::text(&report))?;
            }
            !report.alarms.is_empty()
        }
    };
    Ok(outcome(&args, found))
}

/// Runs a bank over a record and prints what it found; whether there was an alarm.
fn detect(
    bank: &Bank,
    path: &Path,
    read: Read,
    args: &DetectArgs,
    global: &GlobalArgs,
) -> Result<bool, Failure> {
    let Read {
        imported,
        mut warnings,
    } = read;
    let data = &imported.dataset;
    let run = bank
        .run(data)
        .map_err(|error| Failure::in_file(path, error))?;
    for (test, judged) in bank.tests().iter().zip(&run.judged) {
        let settle = bank.settle_samples(test);
        if let Some(warning) = blind(&test.name, *judged, settle, data.len()) {
            complain(&format!("warning: {}: {warning}", path.display()));
            warnings.push(warning);
        }
    }
    if let Some(out) = &args.out {
        let metadata = RunMetadata {
            config_toml: reading_toml(&imported)?,
            data_sha256: Some(imported.sha256.clone()),
            warnings: warnings.clone(),
            qualities: imported.qualities.clone(),
            ..RunMetadata::default()
        };
        write_verdicts(out, bank, data, &run, &metadata).map_err(Failure::failed)?;
    }
    write_report(args.report.as_ref(), || {
        let source = provenance(sources(path, &imported, args), "detect", args, &warnings)?;
        Ok(detection_report(bank, data, &run, &source))
    })?;
    let report = Report {
        schema_version: SCHEMA_VERSION,
        samples: data.len(),
        sample_time_s: data.sample_time_s(),
        alarms: run.alarms.iter().map(alarm_report).collect(),
        outputs: bank
            .tests()
            .iter()
            .zip(run.judged.iter().zip(&run.share_above_limit))
            .map(|(test, (judged, share))| OutputReport {
                name: &test.name,
                statistic: &test.evaluation.statistic,
                threshold: test.threshold.limit,
                consecutive: test.threshold.consecutive,
                judged_samples: *judged,
                exceedance_share: share.is_finite().then_some(*share),
                alarms: run
                    .alarms
                    .iter()
                    .filter(|alarm| alarm.tag == test.name)
                    .count(),
                false_alarms_per_hour: test.false_alarms.cross_validated,
                mean_time_between_false_alarms: test.false_alarms.mean_time,
            })
            .collect(),
        false_alarms_per_hour: bank.false_alarms(),
        input_sha256: &imported.sha256,
        resampled: imported.resampled.as_ref(),
        warnings,
        out: args.out.as_deref(),
        folder: args.report.as_deref(),
    };
    if global.json {
        print_json(&report)?;
    } else {
        print(&text(&report))?;
    }
    Ok(!run.alarms.is_empty())
}

/// The files behind a detection: the record, and the detector, whose digest nobody took.
fn sources<'a>(
    path: &'a Path,
    imported: &'a Imported,
    args: &'a DetectArgs,
) -> impl Iterator<Item = (&'a Path, Option<&'a str>)> {
    let detector = args.bank.iter().map(|bank| (bank.as_path(), None));
    std::iter::once((path, Some(imported.sha256.as_str()))).chain(detector)
}

/// What a log says of how its record was read: what resampling did.
fn reading_toml(imported: &Imported) -> Result<String, Failure> {
    #[derive(Serialize)]
    struct Document<'a> {
        resampled: &'a Resampled,
    }
    let document = imported
        .resampled
        .as_ref()
        .map(|resampled| Document { resampled });
    match document {
        Some(document) => toml::to_string(&document).map_err(Failure::failed),
        None => Ok(String::new()),
    }
}

/// How the verb ends.
fn outcome(args: &DetectArgs, alarm: bool) -> Outcome {
    match args.fail_on {
        Some(FailOn::Alarm) if alarm => Outcome::Found,
        _ => Outcome::Done,
    }
}

/// What to say of an output that was judged on fewer samples than the record holds after the first
/// settling: silence there is no health.
fn blind(output: &str, judged: usize, settle: usize, samples: usize) -> Option<String> {
    let expected = samples.saturating_sub(settle);
    if expected == 0 {
        return Some(format!(
            "`{output}` was never judged: its generator settles for {settle} samples, the record \
             has {samples}"
        ));
    }
    (judged < expected).then(|| {
        format!(
            "`{output}` was judged on {judged} of {samples} samples: others are missing, or too \
             close after a missing one"
        )
    })
}

fn alarm_report(alarm: &Alarm) -> AlarmReport<'_> {
    AlarmReport {
        time_s: alarm.time_s,
        first_exceedance_s: alarm.first_exceedance_s,
        end_s: alarm.end_s,
        fault: None,
        tag: &alarm.tag,
        statistic: alarm.statistic,
        threshold: alarm.threshold,
        onset_s: alarm.onset_s,
        magnitude: alarm.deviation,
        probability: None,
    }
}

fn text(report: &Report) -> String {
    let outputs: Vec<Vec<String>> = report
        .outputs
        .iter()
        .map(|output| {
            vec![
                output.name.to_owned(),
                number(Some(output.threshold)),
                output.judged_samples.to_string(),
                number(output.exceedance_share.map(|share| 100.0 * share)),
                output.alarms.to_string(),
                number(Some(output.false_alarms_per_hour.per_hour)),
            ]
        })
        .collect();
    let mut text = table(
        &[
            "test",
            "limit",
            "judged samples",
            "above limit %",
            "alarms",
            "false alarms/h when healthy",
        ],
        &outputs,
    );
    if report.alarms.is_empty() {
        text.push_str("no alarm\n");
        return text;
    }
    let alarms: Vec<Vec<String>> = report
        .alarms
        .iter()
        .map(|alarm| {
            vec![
                alarm.tag.to_owned(),
                format!("{:.2}", alarm.time_s),
                format!("{:.2}", alarm.first_exceedance_s),
                alarm
                    .end_s
                    .map_or_else(|| "open".to_owned(), |end| format!("{end:.2}")),
                number(Some(alarm.statistic)),
            ]
        })
        .collect();
    text.push('\n');
    text.push_str(&table(
        &[
            "alarm",
            "at s",
            "above limit from s",
            "until s",
            "statistic",
        ],
        &alarms,
    ));
    text
}
