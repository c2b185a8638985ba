//! Run lengths of any statistic by simulation.

use gt_core::DimensionError;
use serde::{Deserialize, Serialize};

use super::{check, check_run_length};
use crate::FdiError;
use crate::runtime::Statistic;

/// Alarms needed for an interval: the logarithm of a mean of this many run lengths is near enough
/// to normal.
pub const MIN_ALARMS: usize = 20;
/// 99.5 % quantile of the standard normal distribution: 99 % in all.
const QUANTILE: f64 = 2.5758293035489004;

/// Simulated healthy running of a [`Statistic`], from which the average run length at every
/// threshold can be read.
///
/// A path begins with a statistic that is reset and ends after a number of samples. Of each path,
/// the samples are kept at which the statistic was higher than ever before: they say when every
/// threshold was first crossed.
///
/// The mean run length is estimated by the samples up to the first crossings or the ends of the
/// paths, over the number of crossings. That is the plain mean when every path crosses. When many do
/// not, it supposes that the hazard of a crossing does not change along a path, which holds when
/// paths are long against the statistic's memory.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct SimulatedRuns {
    samples: usize,
    /// For each path, 1-based samples and values of its records, both ascending.
    records: Vec<Vec<(usize, f64)>>,
}

/// An average run length that was simulated.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SimulatedRunLength {
    /// The threshold on the statistic's value.
    pub threshold: f64,
    /// Average run length in samples.
    pub samples: f64,
    /// Lower end of its 99 % interval: the logarithm is taken as normal with the standard
    /// deviation `1 / sqrt(alarms)`, that of run lengths with a constant hazard.
    pub low: f64,
    /// Upper end of its 99 % interval.
    pub high: f64,
    /// Paths that crossed the threshold.
    pub alarms: usize,
}

impl SimulatedRuns {
    /// Runs `statistic` along `paths` paths of `samples` samples each; `noise` gives a path's
    /// residuals from its index, so that any path can be regenerated alone. The statistic is reset
    /// before each path; its threshold does not matter.
    ///
    /// # Errors
    /// [`FdiError::Option`] when `paths` or `samples` is 0.
    pub fn run<S: Statistic, N: FnMut() -> f64>(
        statistic: &mut S,
        paths: usize,
        samples: usize,
        mut noise: impl FnMut(usize) -> N,
    ) -> Result<Self, FdiError> {
        check("paths", "at least 1", 0.0, paths > 0)?;
        check("samples", "at least 1", 0.0, samples > 0)?;
        let records = (0..paths)
            .map(|path| {
                statistic.reset();
                let mut residual = noise(path);
                let mut highest = f64::NEG_INFINITY;
                let mut records = Vec::new();
                for sample in 1..=samples {
                    let value = statistic.step(residual()).value;
                    if value > highest {
                        highest = value;
                        records.push((sample, value));
                    }
                }
                records
            })
            .collect();
        Ok(Self { samples, records })
    }

    /// Takes the paths of others, of as many samples each, after its own: those of another thread,
    /// or made one by one.
    ///
    /// # Errors
    /// [`DimensionError`] when their paths have another number of samples.
    pub fn extend(&mut self, others: Self) -> Result<(), DimensionError> {
        DimensionError::check("samples of a path", self.samples, others.samples)?;
        self.records.extend(others.records);
        Ok(())
    }

    /// The average run length at `threshold`.
    ///
    /// # Errors
    /// [`FdiError::TooFewAlarms`] when fewer than [`MIN_ALARMS`] paths cross it.
    pub fn run_length(&self, threshold: f64) -> Result<SimulatedRunLength, FdiError> {
        let (total, alarms) = self.count(threshold);
        if alarms < MIN_ALARMS {
            let needed = MIN_ALARMS;
            return Err(FdiError::TooFewAlarms {
                needed,
                found: alarms,
            });
        }
        let samples = total as f64 / alarms as f64;
        let factor = (QUANTILE / (alarms as f64).sqrt()).exp();
        Ok(SimulatedRunLength {
            threshold,
            samples,
            low: samples / factor,
            high: samples * factor,
            alarms,
        })
    }

    /// The smallest threshold with an average run length of at least `run_length` samples, with
    /// its interval.
    ///
    /// # Errors
    /// [`FdiError::RunLength`] for a `run_length` below 1 or above
    /// [`MAX_RUN_LENGTH`](super::MAX_RUN_LENGTH), [`FdiError::TooFewAlarms`] when the paths are too
    /// few or too short for it.
    pub fn threshold_for(&self, run_length: f64) -> Result<SimulatedRunLength, FdiError> {
        check_run_length(run_length, 1.0)?;
        // Crossings change at the records only.
        let mut values: Vec<f64> = self.records.iter().flatten().map(|r| r.1).collect();
        values.sort_by(f64::total_cmp);
        let first = values.partition_point(|&value| {
            let (total, alarms) = self.count(value);
            (total as f64) < run_length * alarms as f64
        });
        let last = values.last().copied().unwrap_or(f64::NAN);
        self.run_length(values.get(first).copied().unwrap_or(last))
    }

    /// Samples up to the first values above `threshold` or the ends of the paths, and how many
    /// paths have one.
    fn count(&self, threshold: f64) -> (usize, usize) {
        let (mut total, mut alarms) = (0, 0);
        for records in &self.records {
            let crossing = records.partition_point(|record| record.1 <= threshold);
            let record = records.get(crossing);
            total += record.map_or(self.samples, |record| record.0);
            alarms += usize::from(record.is_some());
        }
        (total, alarms)
    }
}
