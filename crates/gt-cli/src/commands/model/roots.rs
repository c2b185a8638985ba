//! Poles and zeros as engineers read them.

use gtfdi::ident::pole_zero::{ChannelZeros, Pole, PoleZeroReport, Root};
use gtfdi::ident::{ArxModel, Estimate};
use serde::Serialize;

use crate::output::{number, table};

/// A pole.
#[derive(Serialize)]
pub struct PoleReport<'a> {
    /// The output that it belongs to; null for one of the whole model.
    output: Option<&'a str>,
    re: f64,
    im: f64,
    modulus: f64,
    /// Null outside the unit circle and at the origin.
    time_constant_s: Option<f64>,
    /// Natural frequency; null at the origin.
    frequency_hz: Option<f64>,
    damping: Option<f64>,
}

/// A zero of one channel.
#[derive(Serialize)]
pub struct ZeroReport<'a> {
    output: &'a str,
    input: &'a str,
    re: f64,
    im: f64,
    modulus: f64,
    /// Distance in the plane of z to the nearest pole that the channel shows: near 0 the two cancel.
    nearest_pole_distance: Option<f64>,
}

/// The poles of a report.
pub fn poles<'a>(model: &'a ArxModel, report: &PoleZeroReport) -> Vec<PoleReport<'a>> {
    let value = |estimate: Option<Estimate>| estimate.map(|estimate| estimate.value);
    let poles = report.poles.iter().map(|pole| {
        let root = &pole.root;
        PoleReport {
            output: pole
                .output
                .map(|output| model.outputs()[output].name.as_str()),
            re: root.value.re,
            im: root.value.im,
            modulus: root.value.norm(),
            time_constant_s: value(root.time_constant_s(model.sample_time_s())),
            frequency_hz: value(root.natural_frequency_hz(model.sample_time_s())),
            damping: value(root.damping()),
        }
    });
    poles.collect()
}

/// The zeros of a report, channel by channel; those at the origin are delays and left out.
pub fn zeros<'a>(model: &'a ArxModel, report: &PoleZeroReport) -> Vec<ZeroReport<'a>> {
    let mut zeros = Vec::new();
    for channel in &report.channels {
        for root in channel.zeros.iter().filter(|root| root.value.norm() > 0.0) {
            zeros.push(ZeroReport {
                output: &model.outputs()[channel.output].name,
                input: &model.inputs()[channel.input].name,
                re: root.value.re,
                im: root.value.im,
                modulus: root.value.norm(),
                nearest_pole_distance: nearest(root, &report.poles, channel),
            });
        }
    }
    zeros
}

fn nearest(zero: &Root, poles: &[Pole], channel: &ChannelZeros) -> Option<f64> {
    let shown = poles
        .iter()
        .filter(|pole| pole.output.is_none_or(|output| output == channel.output));
    shown
        .map(|pole| (pole.root.value - zero.value).norm())
        .min_by(f64::total_cmp)
}

/// A point of the plane of z.
fn place(re: f64, im: f64) -> String {
    let re = number(Some(re));
    if im == 0.0 {
        re
    } else {
        let sign = if im < 0.0 { '-' } else { '+' };
        format!("{re} {sign} {}i", number(Some(im.abs())))
    }
}

/// The poles as a table.
pub fn poles_text(poles: &[PoleReport]) -> String {
    let rows: Vec<Vec<String>> = poles
        .iter()
        .map(|pole| {
            vec![
                pole.output.unwrap_or("all outputs").to_owned(),
                place(pole.re, pole.im),
                number(Some(pole.modulus)),
                number(pole.time_constant_s),
                number(pole.frequency_hz),
                number(pole.damping),
            ]
        })
        .collect();
    let head = [
        "pole of",
        "place",
        "modulus",
        "time constant s",
        "frequency Hz",
        "damping",
    ];
    table(&head, &rows)
}

/// The zeros as a table.
pub fn zeros_text(zeros: &[ZeroReport]) -> String {
    let rows: Vec<Vec<String>> = zeros
        .iter()
        .map(|zero| {
            vec![
                format!("{} from {}", zero.output, zero.input),
                place(zero.re, zero.im),
                number(Some(zero.modulus)),
                number(zero.nearest_pole_distance),
            ]
        })
        .collect();
    let head = ["zero of", "place", "modulus", "to the nearest pole"];
    table(&head, &rows)
}
