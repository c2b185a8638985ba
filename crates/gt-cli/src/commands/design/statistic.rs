//! The options that make a statistic of `gtfdi design`.

use gtfdi::fdi::{FdiError, Glr, StatisticError, StatisticKind, Waveform};

use crate::cli::{DesignArgs, Statistic, WaveformKind};
use crate::failure::Failure;

/// Ten seconds of the paper's sample time.
const AVERAGE_WINDOW: usize = 125;
/// Two seconds of it.
const SQUARES_WINDOW: usize = 25;

/// The statistic that the options describe.
///
/// # Errors
/// An option that the statistic does not have, or one out of its range.
pub fn statistic(args: &DesignArgs) -> Result<StatisticKind, Failure> {
    let kind = args.statistic.unwrap_or(Statistic::Threshold);
    let used: &[&str] = match kind {
        Statistic::Threshold => &[],
        Statistic::MovingAverage | Statistic::Chi2 => &["window"],
        Statistic::Cusum => &["allowance"],
        Statistic::Glr => &["window", "waveform", "sizes"],
    };
    let given = [
        (
            "window",
            args.window.is_some(),
            "moving-average, chi2 and glr",
        ),
        ("allowance", args.allowance.is_some(), "cusum"),
        ("waveform", args.waveform.is_some(), "glr"),
        ("sizes", args.sizes.is_some(), "glr"),
    ];
    for (option, given, owners) in given {
        if given && !used.contains(&option) {
            return Err(Failure::input(format!(
                "--{option}: expected with --statistic {owners}, found {}",
                name(kind)
            )));
        }
    }
    let window = |default: usize| args.window.unwrap_or(default);
    let statistic = match kind {
        Statistic::Threshold => StatisticKind::Modulus,
        Statistic::MovingAverage => StatisticKind::MovingAverage {
            window: window(AVERAGE_WINDOW),
        },
        Statistic::Chi2 => StatisticKind::ChiSquare {
            window: window(SQUARES_WINDOW),
        },
        Statistic::Cusum => StatisticKind::Cusum {
            allowance: args.allowance.unwrap_or(StatisticKind::DEFAULT_ALLOWANCE),
        },
        Statistic::Glr => {
            let (waveform, default) = match args.waveform {
                Some(WaveformKind::Step) => (Waveform::Step, StatisticKind::DEFAULT_STEPS),
                _ => (Waveform::Ramp, StatisticKind::DEFAULT_SLOPES),
            };
            let sizes = args.sizes.as_deref().map_or(Ok(default), sizes)?;
            StatisticKind::Glr {
                waveform,
                smallest: sizes.0,
                largest: sizes.1,
                longest: window(Glr::DEFAULT_LONGEST),
            }
        }
    };
    statistic.validate().map_err(|error| {
        let option = match error {
            FdiError::Statistic(StatisticError::Window { .. }) => "window",
            FdiError::Statistic(StatisticError::Allowance { .. }) => "allowance",
            _ => "sizes",
        };
        Failure::input(format!("--{option}: {error}"))
    })?;
    Ok(statistic)
}

/// The option's value that names a statistic.
pub fn name(kind: Statistic) -> &'static str {
    match kind {
        Statistic::Threshold => "threshold",
        Statistic::MovingAverage => "moving-average",
        Statistic::Cusum => "cusum",
        Statistic::Glr => "glr",
        Statistic::Chi2 => "chi2",
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
