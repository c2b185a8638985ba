//! Frequency responses with their bands: a Bode diagram for each channel.

use gtfdi::ident::{ArxModel, Estimate, FrequencyPoint, IdentError, frequency_response};

use super::{Certainty, fold};
use crate::report::chart::{Chart, Series};
use crate::report::page::Page;
use crate::report::{Figure, Scale};
use crate::reports::signals::{axis_label, figure_id};

/// Frequencies of a diagram.
const POINTS: usize = 200;
/// Decades below half the sampling rate.
const DECADES: f64 = 4.0;
/// Probability that the truth lies in a band, at one frequency.
const CONFIDENCE: f64 = 0.95;
/// Channels that are shown open; more are folded away.
const OPEN: usize = 4;

/// Gain and phase from every input to every output.
pub(super) fn section(
    page: &mut Page,
    figures: &mut Vec<Figure>,
    model: &ArxModel,
    certainty: &Certainty,
) {
    if model.inputs().is_empty() {
        return;
    }
    page.section("response", "Frequency response");
    let all = match response_figures(model, certainty) {
        Ok(all) => all,
        Err(error) => {
            page.paragraph(&format!("Not computed: {error}."));
            return;
        }
    };
    page.note(if certainty.known {
        "Bands hold the truth with probability .95 at each frequency, to first order; where a band \
         of the gain would reach zero it ends."
    } else {
        "The method gives no covariance of the coefficients, so that no band is known."
    });
    let mut shown = all.iter();
    shown
        .by_ref()
        .take(2 * OPEN)
        .for_each(|figure| page.figure(figure));
    let rest: Vec<Figure> = shown.cloned().collect();
    fold(page, "More channels", &rest);
    figures.extend(all);
}

/// A chart of the gain and one of the phase for each channel, all inputs of the first output first.
///
/// # Errors
/// As [`frequency_response`].
pub(crate) fn response_figures(
    model: &ArxModel,
    certainty: &Certainty,
) -> Result<Vec<Figure>, IdentError> {
    let nyquist_hz = 0.5 / model.sample_time_s();
    let frequencies: Vec<f64> = (0..POINTS)
        .map(|k| {
            let down = DECADES * (1.0 - (k + 1) as f64 / POINTS as f64);
            nyquist_hz * 10f64.powf(-down)
        })
        .collect();
    let found = frequency_response(model, &certainty.covariances, &frequencies)?;
    let banded = certainty.known;
    let mut all = Vec::new();
    for (output, of) in model.outputs().iter().enumerate() {
        for (input, from) in model.inputs().iter().enumerate() {
            let channel = format!("{} to {}", from.name, of.name);
            let place = output * model.inputs().len() + input;
            let tag = format!("{}_{}", from.name, of.name);
            let unit = match (of.unit.as_str(), from.unit.as_str()) {
                ("", "") => String::new(),
                (of, from) => format!("{of}/{from}").trim_end_matches('/').to_owned(),
            };
            let estimates = |of: fn(&FrequencyPoint, usize, usize) -> Option<Estimate>| {
                found
                    .iter()
                    .map(|point| of(point, output, input))
                    .collect::<Vec<_>>()
            };
            let gain = curve("gain", &estimates(FrequencyPoint::magnitude), banded, 1.0);
            let degrees = 1f64.to_degrees();
            let mut phase = curve(
                "phase",
                &estimates(FrequencyPoint::phase_rad),
                banded,
                degrees,
            );
            unwrap_degrees(&mut phase);
            let chart = |kind: &str, y_label: String, y_scale, series| Chart {
                id: figure_id(kind, place, &tag),
                title: format!("{channel}: {kind}"),
                x_label: "frequency [Hz]".to_owned(),
                y_label,
                x: frequencies.clone(),
                series: vec![series],
                x_scale: Scale::Logarithmic,
                y_scale,
                ..Chart::default()
            };
            let gain = chart("gain", axis_label("gain", &unit), Scale::Logarithmic, gain);
            let phase = chart("phase", "phase [degrees]".to_owned(), Scale::Linear, phase);
            all.push(Figure::new(gain, format!("Gain from {channel}.")));
            all.push(Figure::new(phase, format!("Phase from {channel}.")));
        }
    }
    Ok(all)
}

/// Estimates over the frequency, scaled, with their band.
fn curve(label: &str, estimates: &[Option<Estimate>], banded: bool, scale: f64) -> Series {
    let values = estimates
        .iter()
        .map(|own| own.map_or(f64::NAN, |own| scale * own.value));
    let series = Series::line(label, values.collect());
    if !banded {
        return series;
    }
    let edge = |side: usize| {
        estimates
            .iter()
            .map(|own| own.and_then(|own| own.interval(CONFIDENCE)))
            .map(|ends| ends.map_or(f64::NAN, |ends| scale * ends[side]))
            .collect()
    };
    let (low, high) = (edge(0), edge(1));
    series.within(low, high)
}

/// Takes out the jumps of whole turns, and moves the band along.
fn unwrap_degrees(series: &mut Series) {
    let mut turns = 0.0;
    let mut last = f64::NAN;
    for (k, value) in series.values.iter_mut().enumerate() {
        let moved = *value + turns;
        if last.is_finite() && moved.is_finite() {
            turns -= 360.0 * ((moved - last) / 360.0).round();
        }
        *value += turns;
        if let Some(band) = &mut series.band {
            band.low[k] += turns;
            band.high[k] += turns;
        }
        if value.is_finite() {
            last = *value;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn phases_are_continuous_and_take_their_band_along() {
        let truth: Vec<f64> = (0..100).map(|k| -9.0 * f64::from(k)).collect();
        let wrapped: Vec<f64> = truth
            .iter()
            .map(|own| (own + 180.0).rem_euclid(360.0) - 180.0)
            .collect();
        let edge = |by: f64| wrapped.iter().map(|own| own + by).collect();
        let mut series = Series::line("phase", wrapped.clone()).within(edge(-1.0), edge(1.0));
        unwrap_degrees(&mut series);
        let band = series.band.expect("a band");
        for (k, truth) in truth.iter().enumerate() {
            assert!((series.values[k] - truth).abs() < 1e-9, "{k}");
            assert!((band.low[k] - truth + 1.0).abs() < 1e-9, "{k}");
            assert!((band.high[k] - truth - 1.0).abs() < 1e-9, "{k}");
        }
    }
}
