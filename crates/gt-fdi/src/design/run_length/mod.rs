//! How long detectors run before they alarm, computed before any is built.

mod cusum;
mod delay_bound;
mod exceedance;
mod markov;
mod normal;
mod quadrature;
mod root;
mod run_sum;
mod shiryaev_roberts;
mod simulation;

pub use cusum::{CusumRunLength, MAX_CUSUM_THRESHOLD};
pub use delay_bound::mean_delay_bound;
pub use exceedance::{ExceedanceRunLength, MAX_CONSECUTIVE};
pub use run_sum::{MAX_RUN_SUM_THRESHOLD, RunSumRunLength};
pub use shiryaev_roberts::{
    MAX_SHIRYAEV_ROBERTS_THRESHOLD, SHIRYAEV_ROBERTS_SHIFTS, ShiryaevRobertsRunLength,
};
pub use simulation::{MIN_ALARMS, SimulatedRunLength, SimulatedRuns};

use crate::FdiError;

/// The longest average run length that is computed, in samples: 2500 years at 0.08 s.
pub const MAX_RUN_LENGTH: f64 = 1e12;

/// Refuses an average run length outside `low..=MAX_RUN_LENGTH`, NaN included.
fn check_run_length(found: f64, low: f64) -> Result<(), FdiError> {
    if found >= low && found <= MAX_RUN_LENGTH {
        return Ok(());
    }
    let high = MAX_RUN_LENGTH;
    Err(FdiError::RunLength { low, high, found })
}

/// Refuses a NaN or infinite `option`.
fn check_finite(option: &'static str, found: f64) -> Result<(), FdiError> {
    check(option, "a finite number", found, found.is_finite())
}

/// Refuses `option` unless it `fits`.
fn check(
    option: &'static str,
    expected: &'static str,
    found: f64,
    fits: bool,
) -> Result<(), FdiError> {
    if fits {
        return Ok(());
    }
    Err(FdiError::Option {
        option,
        expected,
        found,
    })
}
