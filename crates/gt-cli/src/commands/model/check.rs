//! `gtfdi model check`: whether a model can be used, by itself and on records.

use std::fmt::Write as _;
use std::path::Path;

use gt_log::ModelKind;
use gtfdi::ident::eiv::EivModel;
use gtfdi::ident::{ChiSquareTest, RealisationReport, ResidualReport, Start};
use serde::Serialize;

use super::on_record::{RecordReport, on_record};
use super::realisation::Realisation;
use crate::Outcome;
use crate::cli::{CheckArgs, GlobalArgs};
use crate::commands::SCHEMA_VERSION;
use crate::commands::finding::{Finding, residual_summary};
use crate::commands::noise::FITTED_START;
use crate::config::layered;
use crate::failure::Failure;
use crate::output::{free_run, number, print, print_json, table};
use crate::record::{parts, read_for, selection_for};

#[derive(Serialize)]
struct Report<'a> {
    schema_version: u32,
    file: &'a Path,
    kind: ModelKind,
    id: &'a str,
    /// Whether nothing was found.
    sound: bool,
    spectral_radius: Option<f64>,
    stable: Option<bool>,
    realisation: Option<&'a RealisationReport>,
    records: Vec<RecordReport>,
    /// Of the model by itself, then of each record.
    findings: Vec<FindingReport>,
    warnings: Vec<String>,
}

#[derive(Serialize)]
struct FindingReport {
    /// The record; null for a finding of the model by itself.
    data: Option<String>,
    #[serde(flatten)]
    finding: Finding,
}

/// Runs the verb.
pub fn check(args: &CheckArgs, global: &GlobalArgs) -> Result<Outcome, Failure> {
    let Some(args) = layered("model-check", args, global)? else {
        return Ok(Outcome::Done);
    };
    let path = args
        .model
        .as_ref()
        .ok_or_else(|| Failure::missing("MODEL.json", "gtfdi model check model.json"))?;
    let file = super::read(path)?;
    let model = &file.model;
    let eiv = file.eiv().map_err(|error| Failure::in_file(path, error))?;
    let realisation = Realisation::of(model);
    let mut findings: Vec<FindingReport> = Vec::new();
    let mut found = |data: Option<&Path>, new: Vec<Finding>| {
        findings.extend(new.into_iter().map(|finding| FindingReport {
            data: data.map(|path| path.display().to_string()),
            finding,
        }));
    };
    found(None, realisation.findings.clone());
    let untold = eiv.iter().flat_map(EivModel::not_told).map(|remark| Finding {
        kind: "noise_not_told",
        text: remark.to_string(),
        advice: "take a longer record or one whose inputs move more; do not rely on this variance",
    });
    found(None, untold.collect());

    let rows = args.rows.as_ref().map(|rows| rows.0.clone());
    let wanted = selection_for(model, &args.reading, rows)?;
    let mut records = Vec::new();
    let mut warnings = Vec::new();
    for data in args.data.iter().flatten() {
        let read = read_for(data, &wanted, path, model.sample_time_s())?;
        warnings.extend(read.warnings);
        let imported = read.imported;
        let parts = parts(data, imported.dataset, wanted.missing)?;
        let record = (data.as_path(), &parts[..], imported.sha256.as_str());
        let mut report = on_record(&file, record, &args)?;
        found(Some(data), std::mem::take(&mut report.findings));
        records.push(report);
    }
    let report = Report {
        schema_version: SCHEMA_VERSION,
        file: path,
        kind: file.kind,
        id: &file.id,
        sound: findings.is_empty(),
        spectral_radius: realisation.spectral_radius,
        stable: realisation.stable(),
        realisation: realisation.report.as_ref(),
        records,
        findings,
        warnings,
    };
    if global.json {
        print_json(&report)?;
    } else {
        print(&text(&report, &realisation))?;
    }
    Ok(Outcome::Done)
}

/// The report as text. Writing to a string cannot fail.
fn text(report: &Report, realisation: &Realisation) -> String {
    let mut text = format!(
        "{}: model {}: version, digest and equations are sound\n{}",
        report.file.display(),
        report.id,
        realisation.text()
    );
    for record in &report.records {
        text += &record_text(record);
    }
    if report.sound {
        text += if report.records.is_empty() {
            "nothing found; a record shows more: gtfdi model check MODEL.json DATA\n"
        } else {
            "nothing found\n"
        };
    }
    for finding in &report.findings {
        let record = finding.data.as_ref();
        let record = record.map_or_else(String::new, |data| format!("{data}: "));
        let _ = writeln!(text, "{record}{}", finding.finding.line());
    }
    text
}

fn record_text(record: &RecordReport) -> String {
    let mut text = record.head();
    let tests = record.residual_tests.as_ref();
    let rows: Vec<Vec<String>> = record
        .outputs
        .iter()
        .enumerate()
        .map(|(index, fit)| {
            let [white, independent] = p_values(tests, index);
            vec![
                fit.name.clone(),
                number(Some(fit.fit_prediction_percent)),
                free_run(fit.fit_simulation_percent, fit.diverges_at_s),
                white,
                independent,
                tests.map_or_else(|| "-".to_owned(), |tests| outside(tests, index)),
            ]
        })
        .collect();
    let head = [
        "output",
        "fit prediction %",
        "fit simulation %",
        "p white",
        "p independent",
        "lags outside their band",
    ];
    text += &table(&head, &rows);
    if record.free_run_start == Start::Fitted {
        text += FITTED_START;
    }
    if let (Some(verdict), Some(tests)) = (&record.residuals, tests) {
        let _ = writeln!(text, "{}", residual_summary(verdict));
        if let (Some(hosking), true) = (&tests.hosking, record.outputs.len() > 1) {
            let p = number(Some(hosking.p_value));
            let _ = writeln!(text, "all outputs together (Hosking): p white {p}");
        }
    }
    if let Some(why) = &record.untested {
        let _ = writeln!(text, "one-step errors not tested: {why}");
    }
    text
}

/// The p values of whiteness and of independence of an output's errors.
fn p_values(tests: Option<&ResidualReport>, output: usize) -> [String; 2] {
    let p = |test: Option<&Option<ChiSquareTest>>| {
        number(test.and_then(|test| test.as_ref().map(|test| test.p_value)))
    };
    [
        p(tests.and_then(|tests| tests.ljung_box.get(output))),
        p(tests.and_then(|tests| tests.independence.get(output))),
    ]
}

/// How many autocorrelations lie outside their bands, of how many.
fn outside(tests: &ResidualReport, output: usize) -> String {
    let Some(auto) = tests.autocorrelations.get(output) else {
        return "-".to_owned();
    };
    let pairs = auto.values.iter().zip(&auto.bands);
    let outside = pairs.filter(|(value, band)| value.abs() > **band).count();
    format!("{outside} of {}", auto.values.len())
}
