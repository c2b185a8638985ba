//! The smallest fault that is found in time.

use gtfdi::core::Dataset;
use gtfdi::fdi::{FdiError, IsolationDetector, Isolator};
use gtfdi::plant::FaultCase;

use super::preparation::{Prepared, ramp};
use crate::error::{CampaignError, During as _};

/// Onset in seconds: the isolator has settled and its memory has filled.
const ONSET_S: f64 = 120.0;
/// First run index.
const FIRST_INDEX: u64 = 5000;
/// Halvings of the range of sizes, which begins at a factor of [`RANGE`].
const HALVINGS: usize = 6;
const RANGE: f64 = 4.0;

/// A search for the minimal detectable fault `MDF(T, ARL0, P_d)`: the smallest size at time `T`
/// after the onset of a ramp from 0 for which the probability of an alarm within `T` is `P_d`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LimitSearch {
    /// The fault.
    pub case: FaultCase,
    /// `T`, in seconds.
    pub delay_s: f64,
    /// A size near the limit, in the case's unit.
    pub guess: f64,
    /// Seeded runs.
    pub runs: u64,
    /// `P_d`.
    pub detection_probability: f64,
}

/// A minimal detectable fault.
#[derive(Debug, Clone, PartialEq)]
pub struct DetectionLimit {
    /// The size in the case's unit: the `P_d` quantile over the runs of the smallest size that was
    /// found in each.
    pub size: f64,
    /// 95 % interval of that quantile, by order statistics.
    pub interval: [f64; 2],
    /// The smallest sizes found, ascending; infinite where none in the range was.
    pub smallest: Vec<f64>,
}

impl LimitSearch {
    /// For each run the smallest size that is found in it is closed in by halving the range of its
    /// logarithm: the same excitation and noise for every size.
    ///
    /// # Errors
    /// [`CampaignError`] when a run leaves the plant's validity.
    pub fn find(&self, prepared: &Prepared) -> Result<DetectionLimit, CampaignError> {
        let runs = usize::try_from(self.runs).unwrap_or(usize::MAX);
        let mut low = vec![self.guess / RANGE; runs];
        let mut high = vec![self.guess * RANGE; runs];
        // Whether the upper end was ever found.
        let mut found = vec![false; runs];
        let duration_s = ONSET_S + self.delay_s;
        for _ in 0..HALVINGS {
            let jobs: Vec<_> = (0..runs)
                .map(|run| {
                    let size = (low[run] * high[run]).sqrt();
                    let fault = ramp(self.case, ONSET_S, self.delay_s, size);
                    (FIRST_INDEX + run as u64, vec![fault])
                })
                .collect();
            let alarms = prepared.setting.map(&jobs, duration_s, |_, record| {
                alarm_after(&prepared.isolator, &record, ONSET_S).during(self.case.name())
            })?;
            for (run, alarm) in alarms.into_iter().enumerate() {
                let middle = (low[run] * high[run]).sqrt();
                if alarm {
                    (high[run], found[run]) = (middle, true);
                } else {
                    low[run] = middle;
                }
            }
        }
        let mut smallest: Vec<f64> = high
            .iter()
            .zip(&found)
            .map(|(size, found)| if *found { *size } else { f64::INFINITY })
            .collect();
        smallest.sort_by(f64::total_cmp);
        let quantile = |rank: f64| {
            #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)] // below the length
            let place = rank.max(1.0) as usize;
            smallest.get(place - 1).copied().unwrap_or(f64::INFINITY)
        };
        let (n, p) = (self.runs as f64, self.detection_probability);
        let half = 1.959_963_984_540_054 * (n * p * (1.0 - p)).sqrt();
        Ok(DetectionLimit {
            size: quantile((n * p).ceil()),
            interval: [
                quantile((n * p - half).floor()),
                quantile((n * p + half).ceil() + 1.0),
            ],
            smallest,
        })
    }
}

/// Whether an alarm is up at any time after the onset.
fn alarm_after(isolator: &Isolator, record: &Dataset, onset_s: f64) -> Result<bool, FdiError> {
    let mut detector = IsolationDetector::new(isolator)?;
    for sample in 0..record.len() {
        let time_s = record.time_s(sample);
        // The records have the isolator's channels in its order.
        let (u, y) = (record.u().column(sample), record.y().column(sample));
        let verdict = detector.step(time_s, u.as_slice(), y.as_slice())?;
        if time_s > onset_s && verdict.exceeds {
            return Ok(true);
        }
    }
    Ok(false)
}
