//! `gtfdi identify`: a record to a model file.

use std::ops::{Range, RangeInclusive};
use std::path::{Path, PathBuf};

use gt_log::{Imported, ModelFile, Selection, read_dataset, write_json};
use gtfdi::core::Dataset;
use gtfdi::ident::{
    Arx, ArxModel, ArxStructure, Channel, OrderKind, OrderTable, Validation, generic_indices,
    order_table, validate,
};
use serde::Serialize;

use super::SCHEMA_VERSION;
use crate::Outcome;
use crate::cli::{DataArgs, GlobalArgs, IdentifyArgs, Method, Structure};
use crate::config::layered;
use crate::failure::Failure;
use crate::output::{number, print, print_json, table};

/// Orders that `--order auto` looks at.
const AUTO_ORDERS: RangeInclusive<usize> = 1..=12;

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

/// What `--order` asks for.
enum Order {
    One(usize),
    Search(RangeInclusive<usize>),
}

fn parse_order(text: &str) -> Result<Order, Failure> {
    let bad = || {
        Failure::input(format!(
            "--order: expected a number from 1, a range such as 1..12, or auto, found `{text}`"
        ))
    };
    if text == "auto" {
        return Ok(Order::Search(AUTO_ORDERS));
    }
    if let Some((low, high)) = text.split_once("..") {
        let low: usize = low.trim().parse().map_err(|_| bad())?;
        let high: usize = high
            .trim_start_matches('=')
            .trim()
            .parse()
            .map_err(|_| bad())?;
        return if low >= 1 && low <= high {
            Ok(Order::Search(low..=high))
        } else {
            Err(bad())
        };
    }
    match text.trim().parse() {
        Ok(order) if order >= 1 => Ok(Order::One(order)),
        _ => Err(bad()),
    }
}

/// The options as a structure, or as a family of structures to search.
enum Wish {
    Structure(ArxStructure),
    Search(OrderKind, RangeInclusive<usize>),
}

fn wish(args: &IdentifyArgs, outputs: usize) -> Result<Wish, Failure> {
    let nk = args.nk.clone().unwrap_or_else(|| vec![1]);
    let lags = args.na.is_some() || args.nb.is_some();
    if args.order.is_some() && (lags || args.indices.is_some()) || args.indices.is_some() && lags {
        return Err(Failure::input(
            "--order, --indices and --na/--nb: expected one of the three, found several",
        ));
    }
    let canonical_by_default = args.indices.is_some() || args.order.is_some() && outputs > 1;
    let structure = args.structure.unwrap_or(if canonical_by_default {
        Structure::Canonical
    } else {
        Structure::Full
    });
    if structure == Structure::Canonical {
        let feedthrough = match nk.as_slice() {
            [1] => false,
            [0] => true,
            _ => {
                return Err(Failure::input(format!(
                    "--nk: the canonical structure has lags 1 (or 0, a direct term) for all \
                     inputs, found {nk:?}"
                )));
            }
        };
        if lags {
            return Err(Failure::input(
                "--structure canonical: expected --order or --indices, found --na or --nb",
            ));
        }
        return match (
            &args.indices,
            args.order.as_deref().map(parse_order).transpose()?,
        ) {
            (Some(indices), _) => Ok(Wish::Structure(ArxStructure::Canonical {
                indices: indices.clone(),
                feedthrough,
            })),
            (None, Some(Order::One(order))) => {
                let indices = generic_indices(order, outputs).map_err(Failure::input)?;
                Ok(Wish::Structure(ArxStructure::Canonical {
                    indices,
                    feedthrough,
                }))
            }
            (None, Some(Order::Search(orders))) => {
                // Fewer states than outputs leave an output without a row of its own.
                let low = (*orders.start()).max(outputs);
                let orders = low..=(*orders.end()).max(low);
                Ok(Wish::Search(OrderKind::Canonical { feedthrough }, orders))
            }
            (None, None) => Err(Failure::missing("--order or --indices", "--order 8")),
        };
    }
    if args.indices.is_some() {
        return Err(Failure::input(
            "--indices: expected only with --structure canonical",
        ));
    }
    let kind = |nk: Vec<usize>| match structure {
        Structure::Diag => OrderKind::Diagonal { nk },
        Structure::Full | Structure::Canonical => OrderKind::Full { nk },
    };
    match args.order.as_deref().map(parse_order).transpose()? {
        Some(Order::One(order)) => kind(nk)
            .structure(order, outputs)
            .map(Wish::Structure)
            .map_err(Failure::input),
        Some(Order::Search(orders)) => Ok(Wish::Search(kind(nk), orders)),
        None => match (args.na, args.nb.clone()) {
            (Some(na), Some(nb)) => Ok(Wish::Structure(match structure {
                Structure::Diag => ArxStructure::Diagonal { na, nb, nk },
                Structure::Full | Structure::Canonical => ArxStructure::Full { na, nb, nk },
            })),
            (None, None) => Err(Failure::missing("--order, or --na and --nb", "--order 8")),
            (Some(_), None) => Err(Failure::missing("--nb", "--nb 2")),
            (None, Some(_)) => Err(Failure::missing("--na", "--na 2")),
        },
    }
}

/// The selection of channels and rows that `reading` and the other options describe.
pub fn selection(
    inputs: Vec<String>,
    outputs: Vec<String>,
    reading: &DataArgs,
    rows: Option<Range<usize>>,
) -> Selection {
    Selection {
        inputs,
        outputs,
        time: reading.time.clone(),
        sample_time_s: reading.sample_time,
        topic: reading.topic.clone(),
        rows,
    }
}

/// Reads a record and passes its warnings on.
pub fn read(path: &Path, selection: &Selection) -> Result<Imported, Failure> {
    let imported = read_dataset(path, selection).map_err(Failure::input)?;
    for warning in &imported.warnings {
        eprintln!("gtfdi: warning: {}: {warning}", path.display());
    }
    Ok(imported)
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
    // Only the rows that are used have to be readable; one range covers both blocks.
    let blocks = [&args.train, &args.validate].map(|rows| rows.as_ref().map(|rows| rows.0.clone()));
    let window = match &blocks {
        [Some(train), Some(validate)] => {
            Some(train.start.min(validate.start)..train.end.max(validate.end))
        }
        [Some(train), None] => Some(train.clone()),
        [None, _] => None,
    };
    let shift = window.as_ref().map_or(0, |window| window.start);
    let imported = read(&path, &selection(inputs, outputs, &args.reading, window))?;
    let data = &imported.dataset;
    let block = |rows: &Option<Range<usize>>, default: Range<usize>| {
        rows.as_ref()
            .map_or(default, |rows| rows.start - shift..rows.end - shift)
    };
    let train_rows = block(&blocks[0], 0..data.len());
    let validation_rows = block(&blocks[1], train_rows.clone());
    let rows = |rows: &Range<usize>| data.rows(rows.clone()).map_err(Failure::input);
    let (train, validation) = (rows(&train_rows)?, rows(&validation_rows)?);

    let (structure, orders) = match wish(&args, data.ny())? {
        Wish::Structure(structure) => (structure, None),
        Wish::Search(kind, orders) => {
            let table = order_table(&train, orders, &kind)
                .map_err(|error| Failure::in_file(&path, error))?;
            let structure = kind
                .structure(table.best_mdl(), data.ny())
                .map_err(Failure::input)?;
            (structure, Some(table))
        }
    };
    let fitted = Arx::new(structure).fit(&train);
    let model = fitted.map_err(|error| Failure::in_file(&path, error))?;
    let scores = validate(&model, &validation).map_err(|error| Failure::in_file(&path, error))?;
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
        warnings: imported.warnings.iter().map(ToString::to_string).collect(),
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
        text.push_str(&format!("chosen by MDL: order {}\n", orders.best_mdl()));
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
