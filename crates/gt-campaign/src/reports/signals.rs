//! Charts of channels, and names of figures.

use gtfdi::core::{Dataset, Signal};

use super::clock::Clock;
use crate::report::Figure;
use crate::report::chart::{Chart, Mark, Series};
use crate::report::text::digits;

/// The name of a figure's files: a kind, a number that makes it unique and the tag as far as file
/// names take it.
pub(super) fn figure_id(kind: &str, number: usize, tag: &str) -> String {
    let plain = tag.chars().take(40).map(|own| match own {
        'a'..='z' | 'A'..='Z' | '0'..='9' | '-' => own,
        _ => '_',
    });
    format!("{kind}_{:02}_{}", number + 1, plain.collect::<String>())
}

/// A channel with its unit, for an axis.
pub(super) fn axis_label(what: &str, unit: &str) -> String {
    match unit {
        "" => what.to_owned(),
        unit => format!("{what} [{unit}]"),
    }
}

/// How much of a record there is, in words.
pub(super) fn extent(data: &Dataset) -> String {
    format!(
        "{} samples of {} s each, {} h",
        data.len(),
        data.sample_time_s(),
        digits(data.sample_time_s() * data.len() as f64 / 3600.0, 3)
    )
}

/// A row of a matrix whose columns are samples.
pub(super) fn row(values: &nalgebra::DMatrix<f64>, row: usize) -> Vec<f64> {
    values.row(row).iter().copied().collect()
}

/// The inputs and outputs of a record, a chart a channel.
pub(super) fn record_figures(data: &Dataset, clock: Clock, marks: &[Mark]) -> Vec<Figure> {
    let inputs = data.inputs().iter().enumerate();
    let inputs = inputs.map(|(place, signal)| ("input", place, signal, row(data.u(), place)));
    let outputs = data.outputs().iter().enumerate();
    let outputs = outputs.map(|(place, signal)| ("output", place, signal, row(data.y(), place)));
    inputs
        .chain(outputs)
        .map(|(kind, place, Signal { name, unit, .. }, values)| {
            let chart = Chart {
                id: figure_id(kind, place, name),
                title: format!("{name}, {kind}"),
                x_label: clock.label(),
                y_label: axis_label(name, unit),
                x: clock.times_s(data),
                series: vec![Series::line(name, values)],
                marks: marks.to_vec(),
                ..Chart::default()
            };
            Figure::new(chart, format!("Measured {kind} {name}."))
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_of_figures_are_names_of_files() {
        assert_eq!(figure_id("input", 0, "M_f"), "input_01_M_f");
        assert_eq!(
            figure_id("output", 11, "../10TT 2001.PV"),
            "output_12____10TT_2001_PV"
        );
        assert!(figure_id("output", 0, &"x".repeat(500)).len() < 60);
    }
}
