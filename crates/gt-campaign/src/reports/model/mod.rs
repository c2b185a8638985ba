//! What was identified from records, and how far to trust it.

mod behaviour;
mod correlation;
mod equations;
mod response;
mod roots;

pub(crate) use response::response_figures;
pub(crate) use roots::pole_figures;

use gtfdi::core::{Dataset, Stop, Stopped};
use gtfdi::ident::eiv::EivModel;
use gtfdi::ident::{ArxModel, Start, Validation, exact_coefficients};
use nalgebra::DMatrix;

use super::clock::Clock;
use super::detection::fold;
use super::provenance::Provenance;
use super::signals::record_figures;
use crate::report::page::{Cell, Page};
use crate::report::text::digits;
use crate::report::{Document, Figure};

/// A model with what it was made from.
pub struct ModelReport<'a> {
    /// The equations.
    pub model: &'a ArxModel,
    /// How they were found: `arx`, `frisch` or `eiv`.
    pub method: &'a str,
    /// The noise on the channels, where the method gives it.
    pub noise: Option<&'a EivModel>,
    /// Covariances of the coefficients of each row, where the method gives them.
    pub covariances: Option<&'a [DMatrix<f64>]>,
    /// Samples of the fit.
    pub train_samples: usize,
    /// The records that it is judged on.
    pub validation: &'a [&'a Dataset],
    /// The errors on them.
    pub scores: &'a Validation,
    /// Where free runs start.
    pub start: Start,
    /// The comparison of orders: a chart, its table (heads, rows) and why the order was taken.
    pub orders: Option<Orders>,
    /// What the tests object to, in words.
    pub findings: Vec<String>,
}

/// What is known of the errors of a model's coefficients.
pub(crate) struct Certainty {
    /// Their covariance, of each row; zeros where it is not known.
    covariances: Vec<DMatrix<f64>>,
    known: bool,
}

impl Certainty {
    pub(crate) fn of(model: &ArxModel, covariances: Option<&[DMatrix<f64>]>) -> Self {
        Self {
            known: covariances.is_some(),
            covariances: covariances.map_or_else(|| exact_coefficients(model), <[_]>::to_vec),
        }
    }
}

/// The comparison of orders.
pub struct Orders {
    /// The criteria over the order.
    pub figure: Figure,
    /// Heads of the table.
    pub head: Vec<String>,
    /// A row an order.
    pub rows: Vec<Vec<String>>,
    /// Why the order was taken.
    pub reason: String,
}

/// The report of a model: its equations with their errors, predictions and free runs on the
/// validation records, tests of the one-step errors, poles, zeros and frequency responses.
///
/// # Errors
/// [`Stopped`] where `stop` wants the work to end.
pub fn model_report(
    report: &ModelReport,
    provenance: &Provenance,
    stop: &dyn Stop,
) -> Result<Document, Stopped> {
    let model = report.model;
    let validated: usize = report.validation.iter().map(|data| data.len()).sum();
    let lead = format!(
        "{} by {}, identified on {} samples of {} s, judged on {validated}.",
        model.structure(),
        report.method,
        report.train_samples,
        model.sample_time_s()
    );
    let mut page = Page::new("Model", &lead);
    page.facts(&facts(report));
    provenance.warn(&mut page);
    let mut figures = Vec::new();
    fits(&mut page, report);
    if let Some(orders) = &report.orders {
        page.section("orders", "Orders compared");
        page.paragraph(&orders.reason);
        page.figure(&orders.figure);
        let head: Vec<&str> = orders.head.iter().map(String::as_str).collect();
        let rows = orders.rows.iter().cloned();
        let rows: Vec<Vec<Cell>> = rows
            .map(|row| row.into_iter().map(Cell::plain).collect())
            .collect();
        page.table(&head, &rows);
        figures.push(orders.figure.clone());
    }
    let longest = report.validation.iter().max_by_key(|data| data.len());
    if let Some(data) = longest {
        page.section("behaviour", "Prediction and free run");
        page.paragraph(
            "The prediction sees the measured outputs up to one sample before; the free run sees \
             the inputs alone. They are on the longest validation record.",
        );
        show(&mut page, &mut figures, behaviour::figures(report, data));
        correlation::section(&mut page, &mut figures, report, data, stop)?;
    }
    stop.check()?;
    equations::section(&mut page, report);
    let certainty = Certainty::of(model, report.covariances);
    roots::section(&mut page, &mut figures, model, &certainty);
    response::section(&mut page, &mut figures, model, &certainty);
    if let Some(data) = longest {
        page.section("record", "Record");
        let record = record_figures(data, Clock::of(data), &[]);
        fold(
            &mut page,
            "Inputs and outputs of the validation record",
            &record,
        );
        figures.extend(record);
    }
    Ok(Document {
        html: provenance.finish(page),
        figures,
    })
}

/// Puts figures on the page and keeps them for their files.
fn show(page: &mut Page, figures: &mut Vec<Figure>, new: Vec<Figure>) {
    for figure in &new {
        page.figure(figure);
    }
    figures.extend(new);
}

fn facts(report: &ModelReport) -> Vec<(String, String)> {
    let outputs = &report.scores.outputs;
    let range = |values: Vec<f64>| {
        let low = values.iter().copied().fold(f64::INFINITY, f64::min);
        let high = values.iter().copied().fold(f64::NEG_INFINITY, f64::max);
        match values.len() {
            0 => "-".to_owned(),
            1 => format!("{} %", digits(low, 4)),
            _ => format!("{} .. {} %", digits(low, 4), digits(high, 4)),
        }
    };
    let simulated: Vec<f64> = outputs
        .iter()
        .filter_map(|own| own.fit_simulation_percent)
        .collect();
    let diverged = outputs.len() - simulated.len();
    let radius = report.model.state_space().ok();
    let radius = radius.and_then(|system| system.spectral_radius().ok());
    vec![
        (
            range(
                outputs
                    .iter()
                    .map(|own| own.fit_prediction_percent)
                    .collect(),
            ),
            "fit one step ahead".to_owned(),
        ),
        (
            range(simulated),
            match diverged {
                0 => "fit of the free run".to_owned(),
                _ => format!("fit of the free run; {diverged} outputs diverge"),
            },
        ),
        (
            radius.map_or_else(|| "-".to_owned(), |own| digits(own, 5)),
            "modulus of the largest pole".to_owned(),
        ),
    ]
}

fn fits(page: &mut Page, report: &ModelReport) {
    page.section("fits", "Errors on the validation records");
    let optional = |own: Option<f64>| own.map_or_else(|| "-".to_owned(), |own| digits(own, 4));
    let rows: Vec<Vec<Cell>> = report
        .scores
        .outputs
        .iter()
        .map(|own| {
            let free = own.diverges_at_s.map_or_else(
                || optional(own.fit_simulation_percent),
                |time_s| format!("diverges at {} s", digits(time_s, 4)),
            );
            let cells = [
                own.name.clone(),
                digits(own.fit_prediction_percent, 4),
                free,
                digits(own.ppcre_prediction_percent, 4),
                optional(own.ppcre_simulation_percent),
            ];
            cells.into_iter().map(Cell::plain).collect()
        })
        .collect();
    page.table(
        &[
            "output",
            "fit prediction %",
            "fit simulation %",
            "PPCRE prediction %",
            "PPCRE simulation %",
        ],
        &rows,
    );
    page.note(
        "Fit: 100 (1 - |error| / |output - its mean|), Euclidean norms over the samples. PPCRE: the \
         standard deviation of the error in per cent of the output's.",
    );
    if report.start == Start::Fitted {
        page.note(
            "Free runs start where they fit the record best, because the first samples hold noise.",
        );
    }
    if !report.findings.is_empty() {
        page.heading("What the tests object to");
    }
    for finding in &report.findings {
        page.paragraph(finding);
    }
}
