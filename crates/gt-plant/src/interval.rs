//! Numbers of a scenario within their limits.

use crate::PlantError;

/// Accepts a number from `low` to `high`; NaN is in no interval.
///
/// # Errors
/// [`PlantError::Scenario`].
pub(crate) fn within(
    what: &'static str,
    found: f64,
    [low, high]: [f64; 2],
    expected: &'static str,
) -> Result<(), PlantError> {
    if found >= low && found <= high {
        return Ok(());
    }
    Err(PlantError::Scenario {
        what,
        expected,
        found,
    })
}
