//! What `gtfdi identify` says: one JSON object, or a table.

use std::collections::BTreeMap;
use std::path::Path;

use gtfdi::ident::eiv::{EivModel, EivOrderTable};
use gtfdi::ident::{ArxModel, ArxStructure, Channel, OrderTable, Validation};
use serde::Serialize;

use super::Orders;
use crate::cli::Method;
use crate::output::{number, table};

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
    /// When the first free run diverges, in seconds.
    pub diverges_at: Option<f64>,
    pub train_rows: [usize; 2],
    pub validation_rows: [usize; 2],
    pub outputs: Vec<OutputReport<'a>>,
    /// By output, in the order of its regression.
    pub standard_errors: Option<BTreeMap<&'a str, Vec<f64>>>,
    /// By channel; null for methods that take the inputs as exact.
    pub noise_variances: Option<BTreeMap<&'a str, f64>>,
    /// The same with what is known of them, outputs first.
    pub noise: Option<Vec<NoiseReport<'a>>>,
    pub order_table: Option<&'a Orders>,
    pub input_sha256: &'a str,
    pub warnings: Vec<String>,
    pub out: Option<&'a Path>,
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

#[derive(Serialize)]
struct RegressionTerm<'a> {
    signal: &'a str,
    lag: usize,
    coefficient: f64,
}

/// The noise of a channel.
#[derive(Serialize)]
pub struct NoiseReport<'a> {
    signal: &'a str,
    variance: f64,
    standard_error: Option<f64>,
    identifiable: Option<bool>,
    at_limit: bool,
}

/// The standard errors of the coefficients, by output.
pub fn standard_errors(model: &ArxModel) -> Option<BTreeMap<&str, Vec<f64>>> {
    let names = model.outputs().iter().map(|signal| signal.name.as_str());
    let errors = model.standard_errors()?;
    Some(names.zip(errors.iter().cloned()).collect())
}

/// The noise variances, by channel.
pub fn noise_variances(model: &EivModel) -> BTreeMap<&str, f64> {
    let noise = model.noise();
    noise
        .map(|(signal, noise)| (signal.name.as_str(), noise.variance))
        .collect()
}

/// The noise of the channels of a model.
pub fn noise_reports(model: &EivModel) -> Vec<NoiseReport<'_>> {
    let channels = model.noise().map(|(signal, noise)| NoiseReport {
        signal: &signal.name,
        variance: noise.variance,
        standard_error: noise.standard_error,
        identifiable: noise.identifiable(),
        at_limit: noise.at_limit,
    });
    channels.collect()
}

/// Every output's equation with its errors.
pub fn output_reports<'a>(model: &'a ArxModel, scores: &'a Validation) -> Vec<OutputReport<'a>> {
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

/// The table.
pub fn text(report: &Report, train_rows: usize) -> String {
    let mut text = format!(
        "{} identified on {} rows, validated on rows {}:{}\n",
        report.structure, train_rows, report.validation_rows[0], report.validation_rows[1]
    );
    match report.order_table {
        Some(Orders::Arx(orders)) => text += &arx_orders(orders),
        Some(Orders::Eiv(orders)) => text += &eiv_orders(orders),
        None => {}
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
    if let Some(noise) = &report.noise {
        let rows: Vec<Vec<String>> = noise
            .iter()
            .map(|channel| {
                vec![
                    channel.signal.to_owned(),
                    number(Some(channel.variance)),
                    number(channel.standard_error),
                    match channel.identifiable {
                        Some(true) => "yes",
                        Some(false) => "no",
                        None => "-",
                    }
                    .to_owned(),
                ]
            })
            .collect();
        text.push_str(&table(
            &[
                "channel",
                "noise variance",
                "standard error",
                "told by the record",
            ],
            &rows,
        ));
    }
    text
}

/// The criteria of ARX orders.
fn arx_orders(orders: &OrderTable) -> String {
    let rows = orders.rows.iter().map(|row| {
        let criteria = [row.aic, row.mdl].map(|value| format!("{value:.1}"));
        let errors = [row.fpe, row.ppcre_percent].map(|value| number(Some(value)));
        order_cells(
            row.order,
            row.parameters,
            criteria.into_iter().chain(errors),
        )
    });
    let head = ["order", "parameters", "AIC", "MDL", "FPE", "PPCRE %"];
    let table = table(&head, &rows.collect::<Vec<_>>());
    format!("{table}chosen by MDL: order {}\n", orders.best_mdl())
}

/// The criteria of errors-in-variables orders.
fn eiv_orders(orders: &EivOrderTable) -> String {
    let rows = orders.rows.iter().map(|row| {
        let criteria = [row.aic, row.bic].map(|value| format!("{value:.1}"));
        order_cells(row.order, row.parameters, criteria.into_iter())
    });
    let head = ["order", "parameters", "AIC", "BIC"];
    let table = table(&head, &rows.collect::<Vec<_>>());
    let best = orders.best_bic();
    format!("{table}chosen by the likelihood's BIC: order {best}\n")
}

/// A row of a table of orders.
fn order_cells(
    order: usize,
    parameters: usize,
    criteria: impl Iterator<Item = String>,
) -> Vec<String> {
    let counts = [order, parameters].map(|count| count.to_string());
    counts.into_iter().chain(criteria).collect()
}
