//! Whether the one-step errors are white, and independent of the inputs.

use gtfdi::core::{Dataset, Stop, Stopped};
use gtfdi::ident::{
    Autocorrelation, ChiSquareTest, CrossCorrelation, IdentError, ResidualOptions,
    test_residuals_until,
};

use super::{ModelReport, fold};
use crate::report::Figure;
use crate::report::chart::{Chart, Series, Stroke};
use crate::report::page::{Cell, Page};
use crate::report::text::digits;
use crate::reports::signals::figure_id;

/// Correlations that are shown open; more are folded away.
const OPEN: usize = 8;

/// The tests on the longest validation record. Models with noise on the inputs are not tested, for
/// it colours their errors.
pub(super) fn section(
    page: &mut Page,
    figures: &mut Vec<Figure>,
    report: &ModelReport,
    data: &Dataset,
    stop: &dyn Stop,
) -> Result<(), Stopped> {
    page.section("residuals", "One-step errors");
    if report.noise.is_some() {
        page.paragraph("Not tested: the noise on the inputs colours them.");
        return Ok(());
    }
    let options = ResidualOptions::for_residuals(data.len().saturating_sub(report.model.max_lag()));
    let found = match test_residuals_until(report.model, data, &options, stop) {
        Ok(found) => found,
        Err(IdentError::Stopped(stopped)) => return Err(stopped),
        Err(error) => {
            page.paragraph(&format!("Not tested: {error}."));
            return Ok(());
        }
    };
    let p_value = |test: Option<&ChiSquareTest>| match test {
        Some(test) => Cell::judged(digits(test.p_value, 3), !test.rejects(options.significance)),
        None => Cell::plain("-"),
    };
    let tests = found.ljung_box.iter().zip(&found.independence);
    let rows: Vec<Vec<Cell>> = data
        .outputs()
        .iter()
        .zip(tests)
        .map(|(signal, (white, independent))| {
            vec![
                Cell::plain(signal.name.clone()),
                p_value(white.as_ref()),
                p_value(independent.as_ref()),
            ]
        })
        .collect();
    page.table(
        &["output", "p, white", "p, independent of past inputs"],
        &rows,
    );
    page.note(&format!(
        "Ljung-Box over {} lags and a chi-square test of the cross-correlations; red: rejected at \
         {}. Bands of the charts are at the same level, for one lag at a time.",
        options.lags,
        digits(options.significance, 2)
    ));
    let autocorrelations = found.autocorrelations.iter().enumerate();
    let mut all: Vec<Figure> = autocorrelations.map(auto).collect();
    let crossed = found.cross_correlations.iter().enumerate();
    all.extend(crossed.map(cross));
    let mut all_figures = all.iter();
    all_figures
        .by_ref()
        .take(OPEN)
        .for_each(|figure| page.figure(figure));
    let rest: Vec<Figure> = all_figures.cloned().collect();
    fold(page, "More correlations", &rest);
    figures.extend(all);
    Ok(())
}

fn auto((place, own): (usize, &Autocorrelation)) -> Figure {
    let lags: Vec<f64> = (0..own.values.len()).map(|lag| lag as f64).collect();
    // Lag 0 is 1 and has no band.
    let mut bands = own.bands.clone();
    bands.resize(own.values.len(), f64::NAN);
    correlation(
        figure_id("autocorrelation", place, &own.output),
        format!("autocorrelation of the error of {}", own.output),
        lags,
        own.values.clone(),
        &bands,
    )
}

fn cross((place, own): (usize, &CrossCorrelation)) -> Figure {
    #[allow(clippy::cast_precision_loss)] // lags are small
    let lags: Vec<f64> = own.lags.iter().map(|lag| *lag as f64).collect();
    let bands = vec![own.band; lags.len()];
    correlation(
        figure_id(
            "crosscorrelation",
            place,
            &format!("{}_{}", own.output, own.input),
        ),
        format!("error of {} with past {}", own.output, own.input),
        lags,
        own.values.clone(),
        &bands,
    )
}

fn correlation(
    id: String,
    title: String,
    lags: Vec<f64>,
    values: Vec<f64>,
    bands: &[f64],
) -> Figure {
    let none = vec![0.0; lags.len()];
    let edge = |sign: f64| bands.iter().map(|band| sign * band).collect();
    let caption = format!("{title}: by lag in samples, with the band of none.");
    let chart = Chart {
        id,
        title,
        x_label: "lag [samples]".to_owned(),
        y_label: "correlation".to_owned(),
        x: lags,
        series: vec![
            Series::line("correlation", values).drawn(Stroke::Rings),
            Series::dashed("none", none).within(edge(-1.0), edge(1.0)),
        ],
        ..Chart::default()
    };
    Figure::new(chart, caption)
}
