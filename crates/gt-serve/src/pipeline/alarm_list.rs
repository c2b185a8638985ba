//! The alarms of one machine: delays, acknowledgement, shelves, and what outlives a restart.

use std::collections::BTreeMap;

use gtfdi::fdi::NamedDiagnosis;
use serde::{Deserialize, Serialize};

use super::alarm::{Acknowledgement, Alarm, AlarmAction, AlarmEvent, AlarmState, Candidate, Shelf};
use super::alarm_error::AlarmError;
use super::alarm_options::AlarmOptions;

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

    /// An operator has seen an alarm. One that was acknowledged stays as it is, with who was first:
    /// a request whose answer was lost can be sent again.
    ///
    /// # Errors
    /// [`AlarmError`] when it is not open.
    pub fn acknowledge(
        &mut self,
        id: u64,
        by: &str,
        comment: &str,
        now_ms: i64,
    ) -> Result<Alarm, AlarmError> {
        let alarm = self.open.get_mut(&id).ok_or(AlarmError::Unknown { id })?;
        if alarm.state == AlarmState::ActiveAcknowledged {
            return Ok(alarm.clone());
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

    /// An operator takes an alarm back from the shelf; one that is not there stays as it is.
    ///
    /// # Errors
    /// [`AlarmError`] when it is not open.
    pub fn unshelve(&mut self, id: u64, by: &str, now_ms: i64) -> Result<Alarm, AlarmError> {
        let alarm = self.open.get(&id).ok_or(AlarmError::Unknown { id })?;
        if alarm.shelved.is_none() {
            return Ok(alarm.clone());
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
mod tests;
