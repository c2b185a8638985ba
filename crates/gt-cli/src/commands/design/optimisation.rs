//! What `gtfdi design` says of a search for poles.

use gtfdi::fdi::{Criterion, ObserverDesign, Start};
use gtfdi::ident::ArxModel;
use nalgebra::Complex;
use serde::Serialize;

use crate::output::{number, table};

/// One output of the model.
#[derive(Serialize)]
pub struct OutputReport<'a> {
    name: &'a str,
    /// How the poles of its observer were found; null without a search.
    optimisation: Option<Optimisation<'a>>,
}

/// How the poles of an observer were found.
#[derive(Serialize)]
struct Optimisation<'a> {
    criterion: Criterion,
    /// The largest modulus that a pole could have.
    radius: f64,
    /// `[re, im]` each.
    poles: &'a [Complex<f64>],
    /// The criterion on the training records.
    v: f64,
    /// The criterion on the validation records; null without any.
    v_validation: Option<f64>,
    /// The least that filters of the bound's class reach on the training records.
    bound: f64,
    /// The criterion of that filter on the validation records.
    bound_validation: Option<f64>,
    evaluations: usize,
    start: Start,
}

/// The outputs of a model with what a search found for each.
pub fn output_reports<'a>(
    model: &'a ArxModel,
    searched: &'a [Option<ObserverDesign>],
) -> Vec<OutputReport<'a>> {
    let outputs = model.outputs().iter().zip(searched);
    outputs
        .map(|(output, found)| OutputReport {
            name: &output.name,
            optimisation: found.as_ref().map(|found| Optimisation {
                criterion: found.criterion,
                radius: found.radius,
                poles: &found.poles,
                v: found.v,
                v_validation: found.v_validation,
                bound: found.bound.value,
                bound_validation: found.bound.validation,
                evaluations: found.evaluations,
                start: found.start,
            }),
        })
        .collect()
}

/// The search for people; nothing without one.
pub fn text(outputs: &[OutputReport]) -> String {
    let found = |output: &OutputReport| {
        let found = output.optimisation.as_ref()?;
        Some(vec![
            output.name.to_owned(),
            number(Some(found.v)),
            number(found.v_validation),
            number(Some(found.bound)),
            number(found.bound_validation),
            start(found.start),
            found.evaluations.to_string(),
            poles(found.poles),
        ])
    };
    let rows: Vec<Vec<String>> = outputs.iter().filter_map(found).collect();
    let first = outputs
        .iter()
        .find_map(|output| output.optimisation.as_ref());
    let Some(first) = first else {
        return String::new();
    };
    let (name, criterion) = match first.criterion {
        Criterion::FaultEnergy => ("V'", "fault-energy"),
        Criterion::Paper => ("V", "paper"),
    };
    let validation = format!("{name} validation");
    let columns = [
        "output",
        name,
        &validation,
        "bound",
        "bound validation",
        "start",
        "evaluations",
        "poles",
    ];
    format!(
        "\npoles of least {name} ({criterion}), modulus at most {}; validation records had no part in \
         the choice\n{}",
        number(Some(first.radius)),
        table(&columns, &rows)
    )
}

fn start(start: Start) -> String {
    match start {
        Start::Vertex { index } => format!("vertex {index}"),
        Start::Inner { index } => format!("inner vertex {index}"),
        Start::Diagonal { pole } => format!("all at {}", number(Some(pole))),
        Start::Random { index } => format!("random {index}"),
        Start::Evolution => "evolution".to_owned(),
    }
}

/// Pairs as one entry, in the order of the list.
fn poles(poles: &[Complex<f64>]) -> String {
    let shown = poles.iter().filter(|pole| pole.im >= 0.0);
    let shown = shown.map(|pole| {
        let re = number(Some(pole.re));
        if pole.im == 0.0 {
            re
        } else {
            format!("{re}±{}i", number(Some(pole.im)))
        }
    });
    shown.collect::<Vec<_>>().join(", ")
}
