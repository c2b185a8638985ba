//! The history of all alarms: in a file that outlives a crash, and in memory to be asked.

use std::collections::BTreeMap;
use std::fs::{File, OpenOptions};
use std::io::Write as _;
use std::path::{Path, PathBuf};

use gt_log::write_atomically;

use crate::error::ServeError;
use crate::pipeline::{Alarm, AlarmAction, AlarmEvent, AlarmState};

/// Closed alarms that are kept.
const KEPT_ALARMS: usize = 10_000;
/// Events of one alarm that are kept: all of the usual alarm's.
const KEPT_EVENTS: usize = 200;
/// The file is written anew when it has this many lines more than what is kept.
const SPARE_LINES: usize = 20_000;

/// All alarms with their events.
#[derive(Debug)]
pub struct Journal {
    path: Option<PathBuf>,
    file: Option<File>,
    lines: usize,
    alarms: BTreeMap<u64, Entry>,
    /// The largest number ever given.
    largest_id: u64,
}

#[derive(Debug)]
struct Entry {
    alarm: Alarm,
    events: Vec<AlarmEvent>,
}

impl Journal {
    /// A journal in memory alone.
    pub fn in_memory() -> Self {
        Self {
            path: None,
            file: None,
            lines: 0,
            alarms: BTreeMap::new(),
            largest_id: 0,
        }
    }

    /// The journal of a file, which need not be there. A last line that was not written to its end,
    /// as when the machine lost its power, is dropped: what it says was never told to anybody.
    ///
    /// # Errors
    /// [`ServeError`] when the file cannot be read or written, or a line that is whole is not an
    /// event: then something else wrote to it, and nothing is touched.
    pub fn open(path: &Path) -> Result<Self, ServeError> {
        let mut journal = Self::in_memory();
        journal.path = Some(path.to_owned());
        match std::fs::read_to_string(path) {
            Ok(text) => {
                for (number, line) in text.split_inclusive('\n').enumerate() {
                    let Some(line) = line.strip_suffix('\n') else {
                        break;
                    };
                    let event: AlarmEvent =
                        serde_json::from_str(line).map_err(|cause| ServeError::Journal {
                            path: path.to_owned(),
                            line: number + 1,
                            cause: cause.to_string(),
                        })?;
                    journal.remember(event);
                }
            }
            Err(cause) if cause.kind() == std::io::ErrorKind::NotFound => {}
            Err(cause) => return Err(ServeError::io("read", path, &cause)),
        }
        // Without the torn line, and without what is no longer kept.
        journal.rewrite()?;
        Ok(journal)
    }

    /// Takes an event; when this returns, it is on the disk.
    ///
    /// # Errors
    /// [`ServeError`] when it cannot be written; it is remembered all the same.
    pub fn append(&mut self, event: &AlarmEvent) -> Result<(), ServeError> {
        self.remember(event.clone());
        // What is known better every few seconds is not worth a write.
        if event.event == AlarmAction::Changed {
            return Ok(());
        }
        let Some(path) = self.path.clone() else {
            return Ok(());
        };
        if self.file.is_none() {
            // A write failed before: begin a sound file.
            return self.rewrite();
        }
        let mut line = serde_json::to_vec(event).map_err(|cause| ServeError::Journal {
            path: path.clone(),
            line: self.lines + 1,
            cause: cause.to_string(),
        })?;
        line.push(b'\n');
        let written = self.file.as_mut().map_or(Ok(()), |file| {
            file.write_all(&line).and_then(|()| file.sync_data())
        });
        if let Err(cause) = written {
            self.file = None;
            return Err(ServeError::io("write", &path, &cause));
        }
        self.lines += 1;
        let kept: usize = self.alarms.values().map(|entry| entry.events.len()).sum();
        if self.lines > kept + SPARE_LINES {
            self.rewrite()?;
        }
        Ok(())
    }

    fn remember(&mut self, event: AlarmEvent) {
        let id = event.alarm.id;
        self.largest_id = self.largest_id.max(id);
        let entry = self.alarms.entry(id).or_insert_with(|| Entry {
            alarm: event.alarm.clone(),
            events: Vec::new(),
        });
        entry.alarm = event.alarm.clone();
        if event.event != AlarmAction::Changed {
            if entry.events.len() >= KEPT_EVENTS {
                // The first says how it began.
                entry.events.remove(1);
            }
            entry.events.push(event);
        }
        while self.alarms.len() > KEPT_ALARMS {
            let closed = self.alarms.iter().find(|(_, entry)| !entry.alarm.is_open());
            let Some(oldest) = closed.map(|(id, _)| *id) else {
                break;
            };
            self.alarms.remove(&oldest);
        }
    }

    /// Writes what is kept to a file of its own and puts it in the place of the old one.
    fn rewrite(&mut self) -> Result<(), ServeError> {
        let Some(path) = &self.path else {
            return Ok(());
        };
        // Alarm by alarm: of each the last line counts.
        let entries = self.alarms.values();
        let events: Vec<&AlarmEvent> = entries.flat_map(|entry| &entry.events).collect();
        let mut text = Vec::new();
        for event in &events {
            serde_json::to_writer(&mut text, event).map_err(|cause| ServeError::Journal {
                path: path.clone(),
                line: 0,
                cause: cause.to_string(),
            })?;
            text.push(b'\n');
        }
        self.lines = events.len();
        write_atomically(path, &text)?;
        let opened = OpenOptions::new().append(true).open(path);
        self.file = Some(opened.map_err(|cause| ServeError::io("open", path, &cause))?);
        Ok(())
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
    use gtfdi::fdi::{NamedDiagnosis, NamedHypothesis};

    use crate::pipeline::{AlarmList, AlarmListState, AlarmOptions, Condition};

    /// Alarms of one statistic that come, are seen and go, with their events.
    fn events(alarms: i64) -> Vec<AlarmEvent> {
        let mut list = AlarmList::new("gt1", "bank", AlarmOptions::default());
        let mut id = 0;
        for alarm in 0..alarms {
            let at_ms = 100_000 * alarm;
            let condition = Condition {
                key: 0,
                source: "t3".to_owned(),
                statistic: 2.0,
                threshold: 1.0,
                onset_ms: None,
            };
            list.raise(condition, at_ms);
            list.advance(at_ms, true, || {
                id += 1;
                id
            });
            list.acknowledge(id, "a", "", at_ms + 1).unwrap();
            list.end(0, at_ms + 10);
            list.advance(at_ms + 20_000, true, || 0);
        }
        list.take_events()
    }

    #[test]
    fn what_was_written_is_there_again() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("alarms.jsonl");
        let mut journal = Journal::open(&path).unwrap();
        let events = events(3);
        for event in &events[..events.len() - 2] {
            journal.append(event).unwrap();
        }
        drop(journal);
        let again = Journal::open(&path).unwrap();
        assert_eq!(again.largest_id(), 3);
        let open: Vec<u64> = again.open_of("gt1").iter().map(|alarm| alarm.id).collect();
        assert_eq!(open, [3]);
        assert_eq!(again.alarm(2).unwrap().1, &events[4..8]);
        assert!(again.open_of("gt2").is_empty());
    }

    /// Wherever the last write was cut, all events before it are there, and more can follow.
    #[test]
    fn a_torn_line_is_dropped_and_nothing_else() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("alarms.jsonl");
        let events = events(2);
        let mut journal = Journal::open(&path).unwrap();
        for event in &events {
            journal.append(event).unwrap();
        }
        let whole = std::fs::read(&path).unwrap();
        let ends: Vec<usize> = (0..whole.len()).filter(|at| whole[*at] == b'\n').collect();
        for cut in (ends[4] + 1..whole.len()).step_by(37) {
            std::fs::write(&path, &whole[..cut]).unwrap();
            let mut journal = Journal::open(&path).unwrap();
            let lines = ends.iter().filter(|end| **end < cut).count();
            let count: usize = [1, 2]
                .iter()
                .filter_map(|id| Some(journal.alarm(*id)?.1.len()))
                .sum();
            assert_eq!(count, lines, "cut at {cut}");
            journal.append(&events[lines]).unwrap();
            drop(journal);
            let text = std::fs::read_to_string(&path).unwrap();
            assert_eq!(text.lines().count(), lines + 1);
            Journal::open(&path).unwrap();
        }
    }

    /// A statistic beyond all numbers, and a fault of which nothing is known: JSON has neither, and
    /// a journal that holds them is read again.
    #[test]
    fn numbers_that_json_has_not_do_no_harm() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("alarms.jsonl");
        let mut list = AlarmList::new("gt1", "isolator", AlarmOptions::default());
        let condition = Condition {
            key: 0,
            source: "t3".to_owned(),
            statistic: f64::INFINITY,
            threshold: 1.0,
            onset_ms: None,
        };
        list.raise(condition, 0);
        list.advance(0, true, || 1);
        let unknown = |fault: &str, magnitude: f64| NamedHypothesis {
            fault: fault.to_owned(),
            unit: "%".to_owned(),
            probability: 0.5,
            magnitude,
            magnitude_interval: [magnitude; 2],
            onset_s: 1.0,
            onset_interval_s: [0.0, 2.0],
        };
        let diagnosis = NamedDiagnosis {
            diagnosed_s: 2.0,
            finding: "named",
            fault: Some("a".to_owned()),
            unit: None,
            probability: Some(f64::NAN),
            onset_s: Some(1.0),
            magnitude: Some(f64::NAN),
            hypotheses: vec![unknown("a", f64::NAN), unknown("b", 1.0)],
            none_of_these: f64::NAN,
            pair: None,
        };
        list.learn(0, &diagnosis, 2000, |_| 0);
        let mut journal = Journal::open(&path).unwrap();
        for event in list.take_events() {
            journal.append(&event).unwrap();
        }
        drop(journal);
        let open = Journal::open(&path).unwrap().open_of("gt1");
        assert_eq!(open[0].statistic.to_bits(), f64::MAX.to_bits());
        assert_eq!(open[0].fault.as_deref(), Some("a"));
        assert_eq!(open[0].magnitude, None);
        let known: Vec<&str> = open[0]
            .hypotheses
            .iter()
            .map(|own| own.fault.as_str())
            .collect();
        assert_eq!(known, ["b"]);
        let text = serde_json::to_string(&list.state()).unwrap();
        let state: AlarmListState = serde_json::from_str(&text).unwrap();
        assert_eq!(state, list.state());
    }

    #[test]
    fn what_something_else_wrote_is_not_touched() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("alarms.jsonl");
        std::fs::write(&path, "shopping: bread\n").unwrap();
        let error = Journal::open(&path).unwrap_err().to_string();
        let start = format!(
            "{}: line 1: expected an event of an alarm: ",
            path.display()
        );
        assert!(error.starts_with(&start), "{error}");
        assert!(
            error.ends_with("; move the file away to begin another"),
            "{error}"
        );
        assert_eq!(std::fs::read_to_string(&path).unwrap(), "shopping: bread\n");
    }

    #[test]
    fn memory_and_file_stay_bounded() {
        let mut journal = Journal::in_memory();
        let events = events(1);
        for id in 1..=12_000 {
            for event in &events {
                let mut event = event.clone();
                event.alarm.id = id;
                journal.append(&event).unwrap();
            }
        }
        assert_eq!(journal.alarms().count(), KEPT_ALARMS);
        assert_eq!(journal.alarms().next().unwrap().id, 12_000);
        assert!(journal.alarm(2000).is_none());
        assert_eq!(journal.largest_id(), 12_000);
    }
}
