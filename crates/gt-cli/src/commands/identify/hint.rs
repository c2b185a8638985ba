//! What to do about a record that cannot be fitted.

use gtfdi::core::DataError;
use gtfdi::ident::{Dependence, IdentError};

/// The advice that goes with an error, where there is any.
pub fn hint(error: &IdentError) -> Option<&'static str> {
    match error {
        IdentError::RankDeficient { dependence, .. } => Some(match **dependence {
            Dependence::Multiple { .. } | Dependence::Combination { .. } => {
                "leave one of them out, or hold them with --ridge"
            }
            Dependence::Excitation => {
                "use fewer lags, rows in which it moves (--train), or hold it with --ridge"
            }
            Dependence::Unclear => "or hold the coefficients with --ridge",
        }),
        IdentError::TooFewRows { .. } => Some("use more rows or fewer lags"),
        IdentError::ConstantChannel { .. } => {
            Some("leave the channel out, or choose rows in which it moves (--train)")
        }
        IdentError::Data(DataError::NotFinite { found, .. }) if found.is_nan() => {
            Some("--missing break fits around it")
        }
        _ => None,
    }
}
