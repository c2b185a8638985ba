//! The recent past of a machine in buckets of least and largest values.

use std::collections::VecDeque;
use std::iter::repeat_n;

/// The least and largest value of a bucket; `None` where there was none.
pub type Band = Option<[f64; 2]>;

/// A [`Band`] as it is kept: to seven digits, which is more than a chart shows; NaN where there is
/// none.
type Kept = [f32; 2];

const NONE: Kept = [f32::NAN; 2];

/// A ring of buckets of all series of a machine, to seven digits. Its memory is asked for at once and
/// never grows.
#[derive(Debug, Clone)]
pub struct Trend {
    bucket_ms: i64,
    capacity: usize,
    series: usize,
    times_ms: VecDeque<i64>,
    /// The bands of all series of a bucket, bucket by bucket.
    bands: VecDeque<Kept>,
}

impl Trend {
    /// `capacity` buckets of `bucket_ms` milliseconds.
    pub fn new(series: usize, bucket_ms: i64, capacity: usize) -> Self {
        let capacity = capacity.max(1);
        // Written once, so that the system has given it before the service says that it is ready.
        let mut times_ms = VecDeque::from(vec![-1; capacity]);
        let mut bands = VecDeque::from(vec![NONE; capacity * series]);
        times_ms.clear();
        bands.clear();
        Self {
            bucket_ms: bucket_ms.max(1),
            capacity,
            series,
            times_ms,
            bands,
        }
    }

    /// Takes the values of a time; values that are not finite leave no trace.
    pub fn push(&mut self, time_ms: i64, values: impl Iterator<Item = f64>) {
        let start_ms = time_ms.div_euclid(self.bucket_ms) * self.bucket_ms;
        let last_ms = self.times_ms.back().copied();
        if last_ms != Some(start_ms) {
            // After a clock was set back the past is another's.
            if last_ms.is_some_and(|last_ms| last_ms > start_ms) {
                self.times_ms.clear();
                self.bands.clear();
            }
            if self.times_ms.len() >= self.capacity {
                self.times_ms.pop_front();
                self.bands.drain(..self.series);
            }
            self.times_ms.push_back(start_ms);
            self.bands.extend(repeat_n(NONE, self.series));
        }
        let first = self.bands.len() - self.series;
        for (band, value) in self.bands.range_mut(first..).zip(values) {
            #[allow(clippy::cast_possible_truncation)] // infinite where it is beyond
            let value = value as f32;
            if value.is_finite() {
                // NaN is neither less nor more.
                *band = [band[0].min(value), band[1].max(value)];
            }
        }
    }

    /// At most `points` buckets of the last `seconds`: their common length in milliseconds, their
    /// times, and the bands of each series.
    pub fn last(&self, seconds: f64, points: usize) -> (i64, Vec<i64>, Vec<Vec<Band>>) {
        let Some(newest_ms) = self.times_ms.back() else {
            return (self.bucket_ms, Vec::new(), vec![Vec::new(); self.series]);
        };
        #[allow(clippy::cast_possible_truncation)] // saturates
        let from_ms = newest_ms.saturating_sub((seconds * 1e3) as i64);
        let held = self.times_ms.partition_point(|time_ms| *time_ms < from_ms);
        let count = (newest_ms - from_ms.max(self.times_ms[held])) / self.bucket_ms + 1;
        let points = i64::try_from(points.max(1)).unwrap_or(i64::MAX);
        let per = (count - 1) / points + 1;
        let width_ms = per.max(1) * self.bucket_ms;
        let mut times: Vec<i64> = Vec::new();
        let mut bands: Vec<Vec<Band>> = vec![Vec::new(); self.series];
        for (place, time_ms) in self.times_ms.iter().enumerate().skip(held) {
            let own = self.bands.range(place * self.series..).take(self.series);
            let start_ms = time_ms.div_euclid(width_ms) * width_ms;
            if times.last() == Some(&start_ms) {
                for (all, band) in bands.iter_mut().zip(own) {
                    if let Some(last) = all.last_mut() {
                        *last = join(*last, shown(*band));
                    }
                }
            } else {
                times.push(start_ms);
                for (all, band) in bands.iter_mut().zip(own) {
                    all.push(shown(*band));
                }
            }
        }
        (width_ms, times, bands)
    }
}

fn shown([low, high]: Kept) -> Band {
    low.is_finite().then(|| [f64::from(low), f64::from(high)])
}

fn join(one: Band, other: Band) -> Band {
    match (one, other) {
        (Some([low, high]), Some([least, largest])) => Some([low.min(least), high.max(largest)]),
        (one, other) => one.or(other),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        /// However buckets are joined, the least and largest of all are kept, in time's order.
        #[test]
        fn prop_nothing_is_lost_by_joining(
            values in proptest::collection::vec(-1e3..1e3f64, 1..300), points in 1..50_usize,
        ) {
            let mut trend = Trend::new(1, 100, 1000);
            for (k, value) in (0..).zip(&values) {
                trend.push(80 * k, [*value].into_iter());
            }
            let (width_ms, times, bands) = trend.last(1e6, points);
            // One more where the first is not on the joined grid.
            prop_assert!(times.len() <= points + 1);
            prop_assert!(times.windows(2).all(|pair| pair[1] - pair[0] >= width_ms));
            let low = bands[0].iter().flatten().map(|band| band[0]).fold(f64::MAX, f64::min);
            let high = bands[0].iter().flatten().map(|band| band[1]).fold(f64::MIN, f64::max);
            #[allow(clippy::cast_possible_truncation)] // as they are kept
            let kept: Vec<f64> = values.iter().map(|value| f64::from(*value as f32)).collect();
            let least = kept.iter().copied().fold(f64::MAX, f64::min);
            prop_assert_eq!(low.to_bits(), least.to_bits());
            let largest = kept.iter().copied().fold(f64::MIN, f64::max);
            prop_assert_eq!(high.to_bits(), largest.to_bits());
        }
    }

    #[test]
    fn no_more_is_kept_than_asked() {
        let mut trend = Trend::new(2, 100, 10);
        for k in 0..1000 {
            trend.push(100 * k, [k as f64, f64::NAN].into_iter());
        }
        let (_, times, bands) = trend.last(1e6, 1000);
        assert_eq!(times, (990..1000).map(|k| 100 * k).collect::<Vec<i64>>());
        assert_eq!(bands[0][0], Some([990.0, 990.0]));
        assert!(bands[1].iter().all(Option::is_none));
        let (width_ms, times, _) = trend.last(0.45, 2);
        assert_eq!((width_ms, times), (300, vec![99_300, 99_600, 99_900]));
    }
}
