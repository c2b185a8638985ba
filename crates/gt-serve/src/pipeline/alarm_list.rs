//! The alarms of one machine: delays, acknowledgement, shelves, and what outlives a restart.

use std::collections::BTreeMap;

use gtfdi::fdi::NamedDiagnosis;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::alarm::{Acknowledgement, Alarm, AlarmAction, AlarmEvent, AlarmState, Candidate, Shelf};

/// How alarms come and go.
///
/// | name | default | purpose | range |
/// |---|---|---|---|
/// | `on_delay_s` | 0 | how long a condition must hold before it is an alarm | 0 to 86400 |
/// | `off_delay_s` | 5 | how long it must be gone before the alarm returns | 0 to 86400 |
/// | `confirm_s` | 300 | after a gap or a restart: how long the detector judges before an alarm that it does not raise again returns | 0 to 86400 |
/// | `latch` | true | whether an alarm whose condition is gone waits for its acknowledgement | |
/// | `severity` | 500 | severity of an alarm without a name | 1 to 1000 |
/// | `severities` | none | severities by the names of faults and tests | 1 to 1000 |
/// | `longest_shelf_s` | 86400 | for how long an alarm can be set aside | 60 to 2592000 |
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct AlarmOptions {
    /// How long a condition must hold before it is an alarm, in seconds.
    pub on_delay_s: f64,
    /// How long a condition must be gone before the alarm returns, in seconds.
    pub off_delay_s: f64,
    /// How long the detector judges after it started afresh before an alarm returns that it does
    /// not raise again, in seconds.
    pub confirm_s: f64,
    /// Whether an alarm whose condition is gone waits for its acknowledgement.
    pub latch: bool,
    /// Severity of an alarm without a name in `severities`.
    pub severity: u16,
    /// Severities by the names of faults and of tests.
    pub severities: BTreeMap<String, u16>,
    /// For how long an alarm can be set aside, in seconds.
    pub longest_shelf_s: f64,
}

impl Default for AlarmOptions {
    fn default() -> Self {
        Self {
            on_delay_s: 0.0,
            off_delay_s: 5.0,
            confirm_s: 300.0,
            latch: true,
            severity: 500,
            severities: BTreeMap::new(),
            longest_shelf_s: 86_400.0,
        }
    }
}

/// A request that cannot be met.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub enum AlarmError {
    /// There is no such open alarm.
    #[error("alarm {id}: expected the number of an open alarm")]
    Unknown {
        /// The number asked for.
        id: u64,
    },
    /// The alarm is in another state.
    #[error("alarm {id}: expected {expected}, found {found}")]
    State {
        /// The alarm.
        id: u64,
        /// What it must be.
        expected: &'static str,
        /// What it is.
        found: &'static str,
    },
    /// A field of the request makes no sense.
    #[error("{field}: expected {expected}, found {found}")]
    Field {
        /// The field.
        field: &'static str,
        /// What it may be.
        expected: String,
        /// What it is.
        found: String,
    },
}

impl AlarmOptions {
    /// Refuses what makes no sense.
    ///
    /// # Errors
    /// [`AlarmError::Field`] with the first such option.
    pub fn check(&self) -> Result<(), AlarmError> {
        let ranges = [
            ("on_delay_s", self.on_delay_s, 0.0, 86_400.0),
            ("off_delay_s", self.off_delay_s, 0.0, 86_400.0),
            ("confirm_s", self.confirm_s, 0.0, 86_400.0),
            ("longest_shelf_s", self.longest_shelf_s, 60.0, 2_592_000.0),
        ];
        for (field, found, low, high) in ranges {
            if !(low..=high).contains(&found) {
                return Err(AlarmError::Field {
                    field,
                    expected: format!("{low} to {high}"),
                    found: found.to_string(),
                });
            }
        }
        let severities = self.severities.values().chain([&self.severity]);
        for found in severities {
            if !(1..=1000).contains(found) {
                return Err(AlarmError::Field {
                    field: "severity",
                    expected: "1 to 1000".to_owned(),
                    found: found.to_string(),
                });
            }
        }
        Ok(())
    }
}

/// A condition of the detector.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Condition {
    /// Which of the detector's alarms.
    pub key: usize,
    /// The statistic that raised it.
    pub source: String,
    /// Its value.
    pub statistic: f64,
    /// Its limit.
    pub threshold: f64,
    /// When it began, in milliseconds since 1970, as far as is known.
    pub onset_ms: Option<i64>,
}

/// A condition with its times.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
struct Pending {
    condition: Condition,
    since_ms: i64,
    /// When it went, while the off-delay runs.
    gone_ms: Option<i64>,
    /// The alarm, once it is one.
    alarm: Option<u64>,
}

/// What an [`AlarmList`] remembers beside its alarms.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
pub struct AlarmListState {
    pending: Vec<Pending>,
    shelves: BTreeMap<String, Shelf>,
}

/// The alarms of one machine. It has no clock: times are those of samples, and `now_ms` that of the
/// service.
#[derive(Debug, Clone)]
pub struct AlarmList {
    machine: String,
    detector: String,
    options: AlarmOptions,
    open: BTreeMap<u64, Alarm>,
    pending: Vec<Pending>,
    /// By source.
    shelves: BTreeMap<String, Shelf>,
    /// Since when the detector has judged after it started afresh.
    judging_since_ms: Option<i64>,
    events: Vec<AlarmEvent>,
}

impl AlarmList {
    /// A list without alarms.
    pub fn new(
        machine: impl Into<String>,
        detector: impl Into<String>,
        options: AlarmOptions,
    ) -> Self {
        Self {
            machine: machine.into(),
            detector: detector.into(),
            options,
            open: BTreeMap::new(),
            pending: Vec::new(),
            shelves: BTreeMap::new(),
            judging_since_ms: None,
            events: Vec::new(),
        }
    }

    /// The open alarms.
    pub fn open(&self) -> impl Iterator<Item = &Alarm> {
        self.open.values()
    }

    /// An open alarm.
    pub fn get(&self, id: u64) -> Option<&Alarm> {
        self.open.get(&id)
    }

    /// What happened since this was last asked.
    pub fn take_events(&mut self) -> Vec<AlarmEvent> {
        std::mem::take(&mut self.events)
    }

    /// What it remembers beside its alarms.
    pub fn state(&self) -> AlarmListState {
        AlarmListState {
            pending: self.pending.clone(),
            shelves: self.shelves.clone(),
        }
    }

    /// Goes on with open alarms and, where the detector goes on too, with what else it remembered.
    pub fn resume(&mut self, open: Vec<Alarm>, state: Option<AlarmListState>, now_ms: i64) {
        self.open = open.into_iter().map(|alarm| (alarm.id, alarm)).collect();
        let state = state.unwrap_or_default();
        self.shelves = state.shelves;
        for alarm in self.open.values() {
            if let Some(shelf) = &alarm.shelved {
                self.shelves.insert(alarm.source.clone(), shelf.clone());
            }
        }
        self.pending = state.pending;
        // What the snapshot does not know of was raised after it, or has returned since.
        let open = &self.open;
        self.pending.retain(|own| {
            own.alarm
                .is_none_or(|id| open.get(&id).is_some_and(Alarm::is_active))
        });
        // A condition that the snapshot has not yet as an alarm became one after it.
        for own in self.pending.iter_mut().filter(|own| own.alarm.is_none()) {
            let key = own.condition.key;
            let mut raised = self.open.values().filter(|alarm| alarm.is_active());
            own.alarm = raised.find(|alarm| alarm.key == key).map(|alarm| alarm.id);
        }
        let known: Vec<u64> = self.pending.iter().filter_map(|own| own.alarm).collect();
        self.doubt(now_ms, |alarm| !known.contains(&alarm.id));
        self.judging_since_ms = None;
    }

    /// The detector starts afresh, as `detector`: what was up has to be seen again.
    pub fn start_afresh(&mut self, detector: &str, time_ms: i64) {
        detector.clone_into(&mut self.detector);
        self.pending.clear();
        self.judging_since_ms = None;
        self.doubt(time_ms, |_| true);
    }

    /// Active alarms that are `doubted` are unconfirmed from now on, and the others are not.
    fn doubt(&mut self, time_ms: i64, doubted: impl Fn(&Alarm) -> bool) {
        for alarm in self.open.values_mut() {
            let unconfirmed = alarm.is_active() && doubted(alarm);
            if alarm.unconfirmed != unconfirmed {
                alarm.unconfirmed = unconfirmed;
                let changed = event(time_ms, AlarmAction::Changed, None, String::new(), alarm);
                self.events.push(changed);
            }
        }
    }

    /// A condition came up at a sample of this time.
    pub fn raise(&mut self, mut condition: Condition, time_ms: i64) {
        let key = condition.key;
        // JSON has no infinity.
        condition.statistic = condition.statistic.min(f64::MAX);
        if let Some(own) = self.pending.iter_mut().find(|own| own.condition.key == key) {
            // Back within the off-delay.
            own.gone_ms = None;
            return;
        }
        let stands = self
            .open
            .values_mut()
            .find(|alarm| alarm.unconfirmed && alarm.is_active() && alarm.key == key);
        let alarm = stands.map(|alarm| {
            alarm.unconfirmed = false;
            let changed = event(time_ms, AlarmAction::Changed, None, String::new(), alarm);
            self.events.push(changed);
            alarm.id
        });
        self.pending.push(Pending {
            condition,
            since_ms: time_ms,
            gone_ms: None,
            alarm,
        });
    }

    /// More is known of the condition of a key; `at_ms` turns seconds of the grid into milliseconds.
    pub fn learn(
        &mut self,
        key: usize,
        diagnosis: &NamedDiagnosis,
        time_ms: i64,
        at_ms: impl Fn(f64) -> i64,
    ) {
        let own = self.pending.iter().find(|own| own.condition.key == key);
        let Some(alarm) = own
            .and_then(|own| own.alarm)
            .and_then(|id| self.open.get_mut(&id))
        else {
            return;
        };
        let before = alarm.fault.clone();
        let renamed = alarm.learn(diagnosis, at_ms);
        alarm.severity = severity(&self.options, alarm.fault.as_deref(), &alarm.source);
        let (event, text) = if renamed {
            (AlarmAction::Named, named_text(alarm, before.as_deref()))
        } else {
            (AlarmAction::Changed, String::new())
        };
        self.events.push(AlarmEvent {
            time_ms,
            event,
            by: None,
            text,
            alarm: alarm.clone(),
        });
    }

    /// The condition of a key is gone.
    pub fn end(&mut self, key: usize, time_ms: i64) {
        if let Some(own) = self.pending.iter_mut().find(|own| own.condition.key == key) {
            own.gone_ms.get_or_insert(time_ms);
        }
    }

    /// A sample of this time has been judged, or, where the detector settles, not. Alarms whose
    /// delays are over come and go; `next_id` gives a number that was never given before.
    pub fn advance(&mut self, time_ms: i64, judged: bool, mut next_id: impl FnMut() -> u64) {
        if judged {
            self.judging_since_ms.get_or_insert(time_ms);
        } else {
            self.judging_since_ms = None;
        }
        let mut gone = Vec::new();
        for own in &mut self.pending {
            if own.alarm.is_none()
                && own.gone_ms.is_none()
                && passed(own.since_ms, time_ms, self.options.on_delay_s)
            {
                // One that waits for its acknowledgement is the same alarm, up again.
                let returned = self.open.values().find(|alarm| {
                    alarm.state == AlarmState::ReturnedUnacknowledged
                        && alarm.key == own.condition.key
                        && alarm.source == own.condition.source
                });
                let id = returned.map_or_else(&mut next_id, |alarm| alarm.id);
                let alarm = raised(
                    id,
                    &self.machine,
                    &self.detector,
                    &own.condition,
                    time_ms,
                    &self.options,
                    self.shelves.get(&own.condition.source),
                );
                own.alarm = Some(alarm.id);
                let text = format!(
                    "{} is {:.4}, above its limit of {:.4}",
                    alarm.source, alarm.statistic, alarm.threshold
                );
                self.events
                    .push(event(time_ms, AlarmAction::Raised, None, text, &alarm));
                self.open.insert(alarm.id, alarm);
            }
            let is_over = own.gone_ms.is_some_and(|gone_ms| {
                own.alarm.is_none() || passed(gone_ms, time_ms, self.options.off_delay_s)
            });
            if is_over {
                gone.push((own.condition.key, own.alarm));
            }
        }
        for (key, alarm) in gone {
            self.pending.retain(|own| own.condition.key != key);
            if let Some(id) = alarm {
                self.return_to_normal(id, time_ms, "the condition is gone");
            }
        }
        let judged_long = self
            .judging_since_ms
            .is_some_and(|since_ms| passed(since_ms, time_ms, self.options.confirm_s));
        if judged_long {
            let unseen: Vec<u64> = self
                .open
                .values()
                .filter(|alarm| alarm.unconfirmed && alarm.is_active())
                .map(|alarm| alarm.id)
                .collect();
            for id in unseen {
                self.return_to_normal(
                    id,
                    time_ms,
                    "not seen again since the detector started afresh",
                );
            }
        }
    }

    fn return_to_normal(&mut self, id: u64, time_ms: i64, why: &str) {
        let Some(alarm) = self.open.get_mut(&id) else {
            return;
        };
        alarm.ended_ms = Some(time_ms);
        alarm.unconfirmed = false;
        let acknowledged = alarm.state == AlarmState::ActiveAcknowledged;
        alarm.state = AlarmState::ReturnedUnacknowledged;
        let returned = event(time_ms, AlarmAction::Returned, None, why.to_owned(), alarm);
        self.events.push(returned);
        if acknowledged || !self.options.latch {
            self.clear(id, time_ms, None);
        }
    }

    fn clear(&mut self, id: u64, time_ms: i64, by: Option<String>) {
        if let Some(mut alarm) = self.open.remove(&id) {
            alarm.state = AlarmState::Normal;
            self.events.push(event(
                time_ms,
                AlarmAction::Cleared,
                by,
                String::new(),
                &alarm,
            ));
        }
    }

    /// An operator has seen an alarm.
    ///
    /// # Errors
    /// [`AlarmError`] when it is not open, or acknowledged already.
    pub fn acknowledge(
        &mut self,
        id: u64,
        by: &str,
        comment: &str,
        now_ms: i64,
    ) -> Result<Alarm, AlarmError> {
        let alarm = self.open.get_mut(&id).ok_or(AlarmError::Unknown { id })?;
        if alarm.state == AlarmState::ActiveAcknowledged {
            return Err(AlarmError::State {
                id,
                expected: "an alarm that is not acknowledged",
                found: "an acknowledged one",
            });
        }
        alarm.acknowledged = Some(Acknowledgement {
            by: by.to_owned(),
            at_ms: now_ms,
            comment: comment.to_owned(),
        });
        let is_over = alarm.state == AlarmState::ReturnedUnacknowledged;
        if !is_over {
            alarm.state = AlarmState::ActiveAcknowledged;
        }
        let done = alarm.clone();
        let by = Some(by.to_owned());
        self.events.push(event(
            now_ms,
            AlarmAction::Acknowledged,
            by.clone(),
            comment.to_owned(),
            &done,
        ));
        if is_over {
            self.clear(id, now_ms, by);
            return Ok(Alarm {
                state: AlarmState::Normal,
                ..done
            });
        }
        Ok(done)
    }

    /// An operator sets an alarm aside, and with it those that its statistic will raise until then.
    ///
    /// # Errors
    /// [`AlarmError`] when it is not open, or for too long.
    pub fn shelve(
        &mut self,
        id: u64,
        by: &str,
        reason: &str,
        seconds: f64,
        now_ms: i64,
    ) -> Result<Alarm, AlarmError> {
        let longest_s = self.options.longest_shelf_s;
        if !(seconds > 0.0 && seconds <= longest_s) {
            return Err(AlarmError::Field {
                field: "minutes",
                expected: format!("above 0, at most {}", longest_s / 60.0),
                found: (seconds / 60.0).to_string(),
            });
        }
        let alarm = self.open.get_mut(&id).ok_or(AlarmError::Unknown { id })?;
        #[allow(clippy::cast_possible_truncation)] // at most a month
        let shelf = Shelf {
            until_ms: now_ms.saturating_add((seconds * 1e3) as i64),
            reason: reason.to_owned(),
            by: by.to_owned(),
        };
        self.shelves.insert(alarm.source.clone(), shelf.clone());
        alarm.shelved = Some(shelf);
        let done = alarm.clone();
        let by = Some(by.to_owned());
        self.events.push(event(
            now_ms,
            AlarmAction::Shelved,
            by,
            reason.to_owned(),
            &done,
        ));
        Ok(done)
    }

    /// An operator takes an alarm back from the shelf.
    ///
    /// # Errors
    /// [`AlarmError`] when it is not open or not on the shelf.
    pub fn unshelve(&mut self, id: u64, by: &str, now_ms: i64) -> Result<Alarm, AlarmError> {
        let alarm = self.open.get(&id).ok_or(AlarmError::Unknown { id })?;
        if alarm.shelved.is_none() {
            return Err(AlarmError::State {
                id,
                expected: "an alarm on the shelf",
                found: "one that is not",
            });
        }
        let source = alarm.source.clone();
        self.take_from_shelf(&source, now_ms, Some(by));
        self.open
            .get(&id)
            .cloned()
            .ok_or(AlarmError::Unknown { id })
    }

    /// Shelves whose time is over are emptied.
    pub fn tick(&mut self, now_ms: i64) {
        let over = self.shelves.iter();
        let over: Vec<String> = over
            .filter(|(_, shelf)| shelf.until_ms <= now_ms)
            .map(|(source, _)| source.clone())
            .collect();
        for source in over {
            self.take_from_shelf(&source, now_ms, None);
        }
    }

    fn take_from_shelf(&mut self, source: &str, now_ms: i64, by: Option<&str>) {
        self.shelves.remove(source);
        for alarm in self.open.values_mut() {
            if alarm.source == source && alarm.shelved.take().is_some() {
                let text = if by.is_some() { "" } else { "its time is over" };
                self.events.push(event(
                    now_ms,
                    AlarmAction::Unshelved,
                    by.map(str::to_owned),
                    text.to_owned(),
                    alarm,
                ));
            }
        }
    }
}

fn passed(since_ms: i64, now_ms: i64, delay_s: f64) -> bool {
    now_ms.saturating_sub(since_ms) as f64 >= delay_s * 1e3
}

fn severity(options: &AlarmOptions, fault: Option<&str>, source: &str) -> u16 {
    let own = fault.and_then(|fault| options.severities.get(fault));
    let own = own.or_else(|| options.severities.get(source));
    own.copied().unwrap_or(options.severity)
}

fn named_text(alarm: &Alarm, before: Option<&str>) -> String {
    let now = match alarm.finding.as_str() {
        "none_of_these" => "none of the known faults",
        "undecided" => "not decided",
        _ => alarm.fault.as_deref().unwrap_or("not decided"),
    };
    match before {
        Some(before) => format!("{now}, no longer {before}"),
        None => now.to_owned(),
    }
}

fn event(
    time_ms: i64,
    event: AlarmAction,
    by: Option<String>,
    text: String,
    alarm: &Alarm,
) -> AlarmEvent {
    AlarmEvent {
        time_ms,
        event,
        by,
        text,
        alarm: alarm.clone(),
    }
}

fn raised(
    id: u64,
    machine: &str,
    detector: &str,
    condition: &Condition,
    time_ms: i64,
    options: &AlarmOptions,
    shelf: Option<&Shelf>,
) -> Alarm {
    Alarm {
        id,
        machine: machine.to_owned(),
        source: condition.source.clone(),
        key: condition.key,
        fault: None,
        finding: "undecided".to_owned(),
        state: AlarmState::ActiveUnacknowledged,
        shelved: shelf.cloned(),
        severity: severity(options, None, &condition.source),
        raised_ms: time_ms,
        named_ms: None,
        ended_ms: None,
        onset_ms: condition.onset_ms,
        onset_interval_ms: None,
        magnitude: None,
        magnitude_interval: None,
        unit: None,
        probability: None,
        statistic: condition.statistic,
        threshold: condition.threshold,
        hypotheses: Vec::<Candidate>::new(),
        none_of_these: None,
        acknowledged: None,
        detector: detector.to_owned(),
        unconfirmed: false,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    /// A list with its row of numbers and a clock in seconds.
    struct Desk {
        list: AlarmList,
        given: u64,
    }

    impl Desk {
        fn new(options: AlarmOptions) -> Self {
            Self {
                list: AlarmList::new("gt1", "bank", options),
                given: 0,
            }
        }

        fn raise(&mut self, key: usize, at_s: i64) {
            let condition = Condition {
                key,
                source: format!("test{key}"),
                statistic: 2.0,
                threshold: 1.0,
                onset_ms: None,
            };
            self.list.raise(condition, at_s * 1000);
        }

        fn advance(&mut self, at_s: i64, judged: bool) {
            let given = &mut self.given;
            self.list.advance(at_s * 1000, judged, || {
                *given += 1;
                *given
            });
        }

        fn said(&mut self) -> Vec<(AlarmAction, u64)> {
            let events = self.list.take_events().into_iter();
            let events = events.filter(|event| event.event != AlarmAction::Changed);
            events.map(|event| (event.event, event.alarm.id)).collect()
        }

        fn states(&self) -> Vec<AlarmState> {
            self.list.open().map(|alarm| alarm.state).collect()
        }
    }

    use AlarmAction::{Acknowledged, Cleared, Raised, Returned, Shelved, Unshelved};
    use AlarmState::{ActiveAcknowledged, ActiveUnacknowledged, Normal, ReturnedUnacknowledged};

    #[test]
    fn an_alarm_goes_through_its_states() {
        let mut desk = Desk::new(AlarmOptions::default());
        desk.raise(0, 10);
        desk.advance(10, true);
        assert_eq!(desk.states(), [ActiveUnacknowledged]);
        let done = desk.list.acknowledge(1, "a", "seen", 11_000).unwrap();
        assert_eq!(done.state, ActiveAcknowledged);
        desk.list.end(0, 20_000);
        desk.advance(24, true);
        assert_eq!(desk.states(), [ActiveAcknowledged], "the off-delay is 5 s");
        desk.advance(25, true);
        assert!(desk.states().is_empty());
        assert_eq!(
            desk.said(),
            [(Raised, 1), (Acknowledged, 1), (Returned, 1), (Cleared, 1)]
        );
    }

    #[test]
    fn what_nobody_saw_waits_and_comes_back_as_the_same() {
        let mut desk = Desk::new(AlarmOptions::default());
        desk.raise(0, 10);
        desk.advance(10, true);
        desk.list.end(0, 11_000);
        desk.advance(20, true);
        assert_eq!(desk.states(), [ReturnedUnacknowledged]);
        desk.raise(0, 30);
        desk.advance(30, true);
        assert_eq!(desk.states(), [ActiveUnacknowledged]);
        desk.list.end(0, 31_000);
        desk.advance(40, true);
        let done = desk.list.acknowledge(1, "a", "", 41_000).unwrap();
        assert_eq!(done.state, Normal);
        assert_eq!(
            desk.said(),
            [
                (Raised, 1),
                (Returned, 1),
                (Raised, 1),
                (Returned, 1),
                (Acknowledged, 1),
                (Cleared, 1)
            ]
        );
        assert_eq!(
            desk.list.acknowledge(1, "a", "", 42_000),
            Err(AlarmError::Unknown { id: 1 })
        );
    }

    #[test]
    fn without_a_latch_it_ends_by_itself() {
        let mut desk = Desk::new(AlarmOptions {
            latch: false,
            off_delay_s: 0.0,
            ..AlarmOptions::default()
        });
        desk.raise(3, 10);
        desk.advance(10, true);
        desk.list.end(3, 11_000);
        desk.advance(11, true);
        assert_eq!(desk.said(), [(Raised, 1), (Returned, 1), (Cleared, 1)]);
    }

    #[test]
    fn delays_hold_back_what_is_short() {
        let mut desk = Desk::new(AlarmOptions {
            on_delay_s: 3.0,
            ..AlarmOptions::default()
        });
        desk.raise(0, 10);
        desk.advance(12, true);
        desk.list.end(0, 12_000);
        desk.advance(13, true);
        assert!(
            desk.said().is_empty(),
            "2 s are short of the on-delay of 3 s"
        );
        desk.raise(0, 20);
        desk.advance(23, true);
        // Gone for 4 s, less than the off-delay of 5 s.
        desk.list.end(0, 24_000);
        desk.raise(0, 28);
        desk.advance(40, true);
        assert_eq!(desk.said(), [(Raised, 1)]);
        assert_eq!(desk.states(), [ActiveUnacknowledged]);
    }

    #[test]
    fn after_a_gap_the_same_condition_is_the_same_alarm() {
        let mut desk = Desk::new(AlarmOptions::default());
        desk.raise(0, 10);
        desk.advance(10, true);
        desk.list.start_afresh("bank", 15_000);
        desk.advance(20, false);
        assert!(desk.list.get(1).unwrap().unconfirmed);
        desk.raise(0, 30);
        desk.advance(30, true);
        assert!(!desk.list.get(1).unwrap().unconfirmed);
        assert_eq!(desk.said(), [(Raised, 1)]);
        assert_eq!(desk.given, 1);
    }

    #[test]
    fn what_is_not_seen_again_returns_when_it_was_looked_for_long_enough() {
        let mut desk = Desk::new(AlarmOptions::default());
        desk.raise(0, 10);
        desk.advance(10, true);
        desk.said();
        desk.list.start_afresh("bank", 15_000);
        // Settling does not count, nor does what was before it.
        desk.advance(20, true);
        desk.advance(200, false);
        desk.advance(210, true);
        desk.advance(509, true);
        assert_eq!(desk.states(), [ActiveUnacknowledged]);
        desk.advance(510, true);
        assert_eq!(desk.said(), [(Returned, 1)]);
    }

    #[test]
    fn a_shelf_holds_the_statistic_until_its_time() {
        let mut desk = Desk::new(AlarmOptions {
            latch: false,
            off_delay_s: 0.0,
            ..AlarmOptions::default()
        });
        desk.raise(0, 10);
        desk.advance(10, true);
        desk.list.shelve(1, "a", "repair", 60.0, 10_000).unwrap();
        desk.list.end(0, 11_000);
        desk.advance(11, true);
        desk.raise(0, 20);
        desk.advance(20, true);
        assert_eq!(
            desk.list.get(2).unwrap().shelved.as_ref().unwrap().reason,
            "repair"
        );
        desk.list.tick(69_999);
        assert!(desk.list.get(2).unwrap().shelved.is_some());
        desk.list.tick(70_000);
        assert!(desk.list.get(2).unwrap().shelved.is_none());
        let said = desk.said();
        assert_eq!(said[1], (Shelved, 1));
        assert_eq!(said[said.len() - 1], (Unshelved, 2));
        let refused = desk
            .list
            .shelve(2, "a", "x", 1e9, 0)
            .unwrap_err()
            .to_string();
        assert!(
            refused.starts_with("minutes: expected above 0, at most 1440"),
            "{refused}"
        );
        assert!(desk.list.shelve(2, "a", "x", f64::NAN, 0).is_err());
    }

    #[derive(Debug, Clone)]
    enum Act {
        Raise(usize),
        End(usize),
        Advance(bool),
        Afresh,
        Acknowledge(u64),
        Shelve(u64),
        Restart(bool),
    }

    fn act() -> impl Strategy<Value = Act> {
        prop_oneof![
            (0..3_usize).prop_map(Act::Raise),
            (0..3_usize).prop_map(Act::End),
            any::<bool>().prop_map(Act::Advance),
            Just(Act::Afresh),
            (1..6_u64).prop_map(Act::Acknowledge),
            (1..6_u64).prop_map(Act::Shelve),
            any::<bool>().prop_map(Act::Restart),
        ]
    }

    proptest! {
        /// Whatever happens, in whatever order, with restarts from any older state: of each
        /// statistic at most one alarm is active, its events follow each other as they can, and what
        /// the events say last is what there is.
        #[test]
        fn prop_events_are_the_whole_truth(
            acts in proptest::collection::vec((act(), 0..400_i64), 0..120), latch in any::<bool>(),
        ) {
            let options = AlarmOptions { latch, ..AlarmOptions::default() };
            let mut desk = Desk::new(options.clone());
            let mut told: BTreeMap<u64, Alarm> = BTreeMap::new();
            let mut old = desk.list.state();
            let mut now_s = 0;
            for (act, after_s) in acts {
                now_s += after_s;
                match act {
                    Act::Raise(key) => desk.raise(key, now_s),
                    Act::End(key) => desk.list.end(key, now_s * 1000),
                    Act::Advance(judged) => desk.advance(now_s, judged),
                    Act::Afresh => desk.list.start_afresh("bank", now_s * 1000),
                    Act::Acknowledge(id) => { let _ = desk.list.acknowledge(id, "a", "", now_s * 1000); }
                    Act::Shelve(id) => { let _ = desk.list.shelve(id, "a", "b", 60.0, now_s * 1000); }
                    Act::Restart(keeps) => {
                        let open: Vec<Alarm> = told.values().filter(|own| own.is_open()).cloned().collect();
                        desk.list = AlarmList::new("gt1", "bank", options.clone());
                        desk.list.resume(open, keeps.then(|| old.clone()), now_s * 1000);
                    }
                }
                desk.list.tick(now_s * 1000);
                for event in desk.list.take_events() {
                    let id = event.alarm.id;
                    let before = told.get(&id).map(|own| own.state);
                    let follows = match event.event {
                        Raised => matches!(before, None | Some(ReturnedUnacknowledged)),
                        Acknowledged => matches!(before, Some(ActiveUnacknowledged | ReturnedUnacknowledged)),
                        Returned => matches!(before, Some(ActiveUnacknowledged | ActiveAcknowledged)),
                        Cleared => matches!(before, Some(ReturnedUnacknowledged)),
                        _ => before.is_some_and(|state| state != Normal),
                    };
                    prop_assert!(follows, "{:?} after {before:?}", event.event);
                    told.insert(id, event.alarm);
                }
                let open: Vec<&Alarm> = desk.list.open().collect();
                let known: Vec<&Alarm> = told.values().filter(|own| own.is_open()).collect();
                prop_assert_eq!(open, known);
                for key in 0..3 {
                    let active = desk.list.open().filter(|own| own.is_active() && own.key == key);
                    prop_assert!(active.count() <= 1, "two alarms of test {key}");
                }
                if now_s % 3 == 0 {
                    old = desk.list.state();
                }
            }
        }
    }
}
