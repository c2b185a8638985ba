//! Decisions on one residual, sample by sample.

mod adaptive_threshold;
mod chi_square;
mod cusum;
mod cusum_fleet;
mod error;
mod glr;
mod growing_chi_square;
mod growing_variance;
mod growth;
mod history;
mod moments;
mod moving_average;
mod normal_score;
mod run_sum;
mod shiryaev_roberts;
mod sides;
mod sliding_moments;
mod sliding_sum;
mod sprt;
mod statistic;
mod waveform;
mod whiteness;
mod windowed_variance;

pub use adaptive_threshold::AdaptiveThreshold;
pub use chi_square::WindowedChiSquare;
pub use cusum::Cusum;
pub use cusum_fleet::CusumFleet;
pub use error::StatisticError;
pub use glr::{Change, Glr};
pub use growing_chi_square::GrowingChiSquare;
pub use growing_variance::GrowingVariance;
pub use growth::Growth;
pub use moving_average::MovingAverage;
pub use run_sum::RunSum;
pub use shiryaev_roberts::ShiryaevRoberts;
pub use sides::Sides;
pub use sprt::{Sprt, SprtDecision};
pub use statistic::{Decision, LARGEST_SAMPLE, Statistic};
pub use waveform::Waveform;
pub use whiteness::{MAX_LAGS, Whiteness};
pub use windowed_variance::WindowedVariance;

/// The longest window of any statistic, in samples.
pub const MAX_WINDOW: usize = 65_536;

/// Refuses a window of no samples or of more than [`MAX_WINDOW`].
fn check_window(found: usize) -> Result<(), StatisticError> {
    if (1..=MAX_WINDOW).contains(&found) {
        return Ok(());
    }
    let longest = MAX_WINDOW;
    Err(StatisticError::Window { longest, found })
}

/// Refuses a threshold that is not positive and finite.
fn check_threshold(found: f64) -> Result<(), StatisticError> {
    if found.is_finite() && found > 0.0 {
        return Ok(());
    }
    Err(StatisticError::Threshold { found })
}

/// Refuses the option that is called `option` unless it `fits`.
fn check_option(
    option: &'static str,
    expected: &'static str,
    found: f64,
    fits: bool,
) -> Result<(), StatisticError> {
    if fits {
        return Ok(());
    }
    Err(StatisticError::Option {
        option,
        expected,
        found,
    })
}

/// Refuses a number of a saved state that is NaN, infinite or outside `low..=high`.
fn check_state(what: &'static str, found: f64, low: f64, high: f64) -> Result<(), StatisticError> {
    if (low..=high).contains(&found) {
        return Ok(());
    }
    Err(StatisticError::State {
        what,
        low,
        high,
        found,
    })
}
