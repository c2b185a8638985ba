//! The file of all that happened to alarms, which outlives a crash.

use std::fs::{File, OpenOptions};
use std::io::Write as _;
use std::path::{Path, PathBuf};

use gt_log::write_atomically;

use crate::error::ServeError;
use crate::history::History;
use crate::pipeline::AlarmEvent;

/// The file is written anew when it has this many lines more than what is kept.
const SPARE_LINES: usize = 20_000;

/// Where events are kept.
pub trait Journal: Send {
    /// Takes events; when this returns, they are on the disk.
    ///
    /// # Errors
    /// [`ServeError`] when they cannot be written.
    fn append(&mut self, events: &[&AlarmEvent]) -> Result<(), ServeError>;

    /// Whether it has to be written anew: a write failed, or it holds much more than the `kept` events
    /// that are still of use.
    fn wants_all(&self, kept: usize) -> bool;

    /// Puts these events in the place of what it has.
    ///
    /// # Errors
    /// [`ServeError`] when they cannot be written; what it has stays.
    fn replace(&mut self, events: &[&AlarmEvent]) -> Result<(), ServeError>;
}

/// No file: the history in memory is all there is.
pub struct NoJournal;

impl Journal for NoJournal {
    fn append(&mut self, _: &[&AlarmEvent]) -> Result<(), ServeError> {
        Ok(())
    }

    fn wants_all(&self, _: usize) -> bool {
        false
    }

    fn replace(&mut self, _: &[&AlarmEvent]) -> Result<(), ServeError> {
        Ok(())
    }
}

/// A file with a line an event.
#[derive(Debug)]
pub struct JournalFile {
    path: PathBuf,
    /// `None` after a write that failed, which may have left half a line.
    file: Option<File>,
    lines: usize,
}

impl JournalFile {
    /// The journal of a file, which need not be there, and what it holds. A last line that was not
    /// written to its end, as when the machine lost its power, is dropped.
    ///
    /// # Errors
    /// [`ServeError`] when the file cannot be read or written, or a line that is whole is not an
    /// event: then something else wrote to it, and nothing is touched.
    pub fn open(path: &Path) -> Result<(Self, History), ServeError> {
        let mut history = History::default();
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
                    history.remember(event);
                }
            }
            Err(cause) if cause.kind() == std::io::ErrorKind::NotFound => {}
            Err(cause) => return Err(ServeError::io("read", path, &cause)),
        }
        let mut journal = Self {
            path: path.to_owned(),
            file: None,
            lines: 0,
        };
        // Without the torn line, and without what is no longer kept.
        journal.replace(&history.events().collect::<Vec<_>>())?;
        Ok((journal, history))
    }

    /// A line for each event that is kept, and how many lines.
    fn text(&self, events: &[&AlarmEvent]) -> Result<(Vec<u8>, usize), ServeError> {
        let (mut text, mut lines) = (Vec::new(), 0);
        for event in events {
            if !event.event.is_kept() {
                continue;
            }
            serde_json::to_writer(&mut text, event).map_err(|cause| ServeError::Journal {
                path: self.path.clone(),
                line: self.lines + lines + 1,
                cause: cause.to_string(),
            })?;
            text.push(b'\n');
            lines += 1;
        }
        Ok((text, lines))
    }
}

impl Journal for JournalFile {
    fn append(&mut self, events: &[&AlarmEvent]) -> Result<(), ServeError> {
        let (text, lines) = self.text(events)?;
        if lines == 0 {
            return Ok(());
        }
        let mut file = self.file.take().ok_or_else(|| ServeError::Io {
            what: "write",
            path: self.path.clone(),
            cause: "a write before failed".to_owned(),
        })?;
        let written = file.write_all(&text).and_then(|()| file.sync_data());
        written.map_err(|cause| ServeError::io("write", &self.path, &cause))?;
        self.file = Some(file);
        self.lines += lines;
        Ok(())
    }

    fn wants_all(&self, kept: usize) -> bool {
        self.file.is_none() || self.lines > kept + SPARE_LINES
    }

    fn replace(&mut self, events: &[&AlarmEvent]) -> Result<(), ServeError> {
        let (text, lines) = self.text(events)?;
        write_atomically(&self.path, &text)?;
        let opened = OpenOptions::new().append(true).open(&self.path);
        self.file = Some(opened.map_err(|cause| ServeError::io("open", &self.path, &cause))?);
        self.lines = lines;
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use gtfdi::fdi::{NamedDiagnosis, NamedHypothesis};

    use crate::pipeline::{AlarmList, AlarmListState, AlarmOptions, Condition};

    fn append(journal: &mut JournalFile, event: &AlarmEvent) {
        journal.append(&[event]).unwrap();
    }

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
        let (mut journal, _) = JournalFile::open(&path).unwrap();
        let events = events(3);
        for event in &events[..events.len() - 2] {
            append(&mut journal, event);
        }
        drop(journal);
        let (_, again) = JournalFile::open(&path).unwrap();
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
        let (mut journal, _) = JournalFile::open(&path).unwrap();
        for event in &events {
            append(&mut journal, event);
        }
        let whole = std::fs::read(&path).unwrap();
        let ends: Vec<usize> = (0..whole.len()).filter(|at| whole[*at] == b'\n').collect();
        for cut in (ends[4] + 1..whole.len()).step_by(37) {
            std::fs::write(&path, &whole[..cut]).unwrap();
            let (mut journal, history) = JournalFile::open(&path).unwrap();
            let lines = ends.iter().filter(|end| **end < cut).count();
            let count: usize = [1, 2]
                .iter()
                .filter_map(|id| Some(history.alarm(*id)?.1.len()))
                .sum();
            assert_eq!(count, lines, "cut at {cut}");
            append(&mut journal, &events[lines]);
            drop(journal);
            let text = std::fs::read_to_string(&path).unwrap();
            assert_eq!(text.lines().count(), lines + 1);
            JournalFile::open(&path).unwrap();
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
        let (mut journal, _) = JournalFile::open(&path).unwrap();
        for event in list.take_events() {
            append(&mut journal, &event);
        }
        drop(journal);
        let open = JournalFile::open(&path).unwrap().1.open_of("gt1");
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
        let error = JournalFile::open(&path).unwrap_err().to_string();
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
}
