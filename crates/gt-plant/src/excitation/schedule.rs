//! A schedule: points of (time in s, share of the design fuel flow) with straight lines between.

use crate::PlantError;
use crate::interval::within;

/// Share of the design fuel flow at a time: constant before the first and after the last point, 1
/// throughout where there is no point. The times increase from point to point.
pub fn share_at(points: &[[f64; 2]], time_s: f64) -> f64 {
    let after = points.partition_point(|point| point[0] <= time_s);
    let reached = after.checked_sub(1).and_then(|index| points.get(index));
    match (reached, points.get(after)) {
        (None, None) => 1.0,
        (Some(point), None) | (None, Some(point)) => point[1],
        (Some(from), Some(to)) => {
            from[1] + (to[1] - from[1]) * ((time_s - from[0]) / (to[0] - from[0]))
        }
    }
}

/// Whether the share changes at all.
pub fn varies(points: &[[f64; 2]]) -> bool {
    points
        .windows(2)
        .any(|pair| pair[0][1].to_bits() != pair[1][1].to_bits())
}

/// Refuses points that make no schedule.
pub(super) fn validate(points: &[[f64; 2]]) -> Result<(), PlantError> {
    let mut earliest_s = 0.0;
    let mut expected = "times of at least 0 s that are finite";
    for &[time_s, share] in points {
        within("fuel_schedule", time_s, [earliest_s, f64::MAX], expected)?;
        within(
            "fuel_schedule",
            share,
            [0.25, 1.25],
            "shares of design fuel flow between 0.25 and 1.25",
        )?;
        earliest_s = time_s.next_up();
        expected = "times that increase from point to point and are finite";
    }
    Ok(())
}
