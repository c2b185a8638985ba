//! Statistics in words.

use gtfdi::fdi::{StatisticKind, Waveform};

use crate::report::text::digits;

/// What a test computes of its residual.
pub(super) fn words(statistic: &StatisticKind) -> String {
    let number = |value: f64| digits(value, 3);
    match *statistic {
        StatisticKind::Modulus => "modulus of the residual".to_owned(),
        StatisticKind::Cusum { allowance } => {
            format!("CUSUM, allowance {} deviations", number(allowance))
        }
        StatisticKind::Glr {
            waveform,
            smallest,
            largest,
            longest,
        } => {
            let (form, unit) = match waveform {
                Waveform::Step => ("step", "deviations"),
                Waveform::Ramp => ("ramp", "deviations a sample"),
            };
            format!(
                "likelihood ratio of a {form} of {} to {} {unit}, windows up to {longest} samples",
                number(smallest),
                number(largest)
            )
        }
        StatisticKind::MovingAverage { window } => format!("mean of {window} samples"),
        StatisticKind::ChiSquare { window } => format!("sum of squares of {window} samples"),
        StatisticKind::ShiryaevRoberts { shift } => {
            format!("Shiryaev-Roberts for {} deviations", number(shift))
        }
        StatisticKind::Variance { window } => format!("variance of {window} samples"),
        StatisticKind::Whiteness { window, lags } => {
            format!("{lags} correlations of {window} samples")
        }
    }
}
