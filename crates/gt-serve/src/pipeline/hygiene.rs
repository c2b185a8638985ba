//! From readings as they come to samples of one period: order, age, duplicates, gaps.

use std::collections::VecDeque;

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::{Quality, Reading};

/// Nanoseconds in a second.
const SECOND_NS: f64 = 1e9;

/// How readings become samples.
///
/// | name | default | purpose | range |
/// |---|---|---|---|
/// | `reorder_s` | 0.5 | how long a sample waits for readings that are late | 0 to 3600 |
/// | `gap_s` | 2 | silence after which everything starts afresh | above 0, to 86400 |
/// | `future_s` | 10 | how far ahead of the clock a reading may be | 0 to 86400 |
/// | `age_s` | 10 | age of a tag's last good value beyond which it is stale | above 0 |
/// | `hold_s` | 0 | how long a tag's last good value stands in for a missing one | 0 or more |
/// | `frozen_s` | none | how long a tag may read exactly the same value before it is stale | a period to 30 days |
/// | `restart_s` | 30 | how long all readings must be late until the clock is taken to have been set back | above 0 |
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct HygieneOptions {
    /// How long a sample waits for readings that are late, in seconds of source time.
    pub reorder_s: f64,
    /// Silence after which everything starts afresh, in seconds of source time.
    pub gap_s: f64,
    /// How far ahead of the clock a reading may be, in seconds.
    pub future_s: f64,
    /// Age of a tag's last good value beyond which it is stale, in seconds.
    pub age_s: f64,
    /// How long a tag's last good value stands in for a missing one, in seconds; such values are
    /// marked `interpolated` and counted.
    pub hold_s: f64,
    /// How long a tag may read exactly the same value before it is stale, in seconds; nothing is stale
    /// for that without it. For sensors with noise: a valve, or a historian that sends a value again
    /// until it changes, may well stand still.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub frozen_s: Option<f64>,
    /// How long all readings must be late until the source's clock is taken to have been set back,
    /// in seconds of arrival.
    pub restart_s: f64,
}

impl Default for HygieneOptions {
    fn default() -> Self {
        Self {
            reorder_s: 0.5,
            gap_s: 2.0,
            future_s: 10.0,
            age_s: 10.0,
            hold_s: 0.0,
            frozen_s: None,
            restart_s: 30.0,
        }
    }
}

/// An option that makes no sense.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[error("{option}: expected {expected}, found {found}")]
pub struct HygieneError {
    /// The option.
    pub option: &'static str,
    /// What it may be.
    pub expected: String,
    /// What it is.
    pub found: f64,
}

impl HygieneOptions {
    /// Refuses what makes no sense for samples of a period.
    ///
    /// # Errors
    /// [`HygieneError`] with the first such option.
    pub fn check(&self, period_s: f64) -> Result<(), HygieneError> {
        let zero = 0.0;
        let ranges = [
            ("reorder_s", self.reorder_s, zero, 3600.0),
            ("gap_s", self.gap_s, 2.0 * period_s, 86_400.0),
            ("future_s", self.future_s, zero, 86_400.0),
            ("age_s", self.age_s, period_s, 86_400.0),
            ("hold_s", self.hold_s, zero, 86_400.0),
            ("restart_s", self.restart_s, period_s, 86_400.0),
        ];
        let frozen = self
            .frozen_s
            .map(|own| ("frozen_s", own, period_s, 2_592_000.0));
        for (option, found, low, high) in ranges.into_iter().chain(frozen) {
            // NaN is in no range.
            if !(low..=high).contains(&found) {
                let expected = format!("{low} to {high} with samples of {period_s} s");
                return Err(HygieneError {
                    option,
                    expected,
                    found,
                });
            }
        }
        let slots = (self.reorder_s + self.gap_s) / period_s;
        if slots > MOST_SLOTS {
            let most_s = MOST_SLOTS * period_s;
            return Err(HygieneError {
                option: "reorder_s",
                expected: format!("with gap_s at most {most_s} with samples of {period_s} s"),
                found: self.reorder_s + self.gap_s,
            });
        }
        Ok(())
    }
}

/// The most samples that wait: what a machine may hold in memory.
const MOST_SLOTS: f64 = 10_000.0;

/// What became of readings and samples.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(default)]
pub struct HygieneCounts {
    /// Readings that were taken.
    pub accepted: u64,
    /// Readings of a time and tag that had one; the first counts.
    pub duplicate: u64,
    /// Readings of samples that had been judged.
    pub late: u64,
    /// Readings from ahead of the clock.
    pub future: u64,
    /// Readings without a usable value.
    pub bad: u64,
    /// Values that were held.
    pub held: u64,
    /// Values that were missing at their sample.
    pub missing: u64,
    /// Values that had been the same for too long.
    pub frozen: u64,
    /// Samples.
    pub samples: u64,
    /// Times everything started afresh: gaps, and clocks set back.
    pub restarts: u64,
}

/// A sample on the grid of the detector's period.
#[derive(Debug, Clone, PartialEq)]
pub struct Sample {
    /// Its time in nanoseconds since 1970.
    pub time_ns: i64,
    /// Samples since everything started.
    pub index: u64,
    /// Whether everything starts afresh with it.
    pub restart: bool,
    /// Values, NaN where there is none.
    pub values: Vec<f64>,
    /// Their qualities.
    pub qualities: Vec<Quality>,
}

#[derive(Debug, Clone)]
struct Slot {
    /// `None`: no reading yet.
    readings: Vec<Option<(f64, Quality)>>,
    filled: usize,
}

/// The assembly of samples of one machine. It has no clock: `now_ns` is that of the caller.
#[derive(Debug, Clone)]
pub struct Hygiene {
    options: HygieneOptions,
    period_s: f64,
    tags: usize,
    /// Time of the sample with index 0, ns.
    origin_ns: Option<i64>,
    /// Index of the first slot.
    next: u64,
    slots: VecDeque<Slot>,
    /// Samples before a gap, given whatever they lack.
    ready: VecDeque<Sample>,
    /// Whether the next sample is the first of its grid.
    restart: bool,
    /// Value and time of each tag's last usable reading.
    last: Vec<Option<(f64, i64)>>,
    /// Of each tag's usable readings that are all the same: their value, and the times of the first and
    /// of the last.
    same: Vec<Option<(f64, i64, i64)>>,
    /// When the first of an unbroken row of late readings came.
    late_since_ns: Option<i64>,
    counts: HygieneCounts,
}

impl Hygiene {
    /// The assembly of samples of `tags` values every `period_s` seconds.
    ///
    /// # Errors
    /// [`HygieneError`] when an option makes no sense.
    pub fn new(tags: usize, period_s: f64, options: HygieneOptions) -> Result<Self, HygieneError> {
        options.check(period_s)?;
        Ok(Self {
            options,
            period_s,
            tags,
            origin_ns: None,
            next: 0,
            slots: VecDeque::new(),
            ready: VecDeque::new(),
            restart: true,
            last: vec![None; tags],
            same: vec![None; tags],
            late_since_ns: None,
            counts: HygieneCounts::default(),
        })
    }

    /// What became of readings and samples.
    pub fn counts(&self) -> &HygieneCounts {
        &self.counts
    }

    /// Goes on counting from there, after a restart of the program.
    pub fn set_counts(&mut self, counts: HygieneCounts) {
        self.counts = counts;
    }

    /// Goes on after the sample of a time, as if it had just been given, on the same grid.
    pub fn resume_after(&mut self, origin_ns: i64, index: u64) {
        self.origin_ns = Some(origin_ns);
        self.next = index + 1;
        self.slots.clear();
        self.ready.clear();
        self.restart = false;
    }

    /// Whether a tag's last reading was the same for too long.
    pub fn is_frozen(&self, tag: usize) -> bool {
        let same = self.same.get(tag).copied().flatten();
        same.zip(self.options.frozen_s)
            .is_some_and(|((_, first_ns, last_ns), own)| {
                (last_ns - first_ns) as f64 / SECOND_NS >= own
            })
    }

    /// Time of the sample of index 0 and the index of the next sample.
    pub fn grid(&self) -> Option<(i64, u64)> {
        Some((self.origin_ns?, self.next))
    }

    /// Takes a reading that came at `now_ns`. Samples that it makes whole are then to be had from
    /// [`Hygiene::pop`], which is to be called until it has none.
    pub fn offer(&mut self, reading: &Reading, now_ns: i64) {
        if reading.tag >= self.tags {
            return;
        }
        let ahead_ns = reading.time_ns.saturating_sub(now_ns);
        if ahead_ns as f64 > self.options.future_s * SECOND_NS {
            self.counts.future += 1;
            return;
        }
        let origin_ns = *self.origin_ns.get_or_insert(reading.time_ns);
        let place = reading.time_ns.saturating_sub(origin_ns) as f64 / (self.period_s * SECOND_NS);
        let mut ahead = place.round() - self.next as f64;
        if ahead < 0.0 {
            let since_ns = *self.late_since_ns.get_or_insert(now_ns);
            if now_ns.saturating_sub(since_ns) as f64 <= self.options.restart_s * SECOND_NS {
                self.counts.late += 1;
                return;
            }
            self.begin_afresh(reading.time_ns);
            ahead = 0.0;
        }
        self.late_since_ns = None;
        let gap_slots = (self.options.gap_s / self.period_s).ceil();
        if ahead - self.slots.len() as f64 >= gap_slots {
            self.begin_afresh(reading.time_ns);
            ahead = 0.0;
        }
        #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)] // below MOST_SLOTS
        self.place(reading, ahead as usize);
    }

    /// Gives what waits, whatever it lacks, and begins a grid at this time.
    fn begin_afresh(&mut self, time_ns: i64) {
        while let Some(sample) = self.give() {
            self.ready.push_back(sample);
        }
        self.origin_ns = Some(time_ns);
        self.next = 0;
        self.restart = true;
        self.last.fill(None);
        self.same.fill(None);
    }

    fn place(&mut self, reading: &Reading, place: usize) {
        while self.slots.len() <= place {
            self.slots.push_back(Slot {
                readings: vec![None; self.tags],
                filled: 0,
            });
        }
        let Some(own) = self
            .slots
            .get_mut(place)
            .and_then(|slot| Some((slot.readings.get_mut(reading.tag)?, &mut slot.filled)))
        else {
            return;
        };
        let (own, filled) = own;
        if own.is_some() {
            self.counts.duplicate += 1;
            return;
        }
        let usable = reading.quality.is_usable() && reading.value.is_finite();
        let (value, quality) = if usable {
            (reading.value, reading.quality)
        } else {
            self.counts.bad += 1;
            (f64::NAN, Quality::Bad)
        };
        *own = Some((value, quality));
        *filled += 1;
        self.counts.accepted += 1;
    }

    /// The next sample that is whole, that waited long enough for what it lacks, or that a gap
    /// follows.
    pub fn pop(&mut self) -> Option<Sample> {
        if let Some(sample) = self.ready.pop_front() {
            return Some(sample);
        }
        let waiting = (self.options.reorder_s / self.period_s).ceil();
        let front = self.slots.front()?;
        if front.filled < self.tags && self.slots.len() as f64 <= waiting + 1.0 {
            return None;
        }
        self.give()
    }

    /// The next sample, whatever it lacks: at the end of a record, or after a time of silence.
    pub fn drain(&mut self) -> Option<Sample> {
        let ready = self.ready.pop_front();
        ready.or_else(|| self.give())
    }

    fn give(&mut self) -> Option<Sample> {
        let slot = self.slots.pop_front()?;
        let index = self.next;
        let time_ns = self.time_ns(index)?;
        let mut sample = Sample {
            time_ns,
            index,
            restart: std::mem::take(&mut self.restart),
            values: Vec::with_capacity(self.tags),
            qualities: Vec::with_capacity(self.tags),
        };
        let age_s = |since_ns: i64| (time_ns - since_ns) as f64 / SECOND_NS;
        let kept = self.last.iter_mut().zip(&mut self.same);
        for (reading, (last, same)) in slot.readings.into_iter().zip(kept) {
            let (value, quality) = match reading {
                Some((value, quality)) if quality.is_usable() => {
                    let first_ns = match *same {
                        Some((before, first_ns, _)) if before.to_bits() == value.to_bits() => {
                            first_ns
                        }
                        _ => time_ns,
                    };
                    *same = Some((value, first_ns, time_ns));
                    if (self.options.frozen_s).is_some_and(|own| age_s(first_ns) >= own) {
                        self.counts.frozen += 1;
                        // Not even held.
                        *last = None;
                        (f64::NAN, Quality::Stale)
                    } else {
                        *last = Some((value, time_ns));
                        (value, quality)
                    }
                }
                _ => match *last {
                    Some((value, since_ns)) if age_s(since_ns) <= self.options.hold_s => {
                        self.counts.held += 1;
                        (value, Quality::Interpolated)
                    }
                    Some((_, since_ns)) if age_s(since_ns) <= self.options.age_s => {
                        self.counts.missing += 1;
                        (f64::NAN, Quality::Bad)
                    }
                    _ => {
                        self.counts.missing += 1;
                        (f64::NAN, Quality::Stale)
                    }
                },
            };
            sample.values.push(value);
            sample.qualities.push(quality);
        }
        self.counts.samples += 1;
        self.counts.restarts += u64::from(sample.restart);
        self.next += 1;
        Some(sample)
    }

    fn time_ns(&self, index: u64) -> Option<i64> {
        let after_ns = (index as f64 * self.period_s * SECOND_NS).round();
        #[allow(clippy::cast_possible_truncation)] // saturates, in the year 2262
        Some(self.origin_ns?.saturating_add(after_ns as i64))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    const PERIOD_NS: i64 = 80_000_000;
    const NOW_NS: i64 = i64::MAX / 4;

    fn reading(tag: usize, k: i64, value: f64) -> Reading {
        Reading {
            tag,
            time_ns: k * PERIOD_NS,
            value,
            quality: Quality::Good,
        }
    }

    fn hygiene(options: HygieneOptions) -> Hygiene {
        Hygiene::new(2, 0.08, options).unwrap()
    }

    /// Both tags of the samples `from..to`.
    fn feed(hygiene: &mut Hygiene, samples: std::ops::Range<i64>) -> Vec<Sample> {
        let mut found = Vec::new();
        for k in samples {
            for tag in 0..2 {
                hygiene.offer(&reading(tag, k, k as f64), NOW_NS);
            }
            found.extend(std::iter::from_fn(|| hygiene.pop()));
        }
        found
    }

    #[test]
    fn whole_samples_come_at_once() {
        let mut own = hygiene(HygieneOptions::default());
        let samples = feed(&mut own, 100..150);
        assert_eq!(samples.len(), 50);
        for (k, sample) in (100..).zip(&samples) {
            assert_eq!(sample.time_ns, k * PERIOD_NS);
            assert_eq!(sample.values, [k as f64; 2]);
            assert_eq!(sample.qualities, [Quality::Good; 2]);
            assert_eq!(sample.restart, k == 100);
        }
        assert_eq!(own.counts().accepted, 100);
        assert_eq!(own.counts().missing, 0);
    }

    /// A tag that reads the same for `frozen_s` is stale from then on, until it moves or everything
    /// starts afresh; without the option it never is.
    #[test]
    fn a_tag_that_stands_still_is_stale_when_that_is_asked_for() {
        let stands = |options: HygieneOptions| {
            let mut own = hygiene(options);
            let mut found = Vec::new();
            // Tag 1 moves at the 12th sample, and after the 20th nothing comes for four seconds.
            for k in (0..20).chain(70..75) {
                own.offer(&reading(0, k, k as f64), NOW_NS);
                own.offer(&reading(1, k, if k < 12 { 1.0 } else { 2.0 }), NOW_NS);
                found.extend(std::iter::from_fn(|| own.pop()));
            }
            let qualities: Vec<Quality> = found.iter().map(|sample| sample.qualities[1]).collect();
            assert!(
                found
                    .iter()
                    .all(|sample| sample.qualities[0] == Quality::Good)
            );
            for sample in &found {
                assert_eq!(
                    sample.values[1].is_nan(),
                    sample.qualities[1] == Quality::Stale
                );
            }
            (qualities, own)
        };
        let (always, own) = stands(HygieneOptions::default());
        assert_eq!(always, [Quality::Good; 25]);
        assert!(!own.is_frozen(1));

        let options = HygieneOptions {
            frozen_s: Some(0.4),
            ..HygieneOptions::default()
        };
        let (found, own) = stands(options);
        let (good, stale) = (Quality::Good, Quality::Stale);
        let expected = [(good, 5), (stale, 7), (good, 5), (stale, 3), (good, 5)];
        let expected = expected.map(|(quality, times)| vec![quality; times]);
        assert_eq!(found, expected.concat());
        assert_eq!((own.counts().frozen, own.counts().missing), (10, 0));
        assert!(!own.is_frozen(1) && !own.is_frozen(7));

        // A value that was the same for too long does not stand in for a missing one either.
        let mut own = hygiene(HygieneOptions {
            hold_s: 1.0,
            ..options
        });
        let mut found = Vec::new();
        for k in 0..10 {
            own.offer(&reading(0, k, k as f64), NOW_NS);
            if k < 6 {
                own.offer(&reading(1, k, 1.0), NOW_NS);
            }
            found.extend(std::iter::from_fn(|| own.pop()));
        }
        found.extend(std::iter::from_fn(|| own.drain()));
        assert!(own.is_frozen(1) && !own.is_frozen(0));
        let qualities: Vec<Quality> = found.iter().map(|sample| sample.qualities[1]).collect();
        assert_eq!(qualities, [vec![good; 5], vec![stale; 5]].concat());
    }

    #[test]
    fn duplicates_late_and_future_readings_are_dropped_and_counted() {
        let mut own = hygiene(HygieneOptions::default());
        own.offer(&reading(0, 10, 1.0), NOW_NS);
        own.offer(&reading(0, 10, 2.0), NOW_NS);
        own.offer(&reading(1, 10, 3.0), NOW_NS);
        assert_eq!(own.pop().unwrap().values, [1.0, 3.0]);
        own.offer(&reading(1, 10, 4.0), NOW_NS);
        let ahead = Reading {
            time_ns: NOW_NS + 11_000_000_000,
            ..reading(0, 0, 5.0)
        };
        own.offer(&ahead, NOW_NS);
        let counts = own.counts();
        assert_eq!([counts.duplicate, counts.late, counts.future], [1, 1, 1]);
        assert!(own.pop().is_none());
    }

    #[test]
    fn a_sample_waits_for_what_it_lacks_and_no_longer() {
        let options = HygieneOptions {
            reorder_s: 0.24,
            ..HygieneOptions::default()
        };
        let mut own = hygiene(options);
        assert_eq!(feed(&mut own, 0..1).len(), 1);
        // Of sample 1 the second tag is missing: it waits while 2, 3 and 4 come.
        own.offer(&reading(0, 1, 1.0), NOW_NS);
        assert_eq!(feed(&mut own, 2..5).len(), 0);
        let found = feed(&mut own, 5..6);
        assert_eq!(found.len(), 5);
        assert!(found[0].values[1].is_nan());
        assert_eq!(found[0].qualities, [Quality::Good, Quality::Bad]);
        // A reading within that time is in its place.
        own.offer(&reading(0, 6, 6.0), NOW_NS);
        own.offer(&reading(1, 7, 7.0), NOW_NS);
        own.offer(&reading(0, 7, 7.0), NOW_NS);
        own.offer(&reading(1, 6, 6.0), NOW_NS);
        let found: Vec<_> = std::iter::from_fn(|| own.pop()).collect();
        assert_eq!(found[0].values, [6.0; 2]);
        assert_eq!(found[1].values, [7.0; 2]);
    }

    #[test]
    fn bad_values_are_none_then_stale_and_held_only_when_asked() {
        let bad = |k| Reading {
            quality: Quality::Bad,
            ..reading(1, k, 7.0)
        };
        let of_tag = |hold_s| {
            let options = HygieneOptions {
                age_s: 0.4,
                hold_s,
                ..HygieneOptions::default()
            };
            let mut own = hygiene(options);
            feed(&mut own, 0..1);
            (1..9)
                .map(|k| {
                    own.offer(&reading(0, k, 0.0), NOW_NS);
                    own.offer(&bad(k), NOW_NS);
                    let sample = own.pop().unwrap();
                    (sample.values[1].to_bits(), sample.qualities[1])
                })
                .collect::<Vec<_>>()
        };
        let nan = f64::NAN.to_bits();
        let dropped = of_tag(0.0);
        assert_eq!(dropped[..5], vec![(nan, Quality::Bad); 5]);
        assert_eq!(dropped[5..], vec![(nan, Quality::Stale); 3]);
        let held = of_tag(0.16);
        assert_eq!(
            held[..2],
            vec![(0.0_f64.to_bits(), Quality::Interpolated); 2]
        );
        assert_eq!(held[2..], dropped[2..]);
    }

    #[test]
    fn a_gap_gives_what_waits_and_begins_afresh() {
        let mut own = hygiene(HygieneOptions::default());
        feed(&mut own, 0..10);
        own.offer(&reading(0, 10, 10.0), NOW_NS);
        // 2 s are 25 samples: 34 is not yet a gap.
        let found = feed(&mut own, 34..35);
        assert_eq!(found.len(), 17, "those that waited too long");
        assert!(found.iter().all(|sample| !sample.restart));
        let found = feed(&mut own, 90..92);
        let restarts: Vec<_> = found.iter().filter(|sample| sample.restart).collect();
        assert_eq!(restarts.len(), 1);
        assert_eq!(restarts[0].time_ns, 90 * PERIOD_NS);
        assert_eq!(restarts[0].index, 0);
        assert_eq!(own.counts().restarts, 2);
    }

    #[test]
    fn a_clock_set_back_is_followed_after_a_time() {
        let mut own = hygiene(HygieneOptions::default());
        feed(&mut own, 10_000..10_010);
        let mut restarted = None;
        for k in 0..1000 {
            let now_ns = NOW_NS + k * PERIOD_NS;
            own.offer(&reading(0, k, 0.0), now_ns);
            own.offer(&reading(1, k, 0.0), now_ns);
            if let Some(sample) = own.pop() {
                assert_eq!(sample.restart, restarted.is_none());
                restarted.get_or_insert(k);
            }
        }
        // 30 s are 375 samples.
        assert_eq!(restarted, Some(376));
        assert_eq!(own.counts().late, 2 * 376);
    }

    #[test]
    fn one_late_reading_among_good_ones_sets_no_clock_back() {
        let mut own = hygiene(HygieneOptions::default());
        for k in 0..2000 {
            let now_ns = NOW_NS + k * PERIOD_NS;
            for tag in 0..2 {
                own.offer(&reading(tag, k, 0.0), now_ns);
            }
            own.offer(&reading(0, k - 50, 0.0), now_ns);
            while own.pop().is_some() {}
        }
        assert_eq!(own.counts().restarts, 1);
        assert_eq!(own.counts().samples, 2000);
    }

    #[test]
    fn options_that_make_no_sense_are_refused() {
        let refused = |options: HygieneOptions| {
            Hygiene::new(2, 0.08, options)
                .map(|_| ())
                .unwrap_err()
                .to_string()
        };
        let options = HygieneOptions::default();
        assert_eq!(
            refused(HygieneOptions {
                gap_s: 0.1,
                ..options
            }),
            "gap_s: expected 0.16 to 86400 with samples of 0.08 s, found 0.1"
        );
        assert_eq!(
            refused(HygieneOptions {
                reorder_s: f64::NAN,
                ..options
            }),
            "reorder_s: expected 0 to 3600 with samples of 0.08 s, found NaN"
        );
        assert_eq!(
            refused(HygieneOptions {
                reorder_s: 3000.0,
                ..options
            }),
            "reorder_s: expected with gap_s at most 800 with samples of 0.08 s, found 3002"
        );
    }

    proptest! {
        /// Whatever comes, samples advance by one period or begin afresh, nothing is lost without
        /// being counted, and no more waits than the options say.
        #[test]
        fn prop_samples_are_in_order_whatever_comes(
            readings in proptest::collection::vec(
                (0..4_usize, prop_oneof![0..300_i64, any::<i64>()], any::<f64>(), 0..5_u8), 0..400),
        ) {
            let mut own = hygiene(HygieneOptions::default());
            let mut before: Option<Sample> = None;
            let mut offered = 0;
            let mut now_ns = NOW_NS;
            for (tag, time, value, quality) in readings {
                let time_ns = if time.unsigned_abs() < 300 { time * PERIOD_NS / 3 } else { time };
                let quality = [Quality::Good, Quality::Uncertain, Quality::Interpolated, Quality::Bad,
                    Quality::Stale][usize::from(quality)];
                now_ns = now_ns.saturating_add(PERIOD_NS);
                offered += u64::from(tag < 2);
                own.offer(&Reading { tag, time_ns, value, quality }, now_ns);
                while let Some(sample) = own.pop() {
                    if let Some(before) = before.replace(sample.clone()) {
                        if sample.restart {
                            prop_assert_eq!(sample.index, 0);
                        } else {
                            prop_assert_eq!(sample.index, before.index + 1);
                            prop_assert_eq!(
                                sample.time_ns.saturating_sub(before.time_ns), PERIOD_NS);
                        }
                    }
                    for (value, quality) in sample.values.iter().zip(&sample.qualities) {
                        prop_assert_eq!(value.is_finite(), quality.is_usable());
                    }
                }
                prop_assert!(own.slots.len() <= 7 + 1 + 25);
            }
            let counts = own.counts();
            prop_assert_eq!(
                counts.accepted + counts.duplicate + counts.late + counts.future, offered);
        }
    }
}
