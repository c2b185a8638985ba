//! The options `--stable` and `--dc-gain`.

use gtfdi::core::DataError;
use gtfdi::ident::constrained::{ConstrainedArx, ConstrainedFit, DcGain};
use gtfdi::ident::{ArxStructure, IdentError};

use super::records::Records;
use crate::cli::IdentifyArgs;
use crate::failure::Failure;

/// A steady-state gain that is known.
#[derive(Debug)]
struct KnownGain {
    output: String,
    input: String,
    gain: DcGain,
}

/// The constraints of a fit.
pub struct Constraints {
    radius: Option<f64>,
    gains: Vec<KnownGain>,
}

impl Constraints {
    /// The constraints that the options ask for, where they ask for any.
    pub fn of(args: &IdentifyArgs) -> Result<Option<Self>, Failure> {
        let wishes = args.dc_gain.iter().flatten();
        let constraints = Self {
            radius: args.stable,
            gains: wishes
                .map(|wish| known_gain(wish))
                .collect::<Result<_, _>>()?,
        };
        if constraints.radius.is_none() && constraints.gains.is_empty() {
            return Ok(None);
        }
        let others = [
            ("--ridge", args.ridge.is_some()),
            ("--centre", args.centre.is_some()),
            ("--equation-errors", args.equation_errors.is_some()),
            ("--solver", args.solver.is_some()),
        ];
        match others.into_iter().find(|(_, given)| *given) {
            Some((option, _)) => Err(Failure::input(format!(
                "{option}: expected without --stable and --dc-gain, found it beside {}",
                constraints.option()
            ))),
            None => Ok(Some(constraints)),
        }
    }

    /// The option by which the constraints were asked for.
    fn option(&self) -> &'static str {
        if self.radius.is_some() {
            "--stable"
        } else {
            "--dc-gain"
        }
    }

    /// Fits under the constraints.
    pub fn fit(
        &self,
        structure: ArxStructure,
        records: &Records,
    ) -> Result<ConstrainedFit, Failure> {
        let train = Records::one(self.option(), "training", &records.train)?;
        let mut arx = ConstrainedArx::new(structure);
        if let Some(radius) = self.radius {
            arx = arx.max_radius(radius);
        }
        for known in &self.gains {
            arx = arx.dc_gain(known.output.as_str(), known.input.as_str(), known.gain);
        }
        arx.fit(train).map_err(|error| match &error {
            IdentError::NotDiagonal { structure, .. } => Failure::input(format!(
                "{}: expected --structure diag, found {structure}",
                self.option()
            )),
            IdentError::OptionRange {
                expected, found, ..
            } => Failure::input(format!(
                "--stable: expected a radius {expected}, found {found}"
            )),
            IdentError::GainRange { .. }
            | IdentError::GainWithoutTerms { .. }
            | IdentError::Data(DataError::UnknownChannel { .. }) => {
                Failure::input(format!("--dc-gain: {error}"))
            }
            _ => records.refused(&error),
        })
    }
}

/// Reads `OUTPUT:INPUT=VALUE`, a range `LOW..HIGH` or a sign in the value's place.
fn known_gain(text: &str) -> Result<KnownGain, Failure> {
    let bad = || {
        Failure::input(format!(
            "--dc-gain: expected OUTPUT:INPUT=VALUE, LOW..HIGH, + or - in the value's place, such \
             as y:u=+, found `{text}`"
        ))
    };
    let (channels, value) = text.split_once('=').ok_or_else(bad)?;
    let (output, input) = channels.split_once(':').ok_or_else(bad)?;
    let number = |text: &str| text.trim().parse::<f64>().map_err(|_| bad());
    let gain = match value.trim() {
        "+" => DcGain::Positive,
        "-" => DcGain::Negative,
        value => match value.split_once("..") {
            Some((low, high)) => DcGain::Between(number(low)?, number(high)?),
            None => DcGain::Equal(number(value)?),
        },
    };
    Ok(KnownGain {
        output: output.trim().to_owned(),
        input: input.trim().to_owned(),
        gain,
    })
}

#[cfg(test)]
mod tests {
    use gtfdi::ident::constrained::DcGain;

    use super::known_gain;

    #[test]
    fn gains_are_a_value_a_range_or_a_sign() {
        for (text, gain) in [
            ("y:u=-2.5", DcGain::Equal(-2.5)),
            ("y:u=-2..3e1", DcGain::Between(-2.0, 30.0)),
            ("y : u = +", DcGain::Positive),
            ("y:u=-", DcGain::Negative),
        ] {
            let known = known_gain(text).expect(text);
            assert_eq!((known.output.as_str(), known.input.as_str()), ("y", "u"));
            assert_eq!(known.gain, gain, "{text}");
        }
        for bad in ["", "y:u", "y=3", "y:u=", "y:u=high", "y:u=1..", "y:u=..2"] {
            let error = known_gain(bad).expect_err(bad);
            let text = error.error().to_string();
            assert!(text.ends_with(&format!("found `{bad}`")), "{text}");
        }
    }
}
