//! An isolator over a record: which fault, since when, how large.

use std::path::Path;

use gt_campaign::reports::isolation_report;
use gt_log::{Imported, Resampled, RunMetadata, write_diagnoses};
use gtfdi::core::Never;
use gtfdi::fdi::{IsolationRun, Isolator, MeanTime, NamedAlarm, NamedHypothesis, StatisticKind};
use serde::Serialize;

use crate::cli::DetectArgs;
use crate::commands::SCHEMA_VERSION;
use crate::commands::report_folder::{provenance, write_report};
use crate::failure::Failure;
use crate::output::{number, table};

/// An alarm of an isolator: the keys of a bank's alarm, and why.
#[derive(Serialize)]
pub struct AlarmReport {
    first_exceedance_s: f64,
    #[serde(flatten)]
    alarm: NamedAlarm,
}

/// A statistic with its limit.
#[derive(Serialize)]
struct StatisticReport<'a> {
    name: &'a str,
    statistic: Option<&'a StatisticKind>,
    threshold: f64,
    judged_samples: usize,
    alarms: usize,
    mean_time_between_false_alarms: MeanTime,
}

/// False alarms of all statistics together, by the healthy records' tails.
#[derive(Serialize)]
struct Promise {
    /// Null: nothing is counted, the rate is that of the tail.
    alarms: Option<usize>,
    /// Healthy hours behind it.
    hours: f64,
    per_hour: Option<f64>,
    per_hour_low: Option<f64>,
    per_hour_high: Option<f64>,
}

/// What an isolator found in a record.
#[derive(Serialize)]
pub struct Report<'a> {
    schema_version: u32,
    samples: usize,
    sample_time_s: f64,
    pub alarms: Vec<AlarmReport>,
    outputs: Vec<StatisticReport<'a>>,
    false_alarms_per_hour: Promise,
    input_sha256: &'a str,
    /// What resampling made of the record.
    resampled: Option<&'a Resampled>,
    warnings: Vec<String>,
    out: Option<&'a Path>,
    /// Where the page is.
    #[serde(rename = "report")]
    folder: Option<&'a Path>,
}

/// Runs an isolator over a record, and writes the log where one is asked for.
pub fn detect<'a>(
    isolator: &'a Isolator,
    path: &Path,
    imported: &'a Imported,
    mut warnings: Vec<String>,
    args: &'a DetectArgs,
) -> Result<Report<'a>, Failure> {
    let data = &imported.dataset;
    let run = isolator
        .run(data)
        .map_err(|error| Failure::in_file(path, error))?;
    let settle = isolator.settle_samples();
    if let Some(warning) = super::blind("isolator", run.judged, settle, data.len()) {
        crate::output::complain(&format!("warning: {}: {warning}", path.display()));
        warnings.push(warning);
    }
    if let Some(out) = &args.out {
        let metadata = RunMetadata {
            config_toml: super::reading_toml(imported)?,
            data_sha256: Some(imported.sha256.clone()),
            warnings: warnings.clone(),
            qualities: imported.qualities.clone(),
            ..RunMetadata::default()
        };
        write_diagnoses(out, isolator, data, &metadata).map_err(Failure::failed)?;
    }
    write_report(args.report.as_ref(), || {
        let files = super::sources(path, imported, args);
        let source = provenance(files, "detect", args, &warnings)?;
        isolation_report(isolator, data, &source, &Never)
            .map_err(|error| Failure::in_file(path, error))
    })?;
    Ok(Report {
        schema_version: SCHEMA_VERSION,
        samples: data.len(),
        sample_time_s: data.sample_time_s(),
        alarms: run
            .alarms
            .iter()
            .map(|alarm| AlarmReport {
                first_exceedance_s: alarm.time_s,
                alarm: isolator.named_alarm(alarm),
            })
            .collect(),
        outputs: statistics(isolator, &run),
        false_alarms_per_hour: promise(isolator.mean_times()),
        input_sha256: &imported.sha256,
        resampled: imported.resampled.as_ref(),
        warnings,
        out: args.out.as_deref(),
        folder: args.report.as_deref(),
    })
}

fn statistics<'a>(isolator: &'a Isolator, run: &IsolationRun) -> Vec<StatisticReport<'a>> {
    let limits = isolator.limits().iter().zip(isolator.mean_times());
    let names = isolator.statistic_names().into_iter();
    names
        .zip(limits)
        .enumerate()
        .map(|(place, (name, (limit, mean_time)))| StatisticReport {
            name,
            statistic: None,
            threshold: *limit,
            judged_samples: run.judged,
            alarms: run
                .alarms
                .iter()
                .filter(|alarm| alarm.leading == place)
                .count(),
            mean_time_between_false_alarms: *mean_time,
        })
        .collect()
}

fn promise(mean_times: &[MeanTime]) -> Promise {
    let rate = |hours: fn(&MeanTime) -> Option<f64>| {
        mean_times
            .iter()
            .map(|own| Some(1.0 / hours(own)?))
            .sum::<Option<f64>>()
    };
    Promise {
        alarms: None,
        hours: mean_times
            .iter()
            .map(|own| own.healthy_hours)
            .fold(0.0, f64::max),
        per_hour: rate(|own| own.hours),
        per_hour_low: rate(|own| own.hours_high),
        per_hour_high: rate(|own| own.hours_low),
    }
}

/// The result for people.
pub fn text(report: &Report) -> String {
    let statistics: Vec<Vec<String>> = report
        .outputs
        .iter()
        .map(|own| {
            vec![
                own.name.to_owned(),
                number(Some(own.threshold)),
                own.judged_samples.to_string(),
                own.alarms.to_string(),
                number(own.mean_time_between_false_alarms.hours),
            ]
        })
        .collect();
    let mut text = table(
        &[
            "fault",
            "limit",
            "judged samples",
            "alarms",
            "hours between false alarms",
        ],
        &statistics,
    );
    if report.alarms.is_empty() {
        text.push_str("no alarm\n");
        return text;
    }
    let alarms: Vec<Vec<String>> = report.alarms.iter().map(alarm_cells).collect();
    text.push('\n');
    text.push_str(&table(
        &[
            "alarm at s",
            "until s",
            "fault",
            "probability",
            "size",
            "since s",
            "other explanations",
        ],
        &alarms,
    ));
    text
}

fn alarm_cells(report: &AlarmReport) -> Vec<String> {
    let (alarm, found) = (&report.alarm, &report.alarm.diagnosis);
    let is_named = |own: &&NamedHypothesis| found.fault.as_ref() == Some(&own.fault);
    let named = found.hypotheses.iter().find(is_named);
    let fault = found.fault.clone().unwrap_or_else(|| {
        let words = match found.finding {
            "none_of_these" => "none of these",
            _ => "not decided yet",
        };
        words.to_owned()
    });
    let size = named.map_or_else(String::new, |own| {
        let [low, high] = own.magnitude_interval.map(|end| number(Some(end)));
        format!(
            "{} {} ({low} .. {high})",
            number(Some(own.magnitude)),
            own.unit
        )
    });
    let since = named.map_or_else(String::new, |own| {
        let [low, high] = own.onset_interval_s;
        format!("{:.1} ({low:.1} .. {high:.1})", own.onset_s)
    });
    let others: Vec<String> = found
        .hypotheses
        .iter()
        .filter(|own| own.probability >= 0.01 && !is_named(own))
        .map(|own| format!("{} {:.0} %", own.fault, 100.0 * own.probability))
        .collect();
    vec![
        format!("{:.2}", alarm.time_s),
        alarm
            .end_s
            .map_or_else(|| "open".to_owned(), |end| format!("{end:.2}")),
        fault,
        number(found.probability),
        size,
        since,
        others.join(", "),
    ]
}
