//! Decisions on one residual, sample by sample.

mod chi_square;
mod cusum;
mod error;
mod glr;
mod history;
mod moving_average;
mod sides;
mod sliding_sum;
mod sprt;
mod statistic;
mod waveform;

pub use chi_square::WindowedChiSquare;
pub use cusum::Cusum;
pub use error::StatisticError;
pub use glr::{Change, Glr};
pub use moving_average::MovingAverage;
pub use sides::Sides;
pub use sprt::{Sprt, SprtDecision};
pub use statistic::{Decision, LARGEST_SAMPLE, Statistic};
pub use waveform::Waveform;

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
