//! From the peaks of a statistic on healthy running to its mean time between false alarms.

use crate::FdiError;

/// Peaks that are fitted, where there are as many; more for a run length that fewer do not reach.
const PEAKS: usize = 400;
/// Peaks without which there is no fit.
pub const MIN_PEAKS: usize = 10;
/// Share of the blocks whose maxima may count as peaks: lower ones are not yet tail.
pub(super) const TAIL_SHARE: f64 = 0.25;
/// 97.5 % quantile of the standard normal distribution.
const QUANTILE: f64 = 1.959_963_984_540_054;

/// The peaks of a statistic above a level, as a Poisson process with exponentially distributed
/// heights (the method of peaks over a threshold: Leadbetter, Lindgren and Rootzen, *Extremes and
/// Related Properties of Random Sequences and Processes*, 1983). The heights of a likelihood ratio
/// and of a cumulative sum have such a tail whatever the colour of the residual; those of averages
/// and sums of squares on the scale that [`StatisticKind`](super::StatisticKind) gives them.
///
/// Values above the level that lie fewer than `release` samples apart belong to one peak.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Tail {
    level: f64,
    /// Mean height above the level.
    height: f64,
    peaks: usize,
    samples: usize,
}

/// A mean time between false alarms that healthy running supports.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct TailRunLength {
    /// Samples between false alarms.
    pub(crate) samples: f64,
    /// Lower end of its 95 % interval.
    pub(crate) low: f64,
    /// Upper end of its 95 % interval.
    pub(crate) high: f64,
}

impl Tail {
    /// Fits the tail of the values of a statistic over healthy records, for limits with a run length
    /// of `run_length` samples or more: the level is below those.
    ///
    /// # Errors
    /// [`FdiError::TooFewPeaks`] with fewer than [`MIN_PEAKS`].
    pub(crate) fn fit(
        records: &[&[f64]],
        release: usize,
        run_length: f64,
    ) -> Result<Self, FdiError> {
        let block = 2 * release.max(1);
        let mut maxima: Vec<f64> = records
            .iter()
            .flat_map(|record| record.chunks(block))
            .filter(|chunk| chunk.len() == block)
            .map(|chunk| chunk.iter().copied().fold(f64::NEG_INFINITY, f64::max))
            .collect();
        let samples: usize = records.iter().map(|record| record.len()).sum();
        // Peaks come at least twice as often as the alarms.
        #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)] // saturates
        let wanted = PEAKS.max((2.0 * samples as f64 / run_length) as usize);
        maxima.sort_by(|left, right| right.total_cmp(left));
        #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)] // below the length
        let share = (TAIL_SHARE * maxima.len() as f64) as usize;
        let few = |found: usize| FdiError::TooFewPeaks {
            needed: MIN_PEAKS,
            found,
        };
        if share < MIN_PEAKS {
            return Err(few(share));
        }
        let level = maxima[share.min(wanted)];
        let (mut heights, mut peaks) = (0.0, 0);
        for record in records {
            let (mut peak, mut since) = (f64::NEG_INFINITY, usize::MAX);
            for &value in *record {
                if value > level {
                    if since >= release && peak > level {
                        heights += peak - level;
                        peaks += 1;
                        peak = f64::NEG_INFINITY;
                    }
                    peak = peak.max(value);
                    since = 0;
                } else {
                    since = since.saturating_add(1);
                }
            }
            if peak > level {
                heights += peak - level;
                peaks += 1;
            }
        }
        if peaks < MIN_PEAKS || heights <= 0.0 {
            return Err(few(peaks));
        }
        let height = heights / peaks as f64;
        Ok(Self {
            level,
            height,
            peaks,
            samples,
        })
    }

    /// Peaks that were fitted.
    pub(crate) fn peaks(&self) -> usize {
        self.peaks
    }

    /// The limit above which `run_length` samples pass between two peaks in the mean.
    pub(crate) fn limit_for(&self, run_length: f64) -> f64 {
        let ratio = run_length * self.peaks as f64 / self.samples as f64;
        self.level + self.height * ratio.ln().max(0.0)
    }

    /// Samples between two peaks above `limit`: the logarithm is taken as normal, with the variance
    /// of the number of peaks and of their mean height.
    pub(crate) fn run_length(&self, limit: f64) -> TailRunLength {
        let above = ((limit - self.level) / self.height).max(0.0);
        let samples = self.samples as f64 / self.peaks as f64 * above.exp();
        let factor = (QUANTILE * Self::deviation(above, self.peaks as f64)).exp();
        TailRunLength {
            samples,
            low: samples / factor,
            high: samples * factor,
        }
    }

    /// Standard deviation of the logarithm of a run length.
    fn deviation(above: f64, peaks: f64) -> f64 {
        ((1.0 + above * above) / peaks).sqrt()
    }

    /// Samples of healthy running for which the 95 % interval at `limit` would reach from
    /// `1 / factor` to `factor` times the mean time: more running at the same level has more peaks.
    pub(crate) fn samples_needed(&self, limit: f64, factor: f64) -> f64 {
        let above = ((limit - self.level) / self.height).max(0.0);
        self.samples as f64 * Self::peaks_needed(above, factor) / self.peaks as f64
    }

    /// Peaks with which the 95 % interval at so many mean heights above the level reaches from
    /// `1 / factor` to `factor` times the mean time.
    pub(crate) fn peaks_needed(above: f64, factor: f64) -> f64 {
        let deviation = factor.ln() / QUANTILE;
        (1.0 + above * above) / (deviation * deviation)
    }
}
