//! One machine: readings in, samples, verdicts and alarms out.

use gt_log::DetectorFile;
use serde::{Deserialize, Serialize};

use super::alarm::{Alarm, AlarmEvent};
use super::alarm_error::AlarmError;
use super::alarm_list::{AlarmList, AlarmListState, Condition};
use super::alarm_options::AlarmOptions;
use super::hygiene::{Hygiene, HygieneCounts, HygieneError, HygieneOptions, Sample};
use super::trend::Trend;
use super::watch::{Watch, WatchEvent, WatchState};
use super::{Quality, Reading};

const MILLISECOND_NS: i64 = 1_000_000;
/// Length and number of the buckets of the trend: an hour.
const BUCKET_MS: i64 = 1000;
const BUCKETS: usize = 3600;

/// How a machine stands.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum MachineState {
    /// No sample has come yet.
    NoData,
    /// The detector does not judge yet.
    Settling,
    /// Judged, and no alarm.
    Healthy,
    /// There is an active alarm.
    Alarm,
    /// Nothing, or no good value of one of its tags, has come for longer than it may be silent.
    Stale,
    /// It has no detector.
    Failed,
}

/// What a machine is set up with.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct MachineOptions {
    /// How readings become samples.
    pub hygiene: HygieneOptions,
    /// How alarms come and go.
    pub alarms: AlarmOptions,
}

/// A machine that cannot be set up.
#[derive(Debug, thiserror::Error)]
pub enum MachineError {
    /// Of its detector.
    #[error(transparent)]
    Detector(#[from] gtfdi::fdi::FdiError),
    /// An option of the hygiene.
    #[error(transparent)]
    Hygiene(#[from] HygieneError),
    /// An option of the alarms.
    #[error(transparent)]
    Alarms(#[from] AlarmError),
    /// A new detector reads other tags than the machine has.
    #[error(
        "detector `{name}`: expected the tags {expected:?} every {period_s} s, found {found:?} every {found_s} s"
    )]
    OtherTags {
        /// The detector's name.
        name: String,
        /// Tags of the machine.
        expected: Vec<String>,
        /// Sample time of the machine in seconds.
        period_s: f64,
        /// Tags of the detector.
        found: Vec<String>,
        /// Sample time of the detector in seconds.
        found_s: f64,
    },
}

/// All that a machine remembers, for a restart.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct MachineSnapshot {
    /// Of the snapshot's form.
    pub schema_version: u32,
    /// Time of the sample of index 0 of the grid, in nanoseconds since 1970.
    origin_ns: i64,
    /// Index of the last sample.
    index: u64,
    counts: HygieneCounts,
    watch: WatchState,
    /// Keys of the detector's alarms that were up.
    up: Vec<usize>,
    alarms: AlarmListState,
}

/// The version of [`MachineSnapshot`] that is written and read.
pub const SNAPSHOT_SCHEMA_VERSION: u32 = 1;

/// A machine with its detector. It has no clock and does no input or output.
pub struct Machine {
    name: String,
    options: MachineOptions,
    hygiene: Hygiene,
    watch: Watch,
    alarms: AlarmList,
    trend: Trend,
    last: Option<Sample>,
    /// Time of the sample of index 0, ns.
    origin_ns: i64,
    arrived_ns: Option<i64>,
    judged: bool,
    next_id: u64,
    id_stride: u64,
}

impl Machine {
    /// A machine before its first sample.
    ///
    /// # Errors
    /// [`MachineError`] when the detector or an option makes no sense.
    pub fn new(
        name: impl Into<String>,
        detector: &DetectorFile,
        options: MachineOptions,
    ) -> Result<Self, MachineError> {
        let name = name.into();
        options.alarms.check()?;
        let watch = Watch::new(detector)?;
        let tags = watch.inputs().len() + watch.outputs().len();
        let series = tags + watch.outputs().len() + watch.limits().len();
        Ok(Self {
            hygiene: Hygiene::new(tags, watch.sample_time_s(), options.hygiene)?,
            alarms: AlarmList::new(name.clone(), watch.name(), options.alarms.clone()),
            trend: Trend::new(series, BUCKET_MS, BUCKETS),
            name,
            options,
            watch,
            last: None,
            origin_ns: 0,
            arrived_ns: None,
            judged: false,
            next_id: 1,
            id_stride: 1,
        })
    }

    /// Numbers of alarms are `first`, `first + stride`, ...: so that several machines share one row
    /// of numbers without asking each other.
    pub fn set_ids(&mut self, first: u64, stride: u64) {
        self.next_id = first;
        self.id_stride = stride.max(1);
    }

    /// Its name.
    pub fn name(&self) -> &str {
        &self.name
    }

    /// Its detector.
    pub fn watch(&self) -> &Watch {
        &self.watch
    }

    /// What became of its readings.
    pub fn counts(&self) -> &HygieneCounts {
        self.hygiene.counts()
    }

    /// Its alarms.
    pub fn alarms(&self) -> &AlarmList {
        &self.alarms
    }

    /// The last sample.
    pub fn last(&self) -> Option<&Sample> {
        self.last.as_ref()
    }

    /// Its recent past: inputs, outputs, residuals and statistics, in this order.
    pub fn trend(&self) -> &Trend {
        &self.trend
    }

    /// Tags in the order of a sample: inputs, then outputs.
    pub fn tags(&self) -> impl Iterator<Item = &str> {
        let signals = self.watch.inputs().iter().chain(self.watch.outputs());
        signals.map(|signal| signal.name.as_str())
    }

    /// How it stands.
    pub fn state(&self, now_ns: i64) -> MachineState {
        let age_ns = self.options.hygiene.age_s * 1e9;
        match self.arrived_ns {
            None => MachineState::NoData,
            _ if self.alarms.open().any(Alarm::is_active) => MachineState::Alarm,
            Some(arrived_ns) if now_ns.saturating_sub(arrived_ns) as f64 > age_ns => {
                MachineState::Stale
            }
            _ if self.stale_tags().next().is_some() => MachineState::Stale,
            _ if !self.judged => MachineState::Settling,
            _ => MachineState::Healthy,
        }
    }

    /// Tags that have had no good value for longer than they may; what needs them is not judged.
    pub fn stale_tags(&self) -> impl Iterator<Item = &str> {
        let qualities = self.last.iter().flat_map(|sample| &sample.qualities);
        let tags = qualities.zip(self.tags());
        tags.filter(|(quality, _)| **quality == Quality::Stale)
            .map(|(_, tag)| tag)
    }

    /// Those of them that read the same for longer than they may.
    pub fn frozen_tags(&self) -> impl Iterator<Item = &str> {
        let tags = self.tags().enumerate();
        tags.filter(|(index, _)| self.hygiene.is_frozen(*index))
            .map(|(_, tag)| tag)
    }

    /// Takes a reading that came at `now_ns`; `each` sees every sample that it completes, after it
    /// was judged.
    pub fn offer(&mut self, reading: &Reading, now_ns: i64, mut each: impl FnMut(&Self, &Sample)) {
        self.arrived_ns = Some(now_ns);
        self.hygiene.offer(reading, now_ns);
        while let Some(sample) = self.hygiene.pop() {
            self.judge(&sample);
            each(self, &sample);
            self.last = Some(sample);
        }
    }

    /// Judges what still waits: at the end of a record, or when nothing more comes.
    pub fn drain(&mut self, mut each: impl FnMut(&Self, &Sample)) {
        while let Some(sample) = self.hygiene.drain() {
            self.judge(&sample);
            each(self, &sample);
            self.last = Some(sample);
        }
    }

    /// Judges what still waits where nothing has come for as long as a sample waits.
    pub fn drain_if_silent(&mut self, now_ns: i64, each: impl FnMut(&Self, &Sample)) {
        let patience_ns = self
            .options
            .hygiene
            .reorder_s
            .max(self.watch.sample_time_s())
            * 1e9;
        let silent_ns = self
            .arrived_ns
            .map_or(0, |arrived_ns| now_ns.saturating_sub(arrived_ns));
        if silent_ns as f64 > patience_ns {
            self.drain(each);
        }
    }

    /// What depends on the service's clock alone.
    pub fn tick(&mut self, now_ms: i64) {
        self.alarms.tick(now_ms);
    }

    /// What happened to its alarms since this was last asked.
    pub fn take_events(&mut self) -> Vec<AlarmEvent> {
        self.alarms.take_events()
    }

    /// The alarms, for what operators do.
    pub fn alarms_mut(&mut self) -> &mut AlarmList {
        &mut self.alarms
    }

    fn judge(&mut self, sample: &Sample) {
        let period_s = self.watch.sample_time_s();
        let time_ms = sample.time_ns.div_euclid(MILLISECOND_NS);
        if sample.restart {
            self.watch.reset();
            let detector = self.watch.name().to_owned();
            self.alarms.start_afresh(&detector, time_ms);
        }
        #[allow(clippy::cast_possible_truncation)] // of a time since 1970
        let after_ns = (sample.index as f64 * period_s * 1e9).round() as i64;
        self.origin_ns = sample.time_ns.saturating_sub(after_ns);
        let origin_ns = self.origin_ns;
        let at_ms = |t_s: f64| {
            #[allow(clippy::cast_possible_truncation)] // saturates
            let ns = origin_ns.saturating_add((t_s * 1e9).round() as i64);
            ns.div_euclid(MILLISECOND_NS)
        };
        let (u, y) = sample.values.split_at(self.watch.inputs().len());
        let t_s = sample.index as f64 * period_s;
        // Sizes and times are right by construction.
        let events = self.watch.step(t_s, u, y).map(<[_]>::to_vec);
        for event in events.unwrap_or_default() {
            match event {
                WatchEvent::Raised {
                    key,
                    statistic,
                    value,
                    limit,
                    onset_s,
                } => {
                    let source = self.watch.statistic_names().get(statistic);
                    let condition = Condition {
                        key,
                        source: source.cloned().unwrap_or_default(),
                        statistic: value,
                        threshold: limit,
                        onset_ms: onset_s.map(at_ms),
                    };
                    self.alarms.raise(condition, time_ms);
                    self.advance(time_ms);
                }
                WatchEvent::Diagnosed { key, diagnosis } => {
                    self.alarms.learn(key, &diagnosis, time_ms, at_ms);
                }
                WatchEvent::Ended { key } => self.alarms.end(key, time_ms),
            }
        }
        self.judged =
            !self.watch.is_settling() && sample.qualities.iter().all(|quality| quality.is_usable());
        self.advance(time_ms);
        let values = sample.values.iter();
        let series = values
            .chain(self.watch.residuals())
            .chain(self.watch.statistics());
        self.trend.push(time_ms, series.copied());
    }

    fn advance(&mut self, time_ms: i64) {
        let (next_id, stride) = (&mut self.next_id, self.id_stride);
        self.alarms.advance(time_ms, self.judged, || {
            let id = *next_id;
            *next_id += stride;
            id
        });
    }

    /// Puts another detector in the place of the one it has; it starts afresh, and alarms that are
    /// up stand until it has judged.
    ///
    /// # Errors
    /// [`MachineError`] when it reads other tags or samples of another period; the machine is then
    /// as it was.
    pub fn reload(&mut self, detector: &DetectorFile, now_ms: i64) -> Result<(), MachineError> {
        let watch = Watch::new(detector)?;
        let tags = |watch: &Watch| {
            let signals = watch.inputs().iter().chain(watch.outputs());
            signals
                .map(|signal| signal.name.clone())
                .collect::<Vec<_>>()
        };
        let (expected, found) = (tags(&self.watch), tags(&watch));
        let split = (self.watch.inputs().len(), watch.inputs().len());
        let [period_s, found_s] = [&self.watch, &watch].map(Watch::sample_time_s);
        if expected != found || split.0 != split.1 || (period_s - found_s).abs() > 1e-9 * period_s {
            return Err(MachineError::OtherTags {
                name: watch.name().to_owned(),
                expected,
                period_s,
                found,
                found_s,
            });
        }
        self.watch = watch;
        let series = found.len() + self.watch.outputs().len() + self.watch.limits().len();
        self.trend = Trend::new(series, BUCKET_MS, BUCKETS);
        let name = self.watch.name().to_owned();
        self.alarms.start_afresh(&name, now_ms);
        self.judged = false;
        Ok(())
    }

    /// All that it remembers; `None` before its first sample.
    pub fn snapshot(&self) -> Option<MachineSnapshot> {
        let (origin_ns, next) = self.hygiene.grid()?;
        Some(MachineSnapshot {
            schema_version: SNAPSHOT_SCHEMA_VERSION,
            origin_ns,
            index: next.checked_sub(1)?,
            counts: *self.hygiene.counts(),
            watch: self.watch.state(),
            up: self.watch.up(),
            alarms: self.alarms.state(),
        })
    }

    /// Goes on after a restart of the program with the alarms that are open and, where there is one
    /// of this detector, from a snapshot. Says why it begins afresh where it does.
    pub fn resume(
        &mut self,
        open: Vec<Alarm>,
        snapshot: Option<MachineSnapshot>,
        now_ms: i64,
    ) -> Option<String> {
        let Some(snapshot) = snapshot else {
            self.alarms.resume(open, None, now_ms);
            return Some("there is no snapshot".to_owned());
        };
        if snapshot.schema_version != SNAPSHOT_SCHEMA_VERSION {
            self.alarms.resume(open, None, now_ms);
            return Some(format!(
                "schema_version of the snapshot: expected {SNAPSHOT_SCHEMA_VERSION}, found {}",
                snapshot.schema_version
            ));
        }
        if let Err(why) = self.watch.resume(&snapshot.watch, &snapshot.up) {
            self.alarms.resume(open, None, now_ms);
            return Some(why.to_string());
        }
        self.hygiene
            .resume_after(snapshot.origin_ns, snapshot.index);
        self.hygiene.set_counts(snapshot.counts);
        self.alarms.resume(open, Some(snapshot.alarms), now_ms);
        None
    }
}
