//! The equations of a model, with the channels by name.

use gtfdi::ident::{ArxModel, Channel};
use serde::Serialize;

/// A term `coefficient * signal(t - lag)`.
#[derive(Serialize)]
pub struct RegressionTerm<'a> {
    pub signal: &'a str,
    pub lag: usize,
    pub coefficient: f64,
    /// Null where the method or the file gives none.
    pub standard_error: Option<f64>,
}

/// The terms of each output's equation.
pub fn regressions(model: &ArxModel) -> Vec<Vec<RegressionTerm<'_>>> {
    let signal = |channel: Channel| match channel {
        Channel::Output(index) => model.outputs()[index].name.as_str(),
        Channel::Input(index) => model.inputs()[index].name.as_str(),
    };
    let errors = model.standard_errors();
    let rows = model.rows().iter().enumerate();
    rows.map(|(output, row)| {
        let terms = row.terms.iter().enumerate();
        terms
            .map(|(index, term)| RegressionTerm {
                signal: signal(term.channel),
                lag: term.lag,
                coefficient: term.coefficient,
                standard_error: errors.map(|errors| errors[output][index]),
            })
            .collect()
    })
    .collect()
}
