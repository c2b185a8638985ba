//! The options that make a statistic of `gtfdi design`.

use gt_campaign::{StatisticChoice, StatisticName};
use gtfdi::fdi::{StatisticKind, Waveform};

use crate::cli::{DesignArgs, Statistic, WaveformKind};
use crate::failure::Failure;

/// The statistic that the options describe.
///
/// # Errors
/// An option that the statistic does not have, or one out of its range.
pub fn statistic(args: &DesignArgs) -> Result<StatisticKind, Failure> {
    let choice = StatisticChoice {
        name: name(args.statistic),
        window: args.window,
        allowance: args.allowance,
        waveform: args.waveform.map(|waveform| match waveform {
            WaveformKind::Ramp => Waveform::Ramp,
            WaveformKind::Step => Waveform::Step,
        }),
        sizes: args.sizes.as_deref().map(sizes).transpose()?,
    };
    choice
        .kind()
        .map_err(|refusal| Failure::input(format!("--{}: {}", refusal.option, refusal.reason)))
}

/// The name of the statistic that was chosen.
pub fn name(chosen: Option<Statistic>) -> StatisticName {
    match chosen {
        None | Some(Statistic::Threshold) => StatisticName::Threshold,
        Some(Statistic::MovingAverage) => StatisticName::MovingAverage,
        Some(Statistic::Cusum) => StatisticName::Cusum,
        Some(Statistic::Glr) => StatisticName::Glr,
        Some(Statistic::Chi2) => StatisticName::Chi2,
        Some(Statistic::ShiryaevRoberts) => StatisticName::ShiryaevRoberts,
        Some(Statistic::Variance) => StatisticName::Variance,
        Some(Statistic::Whiteness) => StatisticName::Whiteness,
    }
}

fn sizes(text: &str) -> Result<(f64, f64), Failure> {
    let number = |part: &str| part.trim().parse::<f64>().ok();
    text.split_once(':')
        .and_then(|(smallest, largest)| Some((number(smallest)?, number(largest)?)))
        .ok_or_else(|| {
            Failure::input(format!(
                "--sizes: expected two numbers such as 1e-4:1e-2, found `{text}`"
            ))
        })
}
