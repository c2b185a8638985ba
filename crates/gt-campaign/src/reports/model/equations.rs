//! The equations with their errors, and the noise on the channels.

use gtfdi::ident::Channel;

use super::ModelReport;
use crate::report::page::{Cell, Page};
use crate::report::text::digits;

/// A table an output, and the noise.
pub(super) fn section(page: &mut Page, report: &ModelReport) {
    let model = report.model;
    page.section("equations", "Equations");
    page.paragraph(
        "Each output is the sum of the coefficients times the deviations of the signals, so many \
         samples ago, from the operating point.",
    );
    let name = |channel: Channel| match channel {
        Channel::Output(index) => &model.outputs()[index].name,
        Channel::Input(index) => &model.inputs()[index].name,
    };
    let errors = model.standard_errors();
    for (output, row) in model.rows().iter().enumerate() {
        let terms = row.terms.iter().enumerate();
        let rows: Vec<Vec<Cell>> = terms
            .map(|(index, term)| {
                let error = errors.map(|errors| errors[output][index]);
                let share = error.map(|error| error / term.coefficient.abs());
                let optional =
                    |own: Option<f64>| own.map_or_else(|| "-".to_owned(), |own| digits(own, 3));
                let cells = [
                    name(term.channel).clone(),
                    term.lag.to_string(),
                    digits(term.coefficient, 6),
                    optional(error),
                    optional(share.map(|share| 100.0 * share)),
                ];
                cells.into_iter().map(Cell::plain).collect()
            })
            .collect();
        let summary = format!("{} ({} terms)", model.outputs()[output].name, rows.len());
        page.fold(&summary, model.outputs().len() == 1, |page| {
            page.table(
                &["signal", "lag", "coefficient", "standard error", "in %"],
                &rows,
            );
        });
    }
    noise(page, report);
}

fn noise(page: &mut Page, report: &ModelReport) {
    let Some(model) = report.noise else {
        return;
    };
    page.section("noise", "Noise on the channels");
    let rows: Vec<Vec<Cell>> = model
        .noise()
        .map(|(signal, noise)| {
            let told = match noise.identifiable() {
                _ if noise.at_limit => "no, at a limit",
                Some(true) => "yes",
                Some(false) => "no",
                None => "-",
            };
            let error = noise.standard_error;
            vec![
                Cell::plain(signal.name.clone()),
                Cell::plain(digits(noise.variance, 4)),
                Cell::plain(error.map_or_else(|| "-".to_owned(), |own| digits(own, 3))),
                Cell::plain(digits(noise.variance.sqrt(), 4)),
                Cell::plain(signal.unit.clone()),
                Cell::plain(told),
            ]
        })
        .collect();
    page.table(
        &[
            "channel",
            "variance",
            "standard error",
            "deviation",
            "unit",
            "told by the record",
        ],
        &rows,
    );
}
