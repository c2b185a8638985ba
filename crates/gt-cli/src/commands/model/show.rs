//! `gtfdi model show`: a model for people.

use std::fmt::Write as _;
use std::path::Path;

use gt_log::ModelKind;
use gtfdi::core::Signal;
use gtfdi::ident::eiv::EivModel;
use gtfdi::ident::pole_zero::pole_zero;
use gtfdi::ident::{ArxModel, ArxStructure, RealisationReport, dc_gains, exact_coefficients};
use serde::Serialize;

use super::realisation::Realisation;
use super::roots::{PoleReport, ZeroReport, poles, poles_text, zeros, zeros_text};
use crate::Outcome;
use crate::cli::GlobalArgs;
use crate::commands::SCHEMA_VERSION;
use crate::commands::equation::{RegressionTerm, regressions};
use crate::commands::finding::Finding;
use crate::commands::noise::{NoiseReport, noise_reports, noise_text};
use crate::failure::Failure;
use crate::output::{number, print, print_json, table};

#[derive(Serialize)]
struct Report<'a> {
    schema_version: u32,
    file: &'a Path,
    kind: ModelKind,
    id: &'a str,
    input_sha256: Option<&'a str>,
    structure: &'a ArxStructure,
    sample_time_s: f64,
    rows_used: usize,
    inputs: Vec<ChannelReport<'a>>,
    outputs: Vec<ChannelReport<'a>>,
    equations: Vec<Equation<'a>>,
    /// Outputs first; null for models that take the inputs as exact.
    noise: Option<Vec<NoiseReport<'a>>>,
    /// Null where the model integrates.
    dc_gains: Option<Vec<Gain<'a>>>,
    spectral_radius: Option<f64>,
    stable: Option<bool>,
    /// Null where they could not be computed.
    poles: Option<Vec<PoleReport<'a>>>,
    zeros: Option<Vec<ZeroReport<'a>>>,
    realisation: Option<&'a RealisationReport>,
    findings: &'a [Finding],
    /// What the record does not tell of the noise, and what could not be computed.
    warnings: Vec<String>,
}

#[derive(Serialize)]
struct ChannelReport<'a> {
    name: &'a str,
    unit: &'a str,
    operating_point: f64,
}

#[derive(Serialize)]
struct Equation<'a> {
    output: &'a str,
    regression: Vec<RegressionTerm<'a>>,
    residual_variance: f64,
    condition: f64,
}

#[derive(Serialize)]
struct Gain<'a> {
    output: &'a str,
    input: &'a str,
    value: f64,
}

/// Runs the verb.
pub fn show(path: &Path, global: &GlobalArgs) -> Result<Outcome, Failure> {
    let file = super::read(path)?;
    let model = &file.model;
    let eiv = file.eiv().map_err(|error| Failure::in_file(path, error))?;
    let untold = eiv.iter().flat_map(EivModel::not_told);
    let mut warnings: Vec<String> = untold.map(|remark| remark.to_string()).collect();
    let realisation = Realisation::of(model);
    // The file has no covariance of the coefficients: places without errors.
    let exact = exact_coefficients(model);
    let gains = dc_gains(model, &exact);
    if let Err(error) = &gains {
        warnings.push(format!("steady-state gains: {error}"));
    }
    let roots = pole_zero(model, &exact);
    if let Err(error) = &roots {
        warnings.push(format!("poles and zeros: {error}"));
    }
    let roots = roots.ok();
    let point = model.operating_point();
    let report = Report {
        schema_version: SCHEMA_VERSION,
        file: path,
        kind: file.kind,
        id: &file.id,
        input_sha256: file.input_sha256.as_deref(),
        structure: model.structure(),
        sample_time_s: model.sample_time_s(),
        rows_used: model.rows_used(),
        inputs: channels(model.inputs(), point.u.as_slice()),
        outputs: channels(model.outputs(), point.y.as_slice()),
        equations: equations(model),
        noise: eiv.as_ref().map(noise_reports),
        dc_gains: gains.ok().map(|gains| {
            let values = gains.iter().map(|row| row.iter().map(|gain| gain.value));
            named_gains(model, values)
        }),
        spectral_radius: realisation.spectral_radius,
        stable: realisation.stable(),
        poles: roots.as_ref().map(|roots| poles(model, roots)),
        zeros: roots.as_ref().map(|roots| zeros(model, roots)),
        realisation: realisation.report.as_ref(),
        findings: &realisation.findings,
        warnings,
    };
    if global.json {
        print_json(&report)?;
    } else {
        print(&text(&report, &realisation))?;
    }
    Ok(Outcome::Done)
}

fn channels<'a>(signals: &'a [Signal], point: &[f64]) -> Vec<ChannelReport<'a>> {
    let channels = signals.iter().zip(point);
    channels
        .map(|(signal, &operating_point)| ChannelReport {
            name: &signal.name,
            unit: &signal.unit,
            operating_point,
        })
        .collect()
}

fn equations(model: &ArxModel) -> Vec<Equation<'_>> {
    let outputs = model.outputs().iter().zip(model.rows());
    let more = regressions(model).into_iter().zip(model.condition());
    outputs
        .zip(more)
        .map(|((signal, row), (regression, &condition))| Equation {
            output: &signal.name,
            regression,
            residual_variance: row.residual_variance,
            condition,
        })
        .collect()
}

fn named_gains(
    model: &ArxModel,
    gains: impl Iterator<Item = impl Iterator<Item = f64>>,
) -> Vec<Gain<'_>> {
    let rows = model.outputs().iter().zip(gains);
    rows.flat_map(|(output, row)| {
        let inputs = model.inputs().iter().zip(row);
        inputs.map(|(input, value)| Gain {
            output: &output.name,
            input: &input.name,
            value,
        })
    })
    .collect()
}

/// The whole report as text. Writing to a string cannot fail.
fn text(report: &Report, realisation: &Realisation) -> String {
    let kind = match report.kind {
        ModelKind::Arx => "least squares (arx)",
        ModelKind::Frisch => "errors in variables (frisch)",
        ModelKind::Eiv => "errors in variables (eiv)",
    };
    let mut text = format!(
        "{}: model {}, {kind}, {}\nsample time {} s, fitted to {} rows{}\n",
        report.file.display(),
        report.id,
        report.structure,
        number(Some(report.sample_time_s)),
        report.rows_used,
        match report.input_sha256 {
            Some(digest) => format!(" of the record {}", digest.get(..12).unwrap_or(digest)),
            None => String::new(),
        }
    );
    text += &channels_text(report);
    for equation in &report.equations {
        text += &equation_text(equation);
    }
    if let Some(noise) = &report.noise {
        text += &noise_text(noise);
    }
    if let Some(gains) = &report.dc_gains {
        let rows: Vec<Vec<String>> = gains
            .iter()
            .map(|gain| {
                let channel = format!("{} from {}", gain.output, gain.input);
                vec![channel, number(Some(gain.value))]
            })
            .collect();
        text += &table(&["gain of", "at rest"], &rows);
    }
    if let Some(poles) = &report.poles {
        text += &poles_text(poles);
    }
    if let Some(zeros) = report.zeros.as_deref().filter(|zeros| !zeros.is_empty()) {
        text += &zeros_text(zeros);
    }
    text += &realisation.text();
    for finding in report.findings {
        let _ = writeln!(text, "{}", finding.line());
    }
    for warning in &report.warnings {
        let _ = writeln!(text, "{warning}");
    }
    text
}

fn channels_text(report: &Report) -> String {
    let rows = |channels: &[ChannelReport], side: &str| -> Vec<Vec<String>> {
        let channels = channels.iter();
        channels
            .map(|channel| {
                vec![
                    channel.name.to_owned(),
                    side.to_owned(),
                    if channel.unit.is_empty() {
                        "-".to_owned()
                    } else {
                        channel.unit.to_owned()
                    },
                    number(Some(channel.operating_point)),
                ]
            })
            .collect()
    };
    let rows = [
        rows(&report.inputs, "input"),
        rows(&report.outputs, "output"),
    ]
    .concat();
    table(&["channel", "side", "unit", "operating point"], &rows)
}

/// An equation, a term a line.
fn equation_text(equation: &Equation) -> String {
    let rows: Vec<Vec<String>> = equation
        .regression
        .iter()
        .map(|term| {
            let name = if term.lag == 0 {
                format!("{}(t)", term.signal)
            } else {
                format!("{}(t-{})", term.signal, term.lag)
            };
            vec![
                name,
                number(Some(term.coefficient)),
                number(term.standard_error),
            ]
        })
        .collect();
    let title = format!("{}(t) =", equation.output);
    let table = table(&[&title, "coefficient", "standard error"], &rows);
    format!(
        "{table}standard deviation of the equation error {}, condition {}\n",
        number(Some(equation.residual_variance.sqrt())),
        number(Some(equation.condition))
    )
}
