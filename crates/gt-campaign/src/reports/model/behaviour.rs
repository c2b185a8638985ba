//! What a model says of a record beside what was measured.

use gtfdi::core::Dataset;
use nalgebra::DMatrix;

use super::ModelReport;
use crate::report::Figure;
use crate::report::chart::{Chart, Series};
use crate::reports::clock::Clock;
use crate::reports::signals::{axis_label, figure_id, row};

/// Measured, predicted and simulated, and the one-step error, for each output; what the model
/// refuses to compute is left out.
pub(super) fn figures(report: &ModelReport, data: &Dataset) -> Vec<Figure> {
    let model = report.model;
    let clock = Clock::of(data);
    let predicted = model.predict(data).ok();
    let free = model.simulate_from(data, report.start).ok();
    let errors = model.equation_error(data).ok();
    // The first samples are given, not computed.
    let computed = |values: &DMatrix<f64>, output: usize| {
        let mut values = row(values, output);
        let given = model.max_lag().min(values.len());
        values[..given].fill(f64::NAN);
        values
    };
    let chart = |kind: &str, output: usize, series: Vec<Series>| {
        let signal = &data.outputs()[output];
        Chart {
            id: figure_id(kind, output, &signal.name),
            title: format!("{}: {}", signal.name, kind.replace('_', " ")),
            x_label: clock.label(),
            y_label: axis_label(&signal.name, &signal.unit),
            x: clock.times_s(data),
            series,
            ..Chart::default()
        }
    };
    let mut figures = Vec::new();
    for (output, signal) in data.outputs().iter().enumerate() {
        let name = &signal.name;
        let mut series = vec![Series::line("measured", row(data.y(), output))];
        if let Some(predicted) = &predicted {
            series.push(Series::line("one step ahead", computed(predicted, output)));
        }
        if let Some(free) = &free {
            series.push(Series::dashed("free run", computed(&free.y, output)));
        }
        figures.push(Figure::new(
            chart("behaviour", output, series),
            format!("{name}, measured, predicted one step ahead and simulated from the inputs."),
        ));
        if let Some(errors) = &errors {
            let series = vec![Series::line("one-step error", computed(errors, output))];
            figures.push(Figure::new(
                chart("one_step_error", output, series),
                format!("{name}: measured less predicted."),
            ));
        }
    }
    figures
}
