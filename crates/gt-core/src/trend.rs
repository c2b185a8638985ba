//! Straight lines in time through the channels of a record.

use nalgebra::{DMatrix, DVector};
use serde::{Deserialize, Serialize};

use crate::{Dataset, DimensionError};

/// How fast every channel of a record drifts, and around when the drift is nothing.
///
/// What is subtracted from a channel at time `t` is `slope (t - centre)`: a record without its trend
/// keeps its means. A slow drift of a sensor or of the weather that is in a record counts as gain of
/// the plant where it is left in.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Trend {
    /// Slopes of the inputs (nu), per second.
    pub u_slope_per_s: DVector<f64>,
    /// Slopes of the outputs (ny), per second.
    pub y_slope_per_s: DVector<f64>,
    /// The time at which nothing is subtracted, s.
    pub centre_time_s: f64,
}

impl Dataset {
    /// The lines that fit the channels best (least squares), around the middle of the record. Samples
    /// that are not finite are left out; a channel with fewer than two others has slope 0.
    pub fn trend(&self) -> Trend {
        let last = self.len().saturating_sub(1);
        let slopes = |signals: &DMatrix<f64>| -> DVector<f64> {
            let rows = signals.row_iter().map(|row| {
                let samples = row.iter().enumerate();
                let finite = samples.filter(|(_, value)| value.is_finite());
                slope(finite.map(|(k, &value)| (k as f64, value))) / self.sample_time_s()
            });
            DVector::from_iterator(signals.nrows(), rows)
        };
        Trend {
            u_slope_per_s: slopes(self.u()),
            y_slope_per_s: slopes(self.y()),
            centre_time_s: self.start_time_s() + 0.5 * last as f64 * self.sample_time_s(),
        }
    }

    /// The record without a trend, of this record or of another one.
    ///
    /// # Errors
    /// [`DimensionError`] for a trend of other numbers of channels.
    pub fn detrended(&self, trend: &Trend) -> Result<Self, DimensionError> {
        self.tilted(trend, -1.0)
    }

    /// The record with a trend put back: what [`Dataset::detrended`] took.
    ///
    /// # Errors
    /// [`DimensionError`] for a trend of other numbers of channels.
    pub fn retrended(&self, trend: &Trend) -> Result<Self, DimensionError> {
        self.tilted(trend, 1.0)
    }

    fn tilted(&self, trend: &Trend, sign: f64) -> Result<Self, DimensionError> {
        let (u, y) = (&trend.u_slope_per_s, &trend.y_slope_per_s);
        DimensionError::check("input slopes of the trend", self.nu(), u.len())?;
        DimensionError::check("output slopes of the trend", self.ny(), y.len())?;
        let tilt = |signals: &DMatrix<f64>, slopes: &DVector<f64>| {
            let mut tilted = signals.clone();
            for (k, mut column) in tilted.column_iter_mut().enumerate() {
                column.axpy(sign * (self.time_s(k) - trend.centre_time_s), slopes, 1.0);
            }
            tilted
        };
        Ok(self.with_samples(tilt(self.u(), u), tilt(self.y(), y)))
    }
}

/// The slope of the line through some points; 0 where they do not tell one.
fn slope(points: impl Iterator<Item = (f64, f64)> + Clone) -> f64 {
    let (mut count, mut x_sum, mut y_sum) = (0.0, 0.0, 0.0);
    for (x, y) in points.clone() {
        count += 1.0;
        x_sum += x;
        y_sum += y;
    }
    let (x_mean, y_mean) = (x_sum / count, y_sum / count);
    let (mut squares, mut products) = (0.0, 0.0);
    for (x, y) in points {
        squares += (x - x_mean) * (x - x_mean);
        products += (x - x_mean) * (y - y_mean);
    }
    if squares > 0.0 {
        products / squares
    } else {
        0.0
    }
}
