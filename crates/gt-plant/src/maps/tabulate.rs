//! Writes an analytic map as a table.

use super::line::{SpeedLine, check_points};
use super::{Extrapolation, MapKind, SpeedLineTable};
use crate::PlantError;

impl SpeedLineTable {
    /// The table of a function: `range` gives the lowest and highest pressure ratio at a speed,
    /// `map` gives flow and efficiency at a speed and pressure ratio. Each line has
    /// `points_per_line` points at equal distances. The table refuses points outside; see
    /// [`with_extrapolation`](Self::with_extrapolation).
    ///
    /// # Errors
    ///
    /// As [`SpeedLineTable::new`].
    pub fn from_function(
        kind: MapKind,
        speeds: &[f64],
        points_per_line: usize,
        range: impl Fn(f64) -> (f64, f64),
        map: impl Fn(f64, f64) -> (f64, f64),
    ) -> Result<Self, PlantError> {
        let mut lines = Vec::new();
        for (index, &speed) in speeds.iter().enumerate() {
            check_points(index + 1, speed, points_per_line)?;
            let (low, high) = range(speed);
            let last = (points_per_line - 1) as f64;
            let pressure_ratio: Vec<f64> = (0..points_per_line)
                .map(|point| {
                    let share = point as f64 / last;
                    // Exact at both ends.
                    low * (1.0 - share) + high * share
                })
                .collect();
            let (flow, efficiency) = pressure_ratio
                .iter()
                .map(|&pressure_ratio| map(speed, pressure_ratio))
                .unzip();
            lines.push(SpeedLine {
                speed,
                pressure_ratio,
                flow,
                efficiency,
            });
        }
        Self::new(kind, Extrapolation::Refuse, lines)
    }
}
