//! What `gtfdi identify` says: one JSON object, or a table.

use gt_campaign::reports::OrderComparison;
use std::collections::BTreeMap;
use std::fmt::Write as _;
use std::path::Path;

use gtfdi::ident::constrained::{ActiveConstraint, ConstrainedRow};
use gtfdi::ident::output_error::RefinedOutput;
use gtfdi::ident::{ArxModel, ArxStructure, ResidualVerdict, Start, Validation};
use serde::Serialize;

use super::records::Source;
use crate::cli::Method;
use crate::commands::equation::{RegressionTerm, regressions};
use crate::commands::finding::{residual_findings, residual_summary};
use crate::commands::noise::{FITTED_START, NoiseReport, noise_text};
use crate::output::{free_run, number, table};

/// The JSON object.
#[derive(Serialize)]
pub struct Report<'a> {
    pub schema_version: u32,
    pub method: Method,
    pub structure: &'a ArxStructure,
    pub sample_time_s: f64,
    pub spectral_radius: Option<f64>,
    /// Whether all poles lie inside the unit circle; null where they could not be computed.
    pub stable: Option<bool>,
    /// Where free runs start: at the measured outputs, or where they fit the record best (for models
    /// with noise on the channels).
    pub free_run_start: Start,
    /// When the first free run diverges, in seconds.
    pub diverges_at: Option<f64>,
    /// Of the record, where there is one only.
    pub train_rows: Option<[usize; 2]>,
    /// Of the record or of the hold-out, where there is one only.
    pub validation_rows: Option<[usize; 2]>,
    /// The records of the fit.
    pub records: &'a [Source],
    pub holdout: Option<&'a Source>,
    pub outputs: Vec<OutputReport<'a>>,
    /// By output, in the order of its regression.
    pub standard_errors: Option<BTreeMap<&'a str, Vec<f64>>>,
    /// Verdicts on the one-step errors; null where they were not tested, and for models with noise
    /// on the inputs, which colours them.
    pub residuals: Option<&'a ResidualVerdict>,
    /// By output; null without constraints.
    pub constraints: Option<&'a [ConstrainedRow]>,
    /// By output; null without a refinement.
    pub refinement: Option<&'a [RefinedOutput]>,
    /// By channel; null for methods that take the inputs as exact.
    pub noise_variances: Option<BTreeMap<&'a str, f64>>,
    /// The same with what is known of them, outputs first.
    pub noise: Option<Vec<NoiseReport<'a>>>,
    pub order_table: Option<&'a OrderComparison>,
    pub order_reason: Option<String>,
    /// Of the record, where there is one only.
    pub input_sha256: Option<&'a str>,
    pub warnings: Vec<String>,
    pub plot: Option<&'a Path>,
    pub out: Option<&'a Path>,
    /// Where the page is.
    #[serde(rename = "report")]
    pub folder: Option<&'a Path>,
}

/// An output's equation and its errors.
#[derive(Serialize)]
pub struct OutputReport<'a> {
    name: &'a str,
    regression: Vec<RegressionTerm<'a>>,
    fit_prediction_percent: f64,
    fit_simulation_percent: Option<f64>,
    ppcre_percent: f64,
    ppcre_simulation_percent: Option<f64>,
    sse_prediction: f64,
    sse_simulation: Option<f64>,
    diverges_at_s: Option<f64>,
}

/// The standard errors of the coefficients, by output.
pub fn standard_errors(model: &ArxModel) -> Option<BTreeMap<&str, Vec<f64>>> {
    let names = model.outputs().iter().map(|signal| signal.name.as_str());
    let errors = model.standard_errors()?;
    Some(names.zip(errors.iter().cloned()).collect())
}

/// Every output's equation with its errors.
pub fn output_reports<'a>(model: &'a ArxModel, scores: &'a Validation) -> Vec<OutputReport<'a>> {
    regressions(model)
        .into_iter()
        .zip(&scores.outputs)
        .map(|(regression, score)| OutputReport {
            name: &score.name,
            regression,
            fit_prediction_percent: score.fit_prediction_percent,
            fit_simulation_percent: score.fit_simulation_percent,
            ppcre_percent: score.ppcre_prediction_percent,
            ppcre_simulation_percent: score.ppcre_simulation_percent,
            sse_prediction: score.sse_prediction,
            sse_simulation: score.sse_simulation,
            diverges_at_s: score.diverges_at_s,
        })
        .collect()
}

/// The table. Writing to a string cannot fail.
pub fn text(report: &Report, train_rows: usize, validation_rows: usize) -> String {
    let mut text = format!("{} identified on {train_rows} rows", report.structure);
    if report.records.len() > 1 {
        let _ = write!(text, " of {} records", report.records.len());
    }
    let _ = match report.validation_rows {
        Some([start, end]) => write!(text, ", validated on rows {start}:{end}"),
        None => write!(text, ", validated on {validation_rows} rows"),
    };
    text += if report.holdout.is_some() {
        " of the hold-out record\n"
    } else {
        "\n"
    };
    for source in report.records.iter().chain(report.holdout) {
        text += &slopes(source);
    }
    if let (Some(orders), Some(reason)) = (report.order_table, &report.order_reason) {
        let _ = writeln!(text, "{}{reason}", orders.text());
    }
    text += &fits(&report.outputs);
    if report.free_run_start == Start::Fitted {
        text += FITTED_START;
    }
    if report.stable == Some(false) {
        let radius = number(report.spectral_radius);
        let _ = writeln!(
            text,
            "the model is not stable: its largest pole has modulus {radius}; --stable keeps poles \
             inside the unit circle"
        );
    }
    text += &residuals(report);
    for row in report.constraints.into_iter().flatten() {
        let _ = writeln!(text, "{}", constraint(row));
    }
    for output in report.refinement.into_iter().flatten() {
        let _ = writeln!(text, "{}", refinement(output));
    }
    if let Some(noise) = &report.noise {
        text += &noise_text(noise);
    }
    text
}

/// The trend that was taken out of a record.
fn slopes(source: &Source) -> String {
    let Some(slopes) = &source.trend else {
        return String::new();
    };
    let each = slopes.iter();
    let each = each.map(|slope| format!("{} {:.3e}", slope.signal, slope.per_s));
    let each: Vec<String> = each.collect();
    let data = source.data.display();
    format!("{data}: taken out, per second: {}\n", each.join(", "))
}

fn fits(outputs: &[OutputReport]) -> String {
    let rows: Vec<Vec<String>> = outputs
        .iter()
        .map(|output| {
            vec![
                output.name.to_owned(),
                number(Some(output.fit_prediction_percent)),
                free_run(output.fit_simulation_percent, output.diverges_at_s),
                number(Some(output.ppcre_percent)),
                number(output.ppcre_simulation_percent),
            ]
        })
        .collect();
    table(
        &[
            "output",
            "fit prediction %",
            "fit simulation %",
            "PPCRE prediction %",
            "simulation %",
        ],
        &rows,
    )
}

/// What the residual tests say.
fn residuals(report: &Report) -> String {
    match report.residuals {
        Some(verdict) => {
            let mut text = format!("{}\n", residual_summary(verdict));
            for finding in residual_findings(verdict) {
                let _ = writeln!(text, "{}", finding.line());
            }
            text
        }
        None if report.noise.is_some() => {
            "one-step errors not tested: the noise on the inputs colours them\n".to_owned()
        }
        None => "one-step errors not tested: too few rows, or rounding only\n".to_owned(),
    }
}

/// What the constraints cost an output.
fn constraint(row: &ConstrainedRow) -> String {
    let output = &row.output;
    let radii = format!(
        "largest pole {}, {} without",
        number(Some(row.radius)),
        number(Some(row.least_squares_radius))
    );
    if row.active.is_empty() {
        return format!("`{output}`: no constraint binds; {radii}");
    }
    let mut binding: Vec<String> = Vec::new();
    for active in &row.active {
        let name = match active {
            ActiveConstraint::Stability { .. } => "stability".to_owned(),
            ActiveConstraint::DcGain { input } => format!("the gain of `{input}`"),
        };
        if !binding.contains(&name) {
            binding.push(name);
        }
    }
    format!(
        "`{output}`: {} binds; squared errors {} times those of least squares; {radii}",
        binding.join(" and "),
        number(Some(row.cost_ratio))
    )
}

/// What came of the refinement of an output.
fn refinement(output: &RefinedOutput) -> String {
    let verdict = if output.accepted {
        "refinement accepted"
    } else {
        "refinement not accepted, the model stays as it was"
    };
    let error = |value: Option<f64>| value.map_or("divergent".to_owned(), |v| number(Some(v)));
    format!(
        "`{}`: {verdict}: free-run error on the validation rows {} before, {} after",
        output.output,
        error(output.hold_out_before),
        error(output.hold_out_after)
    )
}
