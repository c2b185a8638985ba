//! `gtfdi identify`: a record to a model file.

use std::fmt::Display;
use std::ops::Range;
use std::path::{Path, PathBuf};

use gt_log::{LogError, ModelFile, write_json};
use gtfdi::core::Dataset;
use gtfdi::ident::{Arx, ArxModel, ArxStructure, Channel, OrderTable, Validation, validate};
use serde::Serialize;

use super::SCHEMA_VERSION;
use super::structure::{Chosen, choose};
use crate::Outcome;
use crate::cli::{GlobalArgs, IdentifyArgs, Method};
use crate::config::layered;
use crate::failure::Failure;
use crate::output::{complain, number, print, print_json, table};
use crate::record::{Read, check_out, read, selection};

#[derive(Serialize)]
struct RegressionTerm<'a> {
    signal: &'a str,
    lag: usize,
    coefficient: f64,
}

#[derive(Serialize)]
struct OutputReport<'a> {
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

#[derive(Serialize)]
struct Report<'a> {
    schema_version: u32,
    method: Method,
    structure: &'a ArxStructure,
    sample_time_s: f64,
    spectral_radius: Option<f64>,
    train_rows: [usize; 2],
    validation_rows: [usize; 2],
    outputs: Vec<OutputReport<'a>>,
    order_table: Option<&'a OrderTable>,
    input_sha256: &'a str,
    warnings: Vec<String>,
    out: Option<&'a Path>,
}

/// The training and the validation rows, and the rows of the file that hold both: only those have
/// to be readable.
struct Blocks {
    train: Option<Range<usize>>,
    validate: Option<Range<usize>>,
    window: Option<Range<usize>>,
}

impl Blocks {
    fn of(args: &IdentifyArgs) -> Self {
        let [train, validate] =
            [&args.train, &args.validate].map(|rows| rows.as_ref().map(|rows| rows.0.clone()));
        let window = match (&train, &validate) {
            (Some(train), Some(validate)) => {
                Some(train.start.min(validate.start)..train.end.max(validate.end))
            }
            (Some(train), None) => Some(train.clone()),
            (None, _) => None,
        };
        Self {
            train,
            validate,
            window,
        }
    }

    /// The rows that the file has not, by the option that asks for them.
    fn beyond(&self, path: &Path, total: usize) -> Option<Failure> {
        [("--train", &self.train), ("--validate", &self.validate)]
            .into_iter()
            .filter_map(|(option, rows)| Some((option, rows.as_ref()?)))
            .find(|(_, rows)| rows.end > total)
            .map(|(option, rows)| {
                let (start, end) = (rows.start, rows.end);
                Failure::in_file(
                    path,
                    format!(
                        "{option}: expected rows A:B with B at most {total}, found {start}:{end}"
                    ),
                )
            })
    }
}

/// Runs the verb.
pub fn run(args: &IdentifyArgs, global: &GlobalArgs) -> Result<Outcome, Failure> {
    let defaults = IdentifyArgs {
        method: Some(Method::Arx),
        ..IdentifyArgs::default()
    };
    let Some(args) = layered("identify", args, &defaults, global)? else {
        return Ok(Outcome::Done);
    };
    let path: PathBuf = args
        .data
        .clone()
        .ok_or_else(|| Failure::missing("DATA", "gtfdi identify run.csv"))?;
    let inputs = args.inputs.clone().unwrap_or_default();
    let outputs = args
        .outputs
        .clone()
        .ok_or_else(|| Failure::missing("--outputs", "--outputs y"))?;
    if let Some(out) = &args.out {
        check_out(out, &[&path])?;
    }
    let blocks = Blocks::of(&args);
    let wanted = selection(inputs, outputs, &args.reading, blocks.window.clone());
    let Read {
        imported,
        mut warnings,
    } = read(&path, &wanted).map_err(|error| match error {
        LogError::Rows { total, .. } => blocks
            .beyond(&path, total)
            .unwrap_or_else(|| Failure::input(error)),
        error => Failure::input(error),
    })?;
    if let Some(failure) = blocks.beyond(&path, imported.total_rows) {
        return Err(failure);
    }
    let data = &imported.dataset;
    let shift = blocks.window.as_ref().map_or(0, |window| window.start);
    let block = |rows: Option<Range<usize>>, default: Range<usize>| {
        rows.map_or(default, |rows| rows.start - shift..rows.end - shift)
    };
    let train_rows = block(blocks.train, 0..data.len());
    let validation_rows = block(blocks.validate, train_rows.clone());
    let in_file = |error: &dyn Display| Failure::in_file(&path, error);
    let rows = |rows: &Range<usize>| data.rows(rows.clone()).map_err(|error| in_file(&error));
    let (train, validation) = (rows(&train_rows)?, rows(&validation_rows)?);

    let Chosen {
        structure,
        orders,
        warning,
    } = choose(&args, &path, &train)?;
    if let Some(warning) = warning {
        complain(&format!("warning: {}: {warning}", path.display()));
        warnings.push(warning);
    }
    let fitted = Arx::new(structure).fit(&train);
    let model = fitted.map_err(|error| in_file(&error))?;
    let scores = validate(&model, &validation).map_err(|error| {
        let rows = args.validate.as_ref().map_or_else(
            || "the training rows".to_owned(),
            |rows| format!("--validate {rows}"),
        );
        in_file(&format!("{rows}: {error}"))
    })?;
    if let Some(out) = &args.out {
        let file =
            ModelFile::arx(model.clone(), Some(&imported.sha256)).map_err(Failure::failed)?;
        write_json(out, &file).map_err(Failure::failed)?;
    }
    let absolute = |rows: Range<usize>| [rows.start + shift, rows.end + shift];
    let report = Report {
        schema_version: SCHEMA_VERSION,
        method: Method::Arx,
        structure: model.structure(),
        sample_time_s: model.sample_time_s(),
        spectral_radius: model
            .state_space()
            .ok()
            .and_then(|ss| ss.spectral_radius().ok()),
        train_rows: absolute(train_rows),
        validation_rows: absolute(validation_rows),
        outputs: output_reports(&model, &scores),
        order_table: orders.as_ref(),
        input_sha256: &imported.sha256,
        warnings,
        out: args.out.as_deref(),
    };
    if global.json {
        print_json(&report)?;
    } else {
        print(&text(&report, &train))?;
    }
    Ok(Outcome::Done)
}

fn output_reports<'a>(model: &'a ArxModel, scores: &'a Validation) -> Vec<OutputReport<'a>> {
    let signal = |channel: &Channel| match channel {
        Channel::Output(index) => model.outputs()[*index].name.as_str(),
        Channel::Input(index) => model.inputs()[*index].name.as_str(),
    };
    model
        .rows()
        .iter()
        .zip(&scores.outputs)
        .map(|(row, score)| OutputReport {
            name: &score.name,
            regression: row
                .terms
                .iter()
                .map(|term| RegressionTerm {
                    signal: signal(&term.channel),
                    lag: term.lag,
                    coefficient: term.coefficient,
                })
                .collect(),
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

fn text(report: &Report, train: &Dataset) -> String {
    let mut text = format!(
        "{} identified on {} rows, validated on rows {}:{}\n",
        report.structure,
        train.len(),
        report.validation_rows[0],
        report.validation_rows[1]
    );
    if let Some(orders) = report.order_table {
        let rows: Vec<Vec<String>> = orders
            .rows
            .iter()
            .map(|row| {
                vec![
                    row.order.to_string(),
                    row.parameters.to_string(),
                    format!("{:.1}", row.aic),
                    format!("{:.1}", row.mdl),
                    number(Some(row.fpe)),
                    number(Some(row.ppcre_percent)),
                ]
            })
            .collect();
        text.push_str(&table(
            &["order", "parameters", "AIC", "MDL", "FPE", "PPCRE %"],
            &rows,
        ));
        text += "chosen by MDL: order ";
        text += &orders.best_mdl().to_string();
        text.push('\n');
    }
    let rows: Vec<Vec<String>> = report
        .outputs
        .iter()
        .map(|output| {
            vec![
                output.name.to_owned(),
                number(Some(output.fit_prediction_percent)),
                output.diverges_at_s.map_or_else(
                    || number(output.fit_simulation_percent),
                    |time| format!("diverges at {} s", number(Some(time))),
                ),
                number(Some(output.ppcre_percent)),
                number(output.ppcre_simulation_percent),
            ]
        })
        .collect();
    text.push_str(&table(
        &[
            "output",
            "fit prediction %",
            "fit simulation %",
            "PPCRE prediction %",
            "simulation %",
        ],
        &rows,
    ));
    text
}
