//! The history of all alarms, in memory to be asked.

use std::collections::BTreeMap;

use crate::pipeline::{Alarm, AlarmEvent, AlarmState};

/// Closed alarms that are kept.
const KEPT_ALARMS: usize = 10_000;
/// Events of one alarm that are kept: all of the usual alarm's.
const KEPT_EVENTS: usize = 100;
/// Events of all alarms up to which closed ones are kept, some 50 MB. Open ones are never forgotten.
const KEPT_IN_ALL: usize = 50_000;

/// All alarms with their events.
#[derive(Debug, Default)]
pub struct History {
    alarms: BTreeMap<u64, Entry>,
    /// Events of all alarms.
    events: usize,
    /// The largest number ever given.
    largest_id: u64,
}

#[derive(Debug)]
struct Entry {
    alarm: Alarm,
    events: Vec<AlarmEvent>,
}

impl History {
    /// Takes an event.
    pub fn remember(&mut self, event: AlarmEvent) {
        let id = event.alarm.id;
        self.largest_id = self.largest_id.max(id);
        let entry = self.alarms.entry(id).or_insert_with(|| Entry {
            alarm: event.alarm.clone(),
            events: Vec::new(),
        });
        entry.alarm = event.alarm.clone();
        if event.event.is_kept() {
            if entry.events.len() >= KEPT_EVENTS {
                // The first says how it began.
                entry.events.remove(1);
                self.events -= 1;
            }
            entry.events.push(event);
            self.events += 1;
        }
        while self.alarms.len() > KEPT_ALARMS || self.events > KEPT_IN_ALL {
            // What has just been said is asked for next, and the largest number is known by its alarm.
            let may_go = |(own, entry): &(&u64, &Entry)| {
                **own != id && **own != self.largest_id && !entry.alarm.is_open()
            };
            let closed = self.alarms.iter().find(may_go);
            let Some(oldest) = closed.map(|(id, _)| *id) else {
                break;
            };
            if let Some(entry) = self.alarms.remove(&oldest) {
                self.events -= entry.events.len();
            }
        }
    }

    /// What is kept, alarm by alarm: of each the last event has how it stands.
    pub fn events(&self) -> impl Iterator<Item = &AlarmEvent> {
        self.alarms.values().flat_map(|entry| &entry.events)
    }

    /// The largest number ever given to an alarm.
    pub fn largest_id(&self) -> u64 {
        self.largest_id
    }

    /// Closes the open alarms of machines that are no longer there: nobody could.
    pub fn forget_machines_but(&mut self, machines: &[&str]) {
        for entry in self.alarms.values_mut() {
            if entry.alarm.is_open() && !machines.contains(&entry.alarm.machine.as_str()) {
                entry.alarm.state = AlarmState::Normal;
            }
        }
    }

    /// The open alarms of a machine.
    pub fn open_of(&self, machine: &str) -> Vec<Alarm> {
        let alarms = self.alarms.values().map(|entry| &entry.alarm);
        let own = alarms.filter(|alarm| alarm.machine == machine && alarm.is_open());
        own.cloned().collect()
    }

    /// Alarms, the newest first.
    pub fn alarms(&self) -> impl Iterator<Item = &Alarm> {
        self.alarms.values().rev().map(|entry| &entry.alarm)
    }

    /// An alarm with its events.
    pub fn alarm(&self, id: u64) -> Option<(&Alarm, &[AlarmEvent])> {
        let entry = self.alarms.get(&id)?;
        Some((&entry.alarm, &entry.events))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::pipeline::{AlarmList, AlarmOptions, Condition};

    /// The events of an alarm that was raised, seen and ended.
    fn events_of_one() -> Vec<AlarmEvent> {
        let mut list = AlarmList::new("gt1", "bank", AlarmOptions::default());
        let condition = Condition {
            key: 0,
            source: "t3".to_owned(),
            statistic: 2.0,
            threshold: 1.0,
            onset_ms: None,
        };
        list.raise(condition, 0);
        list.advance(0, true, || 1);
        list.acknowledge(1, "a", "", 1).unwrap();
        list.end(0, 10);
        list.advance(20_000, true, || 0);
        list.take_events()
    }

    fn remember(history: &mut History, events: &[AlarmEvent], id: u64) {
        for event in events {
            let mut event = event.clone();
            event.alarm.id = id;
            history.remember(event);
        }
    }

    #[test]
    fn memory_stays_bounded() {
        let events = events_of_one();
        let mut history = History::default();
        for id in 1..=12_000 {
            remember(&mut history, &events, id);
        }
        assert_eq!(history.alarms().count(), KEPT_ALARMS);
        assert_eq!(history.alarms().next().unwrap().id, 12_000);
        assert!(history.alarm(2000).is_none());
        assert_eq!(history.largest_id(), 12_000);
        assert_eq!(history.events().count(), KEPT_ALARMS * events.len());
    }

    /// An alarm that keeps coming back has its first event and its last ones, and many such alarms give
    /// way to newer ones once they are closed.
    #[test]
    fn alarms_that_come_back_stay_bounded() {
        let events = events_of_one();
        let mut history = History::default();
        for id in 1..=1000 {
            for _ in 0..KEPT_EVENTS {
                remember(&mut history, &events, id);
            }
        }
        let (_, kept) = history.alarm(1000).unwrap();
        assert_eq!(kept.len(), KEPT_EVENTS);
        assert_eq!(kept[0].event, events[0].event);
        assert_eq!(history.events().count(), KEPT_IN_ALL);
        assert_eq!(history.alarms().count(), KEPT_IN_ALL / KEPT_EVENTS);
        // Open ones are never forgotten.
        let mut history = History::default();
        for id in 1..=1000 {
            for _ in 0..KEPT_EVENTS {
                remember(&mut history, &events[..1], id);
            }
        }
        assert_eq!(history.alarms().count(), 1000);
        // Nor is the one that closes meanwhile, until another one does.
        remember(&mut history, &events, 1001);
        assert!(!history.alarm(1001).unwrap().0.is_open());
        remember(&mut history, &events, 1002);
        assert!(history.alarm(1001).is_none() && history.alarm(1002).is_some());
        assert_eq!(history.largest_id(), 1002);
    }
}
