//! What all parts of the service share.

use std::collections::HashMap;
use std::path::PathBuf;
use std::sync::atomic::{AtomicBool, AtomicI64, Ordering};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::time::Duration;

use gt_log::{DetectorFile, LogHead, sha256_hex};
use serde::Serialize;
use tokio::sync::broadcast;

use crate::clock::{now_ms, now_ns};
use crate::error::ServeError;
use crate::history::History;
use crate::journal::Journal;
use crate::metrics::{self, Metrics};
use crate::outbox::{Outbox, Unwritten};
use crate::pipeline::{Alarm, AlarmEvent, Band, Machine, MachineState, Reading, Sample};
use crate::queue::{Queue, Queued};
use crate::recorder::log_head;

/// Frames and events that a slow listener may fall behind.
const FRAMES: usize = 1024;
const EVENTS: usize = 4096;
/// How often a journal that could not be written is tried again.
const RETRY: Duration = Duration::from_secs(5);

/// Readings of one machine that came together.
#[derive(Debug, Clone, PartialEq)]
pub struct Batch {
    /// Place of the machine.
    pub machine: usize,
    /// When they came, in nanoseconds since 1970.
    pub arrived_ns: i64,
    /// The readings.
    pub readings: Vec<Reading>,
}

/// The values of a machine since the frame before.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Frame {
    /// The machine.
    pub machine: String,
    /// Time of the last sample in milliseconds since 1970.
    pub time_ms: i64,
    /// Least and largest value of each series.
    pub series: Vec<Band>,
}

/// What a machine's log is written from.
#[derive(Debug, Clone)]
pub enum Recorded {
    /// A sample with what was made of it.
    Sample {
        /// The machine.
        machine: usize,
        /// The sample.
        sample: Sample,
        /// Its residuals.
        residuals: Vec<f64>,
        /// Its statistics.
        statistics: Vec<f64>,
    },
    /// Something that happened to an alarm.
    Event {
        /// The machine.
        machine: usize,
        /// What.
        event: Arc<AlarmEvent>,
    },
    /// Another detector from here on.
    Detector {
        /// The machine.
        machine: usize,
        /// What its log begins with now.
        head: Box<LogHead>,
    },
}

impl Queued for Batch {}

impl Queued for Recorded {
    /// Samples may be missing from a log, and it can still be read.
    fn may_be_dropped(&self) -> bool {
        matches!(self, Self::Sample { .. })
    }
}

/// A machine with where it comes from.
pub struct Cell {
    /// Its name.
    pub name: String,
    /// The file of its detector; `None` for the built-in one.
    pub detector_file: Option<PathBuf>,
    /// What its sources call its tags.
    pub aliases: HashMap<String, String>,
    /// Place of each tag.
    pub places: HashMap<String, usize>,
    /// The worker that judges it.
    pub worker: usize,
    machine: Mutex<Machine>,
    detector: Mutex<DetectorText>,
}

/// A detector as its file has it.
struct DetectorText {
    text: Arc<[u8]>,
    sha256: String,
}

impl DetectorText {
    fn new(text: &[u8]) -> Self {
        Self {
            text: text.into(),
            sha256: sha256_hex(text),
        }
    }
}

impl Cell {
    /// A machine of a detector in JSON of this text.
    pub fn new(
        machine: Machine,
        detector_file: Option<PathBuf>,
        aliases: HashMap<String, String>,
        detector_text: &[u8],
        worker: usize,
    ) -> Self {
        let tags = machine.tags().enumerate();
        Self {
            name: machine.name().to_owned(),
            places: tags.map(|(place, tag)| (tag.to_owned(), place)).collect(),
            detector_file,
            aliases,
            worker,
            machine: Mutex::new(machine),
            detector: Mutex::new(DetectorText::new(detector_text)),
        }
    }

    /// The machine, for as short as can be.
    pub fn lock(&self) -> MutexGuard<'_, Machine> {
        self.machine.lock().unwrap_or_else(PoisonError::into_inner)
    }

    fn detector(&self) -> MutexGuard<'_, DetectorText> {
        self.detector.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Its detector in JSON.
    pub fn detector_text(&self) -> Arc<[u8]> {
        Arc::clone(&self.detector().text)
    }

    /// SHA-256 of that.
    pub fn sha256(&self) -> String {
        self.detector().sha256.clone()
    }

    /// The place of a tag, by the name that its source gives it.
    pub fn place(&self, tag: &str) -> Option<usize> {
        let own = self.aliases.get(tag).map_or(tag, String::as_str);
        self.places.get(own).copied()
    }
}

/// All of it.
pub struct Hub {
    /// The machines.
    pub cells: Vec<Cell>,
    /// A queue for each worker.
    pub queues: Vec<Queue<Batch>>,
    /// The counters.
    pub metrics: Metrics,
    /// To the log, where there is one.
    pub recorder: Option<Queue<Recorded>>,
    /// When it started, in milliseconds since 1970.
    pub started_ms: i64,
    /// When each worker was last seen at work, in milliseconds since 1970.
    beats: Vec<AtomicI64>,
    by_name: HashMap<String, usize>,
    history: Mutex<History>,
    outbox: Outbox,
    /// What happens to alarms, for whoever listens.
    events: broadcast::Sender<Arc<AlarmEvent>>,
    /// Values of machines, for pages that are open.
    frames: broadcast::Sender<Arc<Frame>>,
    stopping: AtomicBool,
}

impl Hub {
    /// A hub of machines.
    pub fn new(
        cells: Vec<Cell>,
        queues: Vec<Queue<Batch>>,
        history: History,
        recorder: Option<Queue<Recorded>>,
    ) -> Self {
        let names = cells.iter().enumerate();
        Self {
            by_name: names
                .map(|(place, cell)| (cell.name.clone(), place))
                .collect(),
            beats: queues.iter().map(|_| AtomicI64::new(now_ms())).collect(),
            cells,
            queues,
            metrics: Metrics::default(),
            recorder,
            started_ms: now_ms(),
            history: Mutex::new(history),
            outbox: Outbox::new(),
            events: broadcast::channel(EVENTS).0,
            frames: broadcast::channel(FRAMES).0,
            stopping: AtomicBool::new(false),
        }
    }

    /// The place of a machine.
    pub fn machine(&self, name: &str) -> Option<usize> {
        self.by_name.get(name).copied()
    }

    /// All alarms that have been told, for as short as can be.
    pub fn history(&self) -> MutexGuard<'_, History> {
        self.history.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// What is on its way to the disk and to whoever listens.
    pub fn outbox(&self) -> &Outbox {
        &self.outbox
    }

    /// Takes readings; false when the service stops.
    pub fn offer(&self, batch: Batch) -> bool {
        let readings = batch.readings.len() as u64;
        self.metrics.readings.fetch_add(readings, Ordering::Relaxed);
        let worker = self.cells.get(batch.machine).map(|cell| cell.worker);
        let queue = worker.and_then(|worker| self.queues.get(worker));
        queue.is_some_and(|queue| queue.push(batch))
    }

    /// Puts the detector of a machine's file in the place of the one it has; its SHA-256.
    ///
    /// # Errors
    /// [`ServeError`] when the file does not fit; the machine goes on as it was.
    pub fn reload(&self, place: usize) -> Result<String, ServeError> {
        let cell = &self.cells[place];
        let Some(path) = &cell.detector_file else {
            return Err(ServeError::option(
                format!("machine `{}`", cell.name),
                "a detector from a file",
                "the built-in one",
            ));
        };
        let text = std::fs::read(path).map_err(|cause| ServeError::io("read", path, &cause))?;
        let detector = DetectorFile::read(path)?;
        let mut machine = cell.lock();
        let reloaded = machine.reload(&detector, now_ms());
        reloaded.map_err(|cause| ServeError::Machine {
            machine: cell.name.clone(),
            cause,
        })?;
        *cell.detector() = DetectorText::new(&text);
        // Under the lock, so that it stands between the samples of the one and of the other.
        if let Some(recorder) = &self.recorder {
            recorder.push(Recorded::Detector {
                machine: place,
                head: Box::new(log_head(cell, &machine)),
            });
        }
        Ok(cell.sha256())
    }

    /// Takes what happened to the alarms of a machine, which is locked, to be written and then told;
    /// how many events there are in all with the last of these, 0 where nothing happened.
    pub fn commit(&self, place: usize, machine: &mut Machine) -> u64 {
        let events = machine.take_events().into_iter();
        events.fold(0, |_, event| self.outbox.push(place, event))
    }

    /// Writes events until the outbox is closed and empty.
    pub fn write_events(&self, journal: &mut dyn Journal) {
        loop {
            let unwritten = self.outbox.to_write(RETRY);
            let closed = unwritten == Unwritten::Closed;
            let (events, count) = match unwritten {
                Unwritten::Events(events, count) => (events, count),
                Unwritten::Nothing | Unwritten::Closed => (Vec::new(), self.outbox.count()),
            };
            let kept = self.history().events().count();
            let all = self.outbox.has_gap() || journal.wants_all(kept);
            if events.is_empty() && !all {
                if closed {
                    return;
                }
                continue;
            }
            let (written, count) = if all {
                let (events, count) = self.outbox.everything(&self.history);
                let events: Vec<&AlarmEvent> = events.iter().collect();
                (journal.replace(&events), count)
            } else {
                let own: Vec<&AlarmEvent> = events.iter().map(|event| &**event).collect();
                (journal.append(&own), count)
            };
            if let Err(error) = &written {
                for event in &events {
                    metrics::count(&self.metrics.journal_errors);
                    tracing::error!(%error, alarm = event.alarm.id, "the journal");
                }
            }
            self.outbox.wrote(count, all && written.is_ok());
            if closed {
                return;
            }
        }
    }

    /// Tells of events, each when it is written, until the outbox is closed and empty.
    pub fn tell_events(&self) {
        let mut hangs = false;
        while let Some(untold) = self.outbox.to_tell(&self.history) {
            let event = untold.event;
            if untold.late && event.event.is_kept() {
                metrics::count(&self.metrics.journal_late);
            }
            if untold.late != hangs {
                hangs = untold.late;
                if hangs {
                    tracing::error!("the journal's disk hangs: alarms are told before it has them");
                } else {
                    tracing::info!("the journal's disk answers");
                }
            }
            tracing::info!(
                machine = event.alarm.machine,
                alarm = event.alarm.id,
                event = ?event.event,
                fault = event.alarm.fault,
                text = event.text,
                "alarm"
            );
            // Nobody may listen.
            let _ = self.events.send(Arc::clone(&event));
            self.outbox.told(untold.count);
            if let Some(recorder) = &self.recorder {
                let machine = untold.machine;
                recorder.push(Recorded::Event { machine, event });
            }
        }
    }

    /// Shows values to the pages that are open.
    pub fn show(&self, frame: Frame) {
        let _ = self.frames.send(Arc::new(frame));
    }

    /// Whether a page is open.
    pub fn is_seen(&self) -> bool {
        self.frames.receiver_count() > 0
    }

    /// To hear all that happens to alarms from now on.
    pub fn events(&self) -> broadcast::Receiver<Arc<AlarmEvent>> {
        self.events.subscribe()
    }

    /// To see all values from now on.
    pub fn frames(&self) -> broadcast::Receiver<Arc<Frame>> {
        self.frames.subscribe()
    }

    /// A worker is at work.
    pub fn beat(&self, worker: usize) {
        if let Some(beat) = self.beats.get(worker) {
            beat.store(now_ms(), Ordering::Relaxed);
        }
    }

    /// Whether all workers have been at work within the last so many milliseconds.
    pub fn is_alive(&self, within_ms: i64) -> bool {
        let oldest_ms = now_ms() - within_ms;
        let mut beats = self.beats.iter();
        beats.all(|beat| beat.load(Ordering::Relaxed) >= oldest_ms)
    }

    /// Asks everything to stop.
    pub fn stop(&self) {
        self.stopping.store(true, Ordering::SeqCst);
    }

    /// Whether everything is to stop.
    pub fn is_stopping(&self) -> bool {
        self.stopping.load(Ordering::SeqCst)
    }

    /// The open alarms of all machines.
    pub fn open_alarms(&self) -> Vec<Alarm> {
        let mut open = Vec::new();
        for cell in &self.cells {
            open.extend(cell.lock().alarms().open().cloned());
        }
        open
    }

    /// Whether every machine has had a sample. One that is stale is for the operators, whose page
    /// has to be there then.
    pub fn is_ready(&self) -> bool {
        let now_ns = now_ns();
        let mut states = self.cells.iter().map(|cell| cell.lock().state(now_ns));
        states.all(|state| state != MachineState::NoData)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::outbox::tests::event;

    /// A disk that is full for its first writes.
    #[derive(Default)]
    struct FullDisk {
        writes: usize,
        failed: bool,
        ids: Vec<u64>,
    }

    impl FullDisk {
        fn write(&mut self, events: &[&AlarmEvent], mut ids: Vec<u64>) -> Result<(), ServeError> {
            self.writes += 1;
            self.failed = self.writes <= 2;
            if self.failed {
                return Err(ServeError::option("disk", "room", "none"));
            }
            ids.extend(events.iter().map(|event| event.alarm.id));
            self.ids = ids;
            Ok(())
        }
    }

    impl Journal for FullDisk {
        fn append(&mut self, events: &[&AlarmEvent]) -> Result<(), ServeError> {
            let ids = self.ids.clone();
            self.write(events, ids)
        }

        fn wants_all(&self, _: usize) -> bool {
            self.failed
        }

        fn replace(&mut self, events: &[&AlarmEvent]) -> Result<(), ServeError> {
            self.write(events, Vec::new())
        }
    }

    /// What could not be written is told and counted, and written with the next event that can be.
    #[test]
    fn a_full_disk_loses_no_event_when_there_is_room_again() {
        let hub = Hub::new(Vec::new(), Vec::new(), History::default(), None);
        let mut heard = hub.events();
        let mut journal = FullDisk::default();
        std::thread::scope(|scope| {
            scope.spawn(|| hub.tell_events());
            scope.spawn(|| hub.write_events(&mut journal));
            for id in 1..=3 {
                let count = hub.outbox().push(0, event(id));
                assert!(hub.outbox().is_written(count, Duration::from_secs(60)));
                assert_eq!(heard.blocking_recv().unwrap().alarm.id, id);
            }
            hub.outbox().close();
        });
        assert_eq!(journal.ids, [1, 2, 3]);
        let late = hub.metrics.journal_late.load(Ordering::Relaxed);
        let errors = hub.metrics.journal_errors.load(Ordering::Relaxed);
        assert_eq!((errors, late), (2, 0));
        assert_eq!(hub.history().alarms().count(), 3);
    }
}
