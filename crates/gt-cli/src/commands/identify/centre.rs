//! The option `--centre`.

use gtfdi::core::{OperatingPoint, Signal};
use gtfdi::ident::Centre;

use crate::failure::Failure;

/// Reads `means`, `zero` or `TAG=VALUE,..` with a value for each channel.
pub fn centre(text: &str, inputs: &[Signal], outputs: &[Signal]) -> Result<Centre, Failure> {
    match text.trim() {
        "means" => return Ok(Centre::Means),
        "zero" => return Ok(Centre::Zero),
        _ => {}
    }
    let bad = |found: &str| {
        Failure::input(format!(
            "--centre: expected means, zero or TAG=VALUE with a finite value for each channel, \
             found `{found}`"
        ))
    };
    let mut known: Vec<(&str, f64)> = Vec::new();
    for part in text.split(',') {
        let (tag, value) = part.split_once('=').ok_or_else(|| bad(part))?;
        let value = value
            .trim()
            .parse()
            .ok()
            .filter(|value: &f64| value.is_finite());
        let tag = tag.trim();
        if known.iter().any(|(other, _)| *other == tag) {
            return Err(bad(part));
        }
        known.push((tag, value.ok_or_else(|| bad(part))?));
    }
    let stranger = known.iter().map(|(tag, _)| *tag).find(|tag| {
        let mut names = inputs
            .iter()
            .chain(outputs)
            .map(|signal| signal.name.as_str());
        !names.any(|name| name == *tag)
    });
    if let Some(stranger) = stranger {
        return Err(Failure::input(format!(
            "--centre: expected selected channels, found `{stranger}`"
        )));
    }
    let values = |signals: &[Signal]| -> Result<Vec<f64>, Failure> {
        let of = |signal: &Signal| known.iter().find(|(tag, _)| *tag == signal.name);
        let missing = |signal: &Signal| {
            Failure::input(format!(
                "--centre: expected a value for each channel, found none for `{}`",
                signal.name
            ))
        };
        signals
            .iter()
            .map(|signal| {
                of(signal)
                    .map(|(_, value)| *value)
                    .ok_or_else(|| missing(signal))
            })
            .collect()
    };
    Ok(Centre::At(OperatingPoint {
        u: values(inputs)?.into(),
        y: values(outputs)?.into(),
    }))
}
