//! The smallest fault that is found in time.

use gtfdi::core::Dataset;
use gtfdi::plant::FaultCase;

use super::recipe::ramp;
use super::setting::Setting;
use crate::error::CampaignError;

/// Onset in seconds: detectors have settled and their memory has filled.
pub(super) const ONSET_S: f64 = 120.0;
/// First run index.
const FIRST_INDEX: u64 = 5000;
/// The least size searched is the first guess over this.
const RANGE: f64 = 16.0;
/// Simulations of one run at most.
const ATTEMPTS: usize = 10;
/// A size is found when it is closed in to this ratio, or the statistic is this close to its limit
/// (logarithms).
const CLOSE: f64 = 0.05;
/// By how much the logarithm of a statistic is taken to rise with that of the size until two
/// attempts tell: between a modulus (1) and a squared one (2).
const RISE: f64 = 1.5;
/// Least and largest step of a size's logarithm where only one side is known.
const STEPS: [f64; 2] = [0.1, 1.4];

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
    /// The largest size searched, in the case's unit.
    pub largest: f64,
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

/// What watches a record.
pub trait Watcher: Sync {
    /// At each sample the largest ratio of a statistic to its limit: above 1 there is an alarm.
    ///
    /// # Errors
    /// [`CampaignError`] when the record does not fit.
    fn ratios(&self, record: &Dataset) -> Result<Vec<f64>, CampaignError>;
}

impl LimitSearch {
    /// For each run the size is closed in at which the largest ratio of a statistic to its limit
    /// within `T` is 1, with the same excitation and noise for every size.
    ///
    /// # Errors
    /// [`CampaignError`] when a run leaves the plant's validity.
    pub fn find(
        &self,
        setting: &Setting,
        detector: &impl Watcher,
    ) -> Result<DetectionLimit, CampaignError> {
        let range = [self.guess / RANGE, self.largest].map(f64::ln);
        let mut closing: Vec<Closing> = (0..self.runs)
            .map(|_| Closing::new(self.guess.ln(), range))
            .collect();
        for _ in 0..ATTEMPTS {
            let open: Vec<usize> = (0..closing.len())
                .filter(|&run| closing[run].found.is_none())
                .collect();
            let jobs: Vec<_> = open
                .iter()
                .map(|&run| {
                    let fault = ramp(self.case, ONSET_S, self.delay_s, closing[run].next.exp());
                    (FIRST_INDEX + run as u64, vec![fault])
                })
                .collect();
            let peaks = setting.map(&jobs, ONSET_S + self.delay_s, |_, record| {
                let after = after_onset(&record, detector.ratios(&record)?);
                Ok(after.map(|(_, ratio)| ratio).fold(0.0, f64::max))
            })?;
            for (run, peak) in open.into_iter().zip(peaks) {
                closing[run].take(peak.ln());
            }
        }
        let mut smallest: Vec<f64> = closing.iter().map(Closing::smallest).collect();
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

    /// The mean delay in seconds, from the onset, of the alarms of a ramp that reaches `size` in
    /// `T` and goes on to three times that, over runs of their own; `None` where a run has none.
    ///
    /// # Errors
    /// As [`LimitSearch::find`].
    pub fn mean_delay_s(
        &self,
        size: f64,
        setting: &Setting,
        detector: &impl Watcher,
    ) -> Result<Option<f64>, CampaignError> {
        let fault = ramp(self.case, ONSET_S, 3.0 * self.delay_s, 3.0 * size);
        let jobs: Vec<_> = (0..self.runs)
            .map(|run| (FIRST_INDEX + self.runs + run, vec![fault.clone()]))
            .collect();
        let alarms = setting.map(&jobs, ONSET_S + 3.0 * self.delay_s, |_, record| {
            let mut after = after_onset(&record, detector.ratios(&record)?);
            let alarm = after.find(|(_, ratio)| *ratio > 1.0);
            Ok(alarm.map(|(time_s, _)| time_s - ONSET_S))
        })?;
        let delays: Option<Vec<f64>> = alarms.into_iter().collect();
        Ok(delays.map(|delays| delays.iter().sum::<f64>() / delays.len().max(1) as f64))
    }
}

/// The times and ratios of the samples after the onset.
fn after_onset(record: &Dataset, ratios: Vec<f64>) -> impl Iterator<Item = (f64, f64)> {
    let timed = ratios.into_iter().enumerate();
    timed
        .map(|(sample, ratio)| (record.time_s(sample), ratio))
        .filter(|(time_s, _)| *time_s > ONSET_S)
}

/// Closing in on the size, by its logarithm, whose peak ratio is 1.
#[derive(Debug, Clone)]
struct Closing {
    /// Sizes not found and found, with the logarithms of their ratios.
    below: Option<[f64; 2]>,
    above: Option<[f64; 2]>,
    range: [f64; 2],
    next: f64,
    found: Option<f64>,
}

impl Closing {
    fn new(guess: f64, range: [f64; 2]) -> Self {
        Self {
            below: None,
            above: None,
            range,
            next: guess.min(range[1]),
            found: None,
        }
    }

    /// Takes the logarithm of the ratio at `next`.
    fn take(&mut self, ratio: f64) {
        let size = self.next;
        if ratio > 0.0 {
            self.above = Some([size, ratio]);
        } else {
            self.below = Some([size, ratio]);
        }
        let step = (ratio.abs() / RISE).clamp(STEPS[0], STEPS[1]);
        match (self.below, self.above) {
            (Some([low, less]), Some([high, more])) => {
                let share = if less.is_finite() {
                    less / (less - more)
                } else {
                    0.5
                };
                if ratio.abs() < CLOSE || high - low < CLOSE {
                    self.found = Some(low + share * (high - low));
                }
                // Not so near an end that the other never moves.
                self.next = low + share.clamp(0.1, 0.9) * (high - low);
            }
            _ if ratio.abs() < CLOSE => self.found = Some(size),
            (Some(_), None) if size >= self.range[1] => self.found = Some(f64::INFINITY),
            (Some(_), None) => self.next = (size + step).min(self.range[1]),
            _ if size <= self.range[0] => self.found = Some(size),
            _ => self.next = (size - step).max(self.range[0]),
        }
    }

    /// The smallest size found; infinite without one.
    fn smallest(&self) -> f64 {
        let above = self.above.map(|[size, _]| size);
        self.found.or(above).map_or(f64::INFINITY, f64::exp)
    }
}

#[cfg(test)]
mod tests {
    use super::Closing;

    /// Ratios that rise from a floor of noise like the square or the modulus of the size.
    #[test]
    fn closes_in_on_where_the_ratio_is_one() {
        for (power, floor, root) in [(2.0, 0.3, 0.7_f64), (1.0, 0.5, 3.0), (2.0, 0.05, 0.02)] {
            let ratio = |size: f64| ((1.0 - floor) * (size / root).powf(power) + floor).ln();
            let mut closing = Closing::new(0.0, [0.001_f64.ln(), 25.0_f64.ln()]);
            let mut attempts = 0;
            while closing.found.is_none() {
                closing.take(ratio(closing.next.exp()));
                attempts += 1;
                assert!(attempts <= 10, "{power} {floor} {root}: {closing:?}");
            }
            // Closed in to 5 %, or a ratio 5 % off: of the modulus over a floor of a half, 10 %.
            assert!((closing.smallest() / root).ln().abs() < 0.1, "{closing:?}");
        }
    }

    #[test]
    fn what_is_never_found_is_infinite() {
        let mut closing = Closing::new(0.0, [-3.0, 2.0]);
        while closing.found.is_none() {
            closing.take(-1.0);
        }
        assert!(closing.smallest().is_infinite(), "{closing:?}");
        // Nothing at all in the residuals.
        closing = Closing::new(0.0, [-3.0, 2.0]);
        while closing.found.is_none() {
            closing.take(f64::NEG_INFINITY);
        }
        assert!(closing.smallest().is_infinite(), "{closing:?}");
    }
}
