//! What healthy records can promise of a mean time between false alarms.

use serde::{Deserialize, Serialize};

use super::tail::{TAIL_SHARE, Tail};

/// How far the ends of the 95 % interval of a promise may lie from it, as a factor.
pub const SUPPORTED_FACTOR: f64 = 4.0;

/// The mean time between false alarms that the healthy records support at the limit, with its
/// interval.
///
/// Where they are too few for an estimate, the limit is that for white residuals, and the promise
/// rests on the whitening alone.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct MeanTime {
    /// Hours between false alarms that were asked for.
    pub asked_hours: f64,
    /// Hours that the healthy records say, extrapolated from the peaks of the statistic.
    pub hours: Option<f64>,
    /// Lower end of the 95 % interval of `hours`.
    pub hours_low: Option<f64>,
    /// Upper end of the 95 % interval of `hours`.
    pub hours_high: Option<f64>,
    /// Peaks behind the estimate.
    pub peaks: usize,
    /// Hours of healthy running that were given.
    pub healthy_hours: f64,
    /// Hours of healthy running with which the interval's ends would lie within a factor of
    /// [`SUPPORTED_FACTOR`] of the estimate.
    pub healthy_hours_needed: f64,
}

impl MeanTime {
    /// Whether the healthy records support the promise.
    pub fn supported(&self) -> bool {
        self.hours.is_some() && self.healthy_hours >= self.healthy_hours_needed
    }

    /// `tail` comes with the limit on its scale.
    pub(super) fn of(
        asked_hours: f64,
        sample_time_s: f64,
        healthy_hours: f64,
        release: usize,
        tail: Option<(Tail, f64)>,
    ) -> Self {
        let to_hours = |samples: f64| samples * sample_time_s / 3600.0;
        let Some((tail, limit)) = tail else {
            // A peak in as many samples, which is where fits begin.
            let spacing = 2.0 * release as f64 / TAIL_SHARE;
            let asked = asked_hours * 3600.0 / sample_time_s;
            let above = (asked / spacing).ln().max(0.0);
            let needed = to_hours(spacing * Tail::peaks_needed(above, SUPPORTED_FACTOR));
            return Self {
                asked_hours,
                hours: None,
                hours_low: None,
                hours_high: None,
                peaks: 0,
                healthy_hours,
                healthy_hours_needed: needed.max(2.0 * healthy_hours),
            };
        };
        let run_length = tail.run_length(limit);
        Self {
            asked_hours,
            hours: Some(to_hours(run_length.samples)),
            hours_low: Some(to_hours(run_length.low)),
            hours_high: Some(to_hours(run_length.high)),
            peaks: tail.peaks(),
            healthy_hours,
            healthy_hours_needed: to_hours(tail.samples_needed(limit, SUPPORTED_FACTOR)),
        }
    }
}
