//! What happens to alarms, on its way to the disk and from there to whoever listens.
//!
//! What judges only puts events in. One thread writes them, as many at a time as there are, and
//! another tells of what is written. So a slow disk holds up no verdict; and one that does not answer
//! for [`PATIENCE`] keeps no alarm from being told: it is told first then, and counted.

use std::collections::VecDeque;
use std::sync::{Arc, Condvar, Mutex, MutexGuard, PoisonError};
use std::time::{Duration, Instant};

use tokio::sync::watch;

use crate::history::History;
use crate::pipeline::AlarmEvent;

/// How long an event waits for the disk before it is told all the same.
pub const PATIENCE: Duration = Duration::from_secs(2);
/// Events that are told but not written, of which only the history knows beyond this many.
const MOST: usize = 4096;

/// Events in the order in which they came. They are counted from 0.
#[derive(Debug)]
pub struct Outbox {
    inner: Mutex<Inner>,
    changed: Condvar,
    /// How many have been told.
    told: watch::Sender<u64>,
}

#[derive(Debug, Default)]
struct Inner {
    /// Those that are not both written and told.
    waiting: VecDeque<Waiting>,
    /// The number of the first of these.
    first: u64,
    /// All below have been written, or could not be.
    written: u64,
    /// All below have been told.
    told: u64,
    /// Some were let go of that were not written: they are in the history alone.
    gap: bool,
    closed: bool,
}

#[derive(Debug, Clone)]
struct Waiting {
    machine: usize,
    event: Arc<AlarmEvent>,
    since: Instant,
}

/// What there is to write.
#[derive(Debug, PartialEq)]
pub enum Unwritten {
    /// Events, and how many there are in all with the last of them.
    Events(Vec<Arc<AlarmEvent>>, u64),
    /// Nothing within the time.
    Nothing,
    /// Nothing, and nothing will come.
    Closed,
}

/// An event to tell.
#[derive(Debug)]
pub struct Untold {
    /// Its machine.
    pub machine: usize,
    /// The event.
    pub event: Arc<AlarmEvent>,
    /// How many have been told with it.
    pub count: u64,
    /// Whether it is told before it is written.
    pub late: bool,
}

impl Outbox {
    /// An empty one.
    pub fn new() -> Self {
        Self {
            inner: Mutex::default(),
            changed: Condvar::new(),
            told: watch::channel(0).0,
        }
    }

    fn lock(&self) -> MutexGuard<'_, Inner> {
        // Nothing in here is left half done by a panic.
        self.inner.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Puts an event at the end; how many there are with it.
    pub fn push(&self, machine: usize, event: AlarmEvent) -> u64 {
        let mut inner = self.lock();
        inner.waiting.push_back(Waiting {
            machine,
            event: Arc::new(event),
            since: Instant::now(),
        });
        while inner.waiting.len() > MOST && inner.first < inner.told {
            inner.waiting.pop_front();
            inner.first += 1;
            inner.gap = true;
        }
        let count = inner.end();
        drop(inner);
        self.changed.notify_all();
        count
    }

    /// How many have come.
    pub fn count(&self) -> u64 {
        self.lock().end()
    }

    /// How many wait to be written.
    pub fn unwritten(&self) -> u64 {
        let inner = self.lock();
        inner.end() - inner.written
    }

    /// Nothing more will come.
    pub fn close(&self) {
        self.lock().closed = true;
        self.changed.notify_all();
    }

    /// All that is to be written, waiting for at most `timeout`.
    pub fn to_write(&self, timeout: Duration) -> Unwritten {
        let inner = self.wait(timeout, |inner| inner.closed || inner.written < inner.end());
        let events = inner.waiting.iter().skip(inner.place(inner.written));
        let events: Vec<_> = events.map(|own| Arc::clone(&own.event)).collect();
        match (events.is_empty(), inner.closed) {
            (false, _) => Unwritten::Events(events, inner.end()),
            (true, true) => Unwritten::Closed,
            (true, false) => Unwritten::Nothing,
        }
    }

    /// Whether events were let go of that are in the history alone.
    pub fn has_gap(&self) -> bool {
        self.lock().gap
    }

    /// All events that there are, of the history and not told yet, and how many came in all.
    pub fn everything(&self, history: &Mutex<History>) -> (Vec<AlarmEvent>, u64) {
        let inner = self.lock();
        let history = history.lock().unwrap_or_else(PoisonError::into_inner);
        let untold = inner.waiting.iter().skip(inner.place(inner.told));
        let untold = untold.map(|own| &*own.event);
        let all = history.events().chain(untold).cloned().collect();
        (all, inner.end())
    }

    /// The first `count` are written, or cannot be; `all` says that those were written, too, that
    /// had been let go of.
    pub fn wrote(&self, count: u64, all: bool) {
        let mut inner = self.lock();
        inner.written = inner.written.max(count);
        inner.gap &= !all;
        inner.trim();
        drop(inner);
        self.changed.notify_all();
    }

    /// Whether the first `count` are written within `timeout`.
    pub fn is_written(&self, count: u64, timeout: Duration) -> bool {
        self.wait(timeout, |inner| inner.written >= count).written >= count
    }

    /// Waits for the next event to tell, which is in the history then; `None` when nothing will come.
    pub fn to_tell(&self, history: &Mutex<History>) -> Option<Untold> {
        let mut inner = self.lock();
        loop {
            let place = inner.place(inner.told);
            let Some(own) = inner.waiting.get(place).cloned() else {
                if inner.closed {
                    return None;
                }
                let woken = self.changed.wait(inner);
                inner = woken.unwrap_or_else(PoisonError::into_inner);
                continue;
            };
            let left = PATIENCE.saturating_sub(own.since.elapsed());
            let late = inner.told >= inner.written;
            if late && !left.is_zero() {
                let woken = self.changed.wait_timeout(inner, left);
                inner = woken.unwrap_or_else(PoisonError::into_inner).0;
                continue;
            }
            let mut history = history.lock().unwrap_or_else(PoisonError::into_inner);
            history.remember((*own.event).clone());
            drop(history);
            inner.told += 1;
            inner.trim();
            return Some(Untold {
                machine: own.machine,
                event: own.event,
                count: inner.told,
                late,
            });
        }
    }

    /// The first `count` have been told.
    pub fn told(&self, count: u64) {
        self.told.send_replace(count);
    }

    /// Waits until the first `count` have been told.
    pub async fn until_told(&self, count: u64) {
        let mut told = self.told.subscribe();
        // The sender lives as long as this does.
        let _ = told.wait_for(|told| *told >= count).await;
    }

    fn wait(&self, timeout: Duration, until: impl Fn(&Inner) -> bool) -> MutexGuard<'_, Inner> {
        let waited = self
            .changed
            .wait_timeout_while(self.lock(), timeout, |inner| !until(inner));
        waited.unwrap_or_else(PoisonError::into_inner).0
    }
}

impl Inner {
    /// How many have come.
    fn end(&self) -> u64 {
        self.first + self.waiting.len() as u64
    }

    /// The place among those that wait of the event of this number.
    fn place(&self, number: u64) -> usize {
        usize::try_from(number.saturating_sub(self.first)).unwrap_or(usize::MAX)
    }

    /// Lets go of what is written and told.
    fn trim(&mut self) {
        let done = self.written.min(self.told);
        while self.first < done && self.waiting.pop_front().is_some() {
            self.first += 1;
        }
    }
}

#[cfg(test)]
pub(crate) mod tests {
    use super::*;
    use crate::pipeline::{AlarmList, AlarmOptions, Condition};

    /// An alarm that comes up.
    pub(crate) fn event(id: u64) -> AlarmEvent {
        let mut list = AlarmList::new("gt1", "bank", AlarmOptions::default());
        let condition = Condition {
            key: 0,
            source: "t3".to_owned(),
            statistic: 2.0,
            threshold: 1.0,
            onset_ms: None,
        };
        list.raise(condition, 0);
        list.advance(0, true, || id);
        list.take_events().remove(0)
    }

    fn ids(events: &[Arc<AlarmEvent>]) -> Vec<u64> {
        events.iter().map(|event| event.alarm.id).collect()
    }

    const NOW: Duration = Duration::ZERO;

    #[test]
    fn an_event_is_told_once_it_is_written() {
        let (outbox, history) = (Outbox::new(), Mutex::new(History::default()));
        assert_eq!(outbox.to_write(NOW), Unwritten::Nothing);
        assert_eq!([outbox.push(0, event(7)), outbox.push(1, event(8))], [1, 2]);
        let Unwritten::Events(events, count) = outbox.to_write(NOW) else {
            panic!("expected events to write")
        };
        assert_eq!((ids(&events), count), (vec![7, 8], 2));
        assert!(history.lock().unwrap().alarm(7).is_none(), "not told yet");
        outbox.wrote(1, false);
        assert!(outbox.is_written(1, NOW) && !outbox.is_written(2, NOW));
        let untold = outbox.to_tell(&history).unwrap();
        assert_eq!((untold.event.alarm.id, untold.count), (7, 1));
        assert!(!untold.late);
        assert!(history.lock().unwrap().alarm(7).is_some());
        outbox.wrote(2, false);
        outbox.close();
        let untold = outbox.to_tell(&history).unwrap();
        assert_eq!((untold.machine, untold.late), (1, false));
        assert!(outbox.to_tell(&history).is_none());
        assert_eq!(outbox.to_write(NOW), Unwritten::Closed);
    }

    /// The disk does not answer: the event is told after [`PATIENCE`], not before, and is still there
    /// to be written.
    #[test]
    fn a_disk_that_hangs_keeps_no_event() {
        let (outbox, history) = (Outbox::new(), Mutex::new(History::default()));
        let begun = Instant::now();
        outbox.push(0, event(7));
        let untold = outbox.to_tell(&history).unwrap();
        assert!(untold.late && begun.elapsed() >= PATIENCE);
        assert_eq!(outbox.unwritten(), 1);
        assert!(matches!(outbox.to_write(NOW), Unwritten::Events(events, 1) if events.len() == 1));
        outbox.wrote(1, false);
        assert_eq!((outbox.unwritten(), outbox.count()), (0, 1));
        assert!(outbox.lock().waiting.is_empty());
    }

    /// What is told and cannot be written does not fill the memory; all of it is written at once when
    /// the disk is back.
    #[test]
    fn what_is_let_go_of_is_in_the_history() {
        let (outbox, history) = (Outbox::new(), Mutex::new(History::default()));
        let count = MOST as u64 + 10;
        for id in 1..=count {
            outbox.push(0, event(id));
            // As if it had waited for long.
            let mut inner = outbox.lock();
            let last = inner.waiting.back_mut().unwrap();
            last.since = begin_of_time(last.since);
            drop(inner);
            assert!(outbox.to_tell(&history).unwrap().late);
        }
        assert_eq!(outbox.lock().waiting.len(), MOST);
        assert!(outbox.has_gap());
        let (all, end) = outbox.everything(&history);
        assert_eq!((all.len() as u64, end), (count, count));
        outbox.wrote(end, true);
        assert!(!outbox.has_gap());
        assert_eq!(outbox.to_write(NOW), Unwritten::Nothing);
    }

    fn begin_of_time(now: Instant) -> Instant {
        now.checked_sub(PATIENCE).unwrap()
    }
}
