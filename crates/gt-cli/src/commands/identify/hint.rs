//! What to do about a record that cannot be fitted.

use gtfdi::core::DataError;
use gtfdi::ident::{Dependence, IdentError};

/// The advice that goes with an error, where there is any; `ridge` tells whether the fit takes one.
pub fn hint(error: &IdentError, ridge: bool) -> Option<&'static str> {
    match error {
        IdentError::RankDeficient { dependence, .. } => match (&**dependence, ridge) {
            (Dependence::Multiple { .. } | Dependence::Combination { .. }, true) => {
                Some("leave one of them out, or hold them with --ridge")
            }
            (Dependence::Multiple { .. } | Dependence::Combination { .. }, false) => {
                Some("leave one of them out")
            }
            (Dependence::Excitation, true) => {
                Some("use fewer lags, rows in which it moves (--train), or hold it with --ridge")
            }
            (Dependence::Excitation, false) => {
                Some("use fewer lags, or rows in which it moves (--train)")
            }
            (Dependence::Unclear, true) => Some("or hold the coefficients with --ridge"),
            (Dependence::Unclear, false) => None,
        },
        IdentError::TooFewRows { .. } | IdentError::EivTooFewSamples { .. } => {
            Some("use more rows or fewer lags")
        }
        IdentError::ConstantChannel { .. } => {
            Some("leave the channel out, or choose rows in which it moves (--train)")
        }
        IdentError::EivDetermined { .. } => {
            Some("leave the channel out, or take its noise for none with --method arx")
        }
        IdentError::Data(DataError::NotFinite { found, .. }) if found.is_nan() => {
            Some("--missing break fits around it")
        }
        _ => None,
    }
}
