//! The noise of an errors-in-variables model.

use std::collections::BTreeMap;

use gtfdi::ident::eiv::EivModel;
use serde::Serialize;

use crate::output::{number, table};

/// Where free runs start that do not start at the measured outputs.
pub const FITTED_START: &str = "free runs start where they fit the record best: the first samples \
                                hold noise\n";

/// The noise of a channel.
#[derive(Serialize)]
pub struct NoiseReport<'a> {
    signal: &'a str,
    variance: f64,
    standard_error: Option<f64>,
    identifiable: Option<bool>,
    at_limit: bool,
}

/// The noise of the channels of a model, outputs first.
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

/// The noise variances, by channel.
pub fn noise_variances(model: &EivModel) -> BTreeMap<&str, f64> {
    let noise = model.noise();
    noise
        .map(|(signal, noise)| (signal.name.as_str(), noise.variance))
        .collect()
}

/// The noise as a table.
pub fn noise_text(noise: &[NoiseReport]) -> String {
    let rows: Vec<Vec<String>> = noise
        .iter()
        .map(|channel| {
            let told = match channel.identifiable {
                _ if channel.at_limit => "no, at a limit",
                Some(true) => "yes",
                Some(false) => "no",
                None => "-",
            };
            vec![
                channel.signal.to_owned(),
                number(Some(channel.variance)),
                number(channel.standard_error),
                told.to_owned(),
            ]
        })
        .collect();
    let head = [
        "channel",
        "noise variance",
        "standard error",
        "told by the record",
    ];
    table(&head, &rows)
}
