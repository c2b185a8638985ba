//! Limits from healthy residuals, with the false alarms they cause there.

use serde::{Deserialize, Serialize};

use super::false_alarm::{FalseAlarmRate, count_alarms};
use super::mean_time::MeanTime;
use super::threshold::{FixedThreshold, ThresholdRule};
use crate::FdiError;
use crate::runtime::Persistence;

/// Blocks into which a single healthy record is cut for cross-validation.
const BLOCKS: usize = 5;
/// Healthy running needed for a mean time between false alarms, as a multiple of that time.
const HOURS_NEEDED: f64 = 3.0;
/// Slack in counting the samples that a share allows: 0.29 x 100 is 28.999... in binary.
const SHARE_SLACK: f64 = 1e-9;

/// A threshold with the false alarms that were counted when it was set.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Calibration {
    /// The threshold, set on all records.
    pub threshold: FixedThreshold,
    /// False alarms on the very records that set the threshold: optimistic.
    pub false_alarms: FalseAlarmRate,
    /// False alarms when each record is judged by a limit that the others set. A single record is
    /// cut into 5 contiguous blocks for that, and an alarm across a cut is not counted as one.
    pub cross_validated: FalseAlarmRate,
    /// Share of samples above the limit in that cross-validation.
    pub cross_validated_exceedance_share: f64,
}

impl Calibration {
    /// The false alarms without the threshold.
    pub fn summary(&self) -> FalseAlarmSummary {
        FalseAlarmSummary {
            in_sample: self.false_alarms,
            cross_validated: self.cross_validated,
            cross_validated_exceedance_share: self.cross_validated_exceedance_share,
            mean_time: None,
        }
    }
}

/// The false alarms that were counted when a threshold was set; see [`Calibration`].
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct FalseAlarmSummary {
    /// On the records that set the threshold.
    pub in_sample: FalseAlarmRate,
    /// On records judged by a limit that the others set.
    pub cross_validated: FalseAlarmRate,
    /// Share of samples above the limit in that cross-validation.
    pub cross_validated_exceedance_share: f64,
    /// The promise of a limit by mean time between false alarms, where the statistic has memory.
    pub mean_time: Option<MeanTime>,
}

/// A threshold from healthy residuals: one slice a record, settling already cut off,
/// `sample_time_s` seconds apart.
///
/// # Errors
/// [`FdiError`] when the rule's parameters are out of range, there is no record, a residual is not
/// finite, or there are too few samples: `consecutive` in each record (five times that in a single
/// one), `1 / share` in all for [`ThresholdRule::Exceedance`], three times the hours asked for with
/// [`ThresholdRule::MeanTimeBetweenFalseAlarms`].
pub fn calibrate(
    residuals: &[&[f64]],
    sample_time_s: f64,
    rule: ThresholdRule,
) -> Result<Calibration, FdiError> {
    calibrate_held(residuals, sample_time_s, rule, 1)
}

/// As [`calibrate`], for values whose alarms last until `release` samples in a row are within the
/// limit.
pub(super) fn calibrate_held(
    residuals: &[&[f64]],
    sample_time_s: f64,
    rule: ThresholdRule,
    release: usize,
) -> Result<Calibration, FdiError> {
    rule.validate()?;
    check_records(residuals, sample_time_s, rule)?;
    let limit = Search::new(residuals, sample_time_s).limit(rule, None);
    let consecutive = rule.consecutive();
    let threshold = FixedThreshold {
        limit,
        consecutive,
        rule,
    };
    threshold.validate()?;

    let wait = Persistence {
        consecutive,
        release,
    };
    let alarms = residuals.iter().map(|r| count_alarms(r, limit, wait)).sum();
    let samples: usize = residuals.iter().map(|r| r.len()).sum();
    let hours = samples as f64 * sample_time_s / 3600.0;
    let (cross_alarms, exceedances) = cross_validate(&folds(residuals), sample_time_s, rule, wait);
    Ok(Calibration {
        threshold,
        false_alarms: FalseAlarmRate::from_counts(alarms, hours)?,
        cross_validated: FalseAlarmRate::from_counts(cross_alarms, hours)?,
        cross_validated_exceedance_share: exceedances as f64 / samples as f64,
    })
}

fn check_records(
    residuals: &[&[f64]],
    sample_time_s: f64,
    rule: ThresholdRule,
) -> Result<(), FdiError> {
    if !(sample_time_s.is_finite() && sample_time_s > 0.0) {
        let expected = "a positive finite number of seconds";
        return Err(FdiError::Option {
            option: "sample_time_s",
            expected,
            found: sample_time_s,
        });
    }
    if residuals.is_empty() {
        return Err(FdiError::NoHealthyData);
    }
    let blocks = if residuals.len() == 1 { BLOCKS } else { 1 };
    let needed = blocks.saturating_mul(rule.consecutive());
    for (record, residual) in residuals.iter().enumerate() {
        if residual.len() < needed {
            return Err(FdiError::HealthySamples {
                record,
                needed,
                found: residual.len(),
            });
        }
        check_finite(&format!("healthy residual {record}"), residual)?;
    }
    let samples: usize = residuals.iter().map(|r| r.len()).sum();
    match rule {
        ThresholdRule::Exceedance { share, .. } if allowed_samples(share, samples) == 0 => {
            Err(FdiError::HealthyTotal {
                share,
                needed: samples_for(share),
                found: samples,
            })
        }
        ThresholdRule::MeanTimeBetweenFalseAlarms { hours, .. } => {
            let found_hours = samples as f64 * sample_time_s / 3600.0;
            let needed_hours = HOURS_NEEDED * hours;
            // Sums of sample times round: a record of exactly the length is long enough.
            if found_hours < needed_hours * (1.0 - 1e-12) {
                return Err(FdiError::HealthyHours {
                    asked_hours: hours,
                    needed_hours,
                    found_hours,
                });
            }
            Ok(())
        }
        _ => Ok(()),
    }
}

/// Refuses NaN and infinity in a residual.
pub(super) fn check_finite(what: &str, residual: &[f64]) -> Result<(), FdiError> {
    match residual.iter().position(|r| !r.is_finite()) {
        Some(sample) => Err(FdiError::NotFiniteResidual {
            what: what.to_owned(),
            sample,
            found: residual[sample],
        }),
        None => Ok(()),
    }
}

/// Samples above the limit that a share of `samples` allows.
#[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)] // in 0..=samples
fn allowed_samples(share: f64, samples: usize) -> usize {
    (share * samples as f64 + SHARE_SLACK).floor() as usize
}

/// Samples of which a share is at least one.
#[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)] // positive; saturates
fn samples_for(share: f64) -> usize {
    ((1.0 - SHARE_SLACK) / share).ceil() as usize
}

/// The records that judge each other.
fn folds<'a>(residuals: &[&'a [f64]]) -> Vec<&'a [f64]> {
    match residuals {
        [single] => {
            let edge = |block: usize| block * single.len() / BLOCKS;
            (0..BLOCKS)
                .map(|block| &single[edge(block)..edge(block + 1)])
                .collect()
        }
        several => several.to_vec(),
    }
}

/// Alarms and samples above the limit when each fold is judged by a limit that the others set.
fn cross_validate(
    folds: &[&[f64]],
    sample_time_s: f64,
    rule: ThresholdRule,
    wait: Persistence,
) -> (usize, usize) {
    let search = Search::new(folds, sample_time_s);
    let mut alarms = 0;
    let mut exceedances = 0;
    for (index, fold) in folds.iter().enumerate() {
        let limit = search.limit(rule, Some(index));
        alarms += count_alarms(fold, limit, wait);
        exceedances += fold.iter().filter(|r| r.abs() > limit).count();
    }
    (alarms, exceedances)
}

/// All samples of some records by falling `|r|`, so that a limit for all records, or for all but
/// one, is found in one pass.
struct Search<'a> {
    records: &'a [&'a [f64]],
    /// Index of each record's first sample among all samples; one more, the number of samples.
    starts: Vec<usize>,
    /// `(|r|, record, index among all samples)`, largest first.
    falling: Vec<(f64, usize, usize)>,
    sample_time_s: f64,
}

impl<'a> Search<'a> {
    fn new(records: &'a [&'a [f64]], sample_time_s: f64) -> Self {
        let mut starts = vec![0];
        let mut falling = Vec::new();
        for (record, residual) in records.iter().enumerate() {
            let start = starts[record];
            falling.extend(
                residual
                    .iter()
                    .enumerate()
                    .map(|(i, r)| (r.abs(), record, start + i)),
            );
            starts.push(start + residual.len());
        }
        falling.sort_unstable_by(|left, right| right.0.total_cmp(&left.0));
        Self {
            records,
            starts,
            falling,
            sample_time_s,
        }
    }

    /// The limit that the rule sets on all records but `excluded`.
    fn limit(&self, rule: ThresholdRule, excluded: Option<usize>) -> f64 {
        let kept = || {
            self.falling
                .iter()
                .filter(|sample| Some(sample.1) != excluded)
        };
        let magnitude = |rank: usize| kept().nth(rank).map_or(0.0, |sample| sample.0);
        let all = self.falling.len();
        let samples = all - excluded.map_or(0, |record| self.records[record].len());
        match rule {
            ThresholdRule::Exceedance { share, .. } => magnitude(allowed_samples(share, samples)),
            ThresholdRule::Margin { factor, .. } => factor * magnitude(0),
            ThresholdRule::MeanTimeBetweenFalseAlarms { hours, consecutive } => {
                let clear_needed = hours * 3600.0 / self.sample_time_s;
                self.limit_by_events(kept(), samples, consecutive, clear_needed)
            }
        }
    }

    /// Lowers the limit from the largest magnitude on, one value at a time, until the clear samples
    /// for each alarm event are fewer than `clear_needed`; returns the last value before that.
    fn limit_by_events<'b>(
        &self,
        falling: impl Iterator<Item = &'b (f64, usize, usize)>,
        samples: usize,
        consecutive: usize,
        clear_needed: f64,
    ) -> f64 {
        let mut runs = Runs::new(self.falling.len(), consecutive);
        let mut limit = f64::INFINITY;
        for &(magnitude, record, index) in falling {
            // Samples of one magnitude come in together: only when the next lower one comes is it
            // known what a limit just below `limit` does.
            if magnitude < limit {
                if !runs.leave_clear(samples, clear_needed) {
                    return limit;
                }
                limit = magnitude;
            }
            runs.add(index, self.starts[record]..self.starts[record + 1]);
        }
        limit
    }
}

/// Runs of samples above a falling limit, their alarm events and the samples in alarm.
struct Runs {
    /// At both ends of a run its length, elsewhere 0 or stale.
    lengths: Vec<usize>,
    consecutive: usize,
    events: usize,
    in_alarm: usize,
}

impl Runs {
    fn new(samples: usize, consecutive: usize) -> Self {
        Self {
            lengths: vec![0; samples],
            consecutive,
            events: 0,
            in_alarm: 0,
        }
    }

    /// Whether each alarm event leaves at least `needed` clear samples.
    fn leave_clear(&self, samples: usize, needed: f64) -> bool {
        self.events as f64 * needed <= (samples - self.in_alarm) as f64
    }

    /// Adds a sample of the record with the sample indices `record`, joining the runs beside it.
    fn add(&mut self, index: usize, record: core::ops::Range<usize>) {
        let left = if index > record.start {
            self.lengths[index - 1]
        } else {
            0
        };
        let right = if index + 1 < record.end {
            self.lengths[index + 1]
        } else {
            0
        };
        let length = left + 1 + right;
        for gone in [left, right] {
            if gone >= self.consecutive {
                self.events -= 1;
                self.in_alarm -= gone + 1 - self.consecutive;
            }
        }
        if length >= self.consecutive {
            self.events += 1;
            self.in_alarm += length + 1 - self.consecutive;
        }
        self.lengths[index] = length;
        self.lengths[index - left] = length;
        self.lengths[index + right] = length;
    }
}
