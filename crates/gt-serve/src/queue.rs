//! A queue between what brings readings and what judges them, of bounded length.

use std::collections::VecDeque;
use std::sync::{Condvar, Mutex, MutexGuard, PoisonError};
use std::time::{Duration, Instant};

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// What a full queue does.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum QueuePolicy {
    /// Whoever brings more waits; what it reads from waits too.
    #[default]
    Block,
    /// The oldest is dropped and counted.
    DropOldest,
}

/// What a queue holds.
pub trait Queued {
    /// Whether what comes after it can do without it.
    fn may_be_dropped(&self) -> bool {
        true
    }
}

/// A queue that several threads may fill and one empties.
#[derive(Debug)]
pub struct Queue<T> {
    inner: Mutex<Inner<T>>,
    filled: Condvar,
    emptied: Condvar,
    capacity: usize,
    policy: QueuePolicy,
}

#[derive(Debug)]
struct Inner<T> {
    items: VecDeque<T>,
    dropped: u64,
    longest: usize,
    closed: bool,
}

/// What a [`Queue::pop`] found.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Popped<T> {
    /// The oldest.
    Item(T),
    /// Nothing within the time.
    Nothing,
    /// Nothing, and nothing will come.
    Closed,
}

impl<T: Queued> Queue<T> {
    /// A queue of at most `capacity`, at least 1.
    pub fn new(capacity: usize, policy: QueuePolicy) -> Self {
        Self {
            inner: Mutex::new(Inner {
                items: VecDeque::new(),
                dropped: 0,
                longest: 0,
                closed: false,
            }),
            filled: Condvar::new(),
            emptied: Condvar::new(),
            capacity: capacity.max(1),
            policy,
        }
    }

    fn lock(&self) -> MutexGuard<'_, Inner<T>> {
        // Nothing in here is left half done by a panic.
        self.inner.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Puts one at the end; false when the queue is closed. Where the oldest is dropped, one that may
    /// not be dropped stays, even if the queue grows longer than it should.
    pub fn push(&self, item: T) -> bool {
        let mut inner = self.lock();
        while inner.items.len() >= self.capacity && !inner.closed {
            match self.policy {
                QueuePolicy::DropOldest => {
                    let oldest = inner.items.iter().position(Queued::may_be_dropped);
                    let Some(oldest) = oldest else {
                        break;
                    };
                    inner.items.remove(oldest);
                    inner.dropped += 1;
                }
                QueuePolicy::Block => {
                    let woken = self.emptied.wait(inner);
                    inner = woken.unwrap_or_else(PoisonError::into_inner);
                }
            }
        }
        if inner.closed {
            return false;
        }
        inner.items.push_back(item);
        inner.longest = inner.longest.max(inner.items.len());
        drop(inner);
        self.filled.notify_one();
        true
    }

    /// Takes the oldest, waiting for at most `timeout`.
    pub fn pop(&self, timeout: Duration) -> Popped<T> {
        let until = Instant::now() + timeout;
        let mut inner = self.lock();
        loop {
            if let Some(item) = inner.items.pop_front() {
                drop(inner);
                self.emptied.notify_one();
                return Popped::Item(item);
            }
            if inner.closed {
                return Popped::Closed;
            }
            let left = until.saturating_duration_since(Instant::now());
            if left.is_zero() {
                return Popped::Nothing;
            }
            let woken = self.filled.wait_timeout(inner, left);
            inner = woken.unwrap_or_else(PoisonError::into_inner).0;
        }
    }

    /// Nothing more comes in; what is there can still be taken.
    pub fn close(&self) {
        self.lock().closed = true;
        self.filled.notify_all();
        self.emptied.notify_all();
    }

    /// How many wait now, how many waited at most, and how many were dropped.
    pub fn counts(&self) -> (usize, usize, u64) {
        let inner = self.lock();
        (inner.items.len(), inner.longest, inner.dropped)
    }
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;
    use std::thread;

    use super::*;

    const SHORT: Duration = Duration::from_millis(20);

    /// Negative numbers may not be dropped.
    impl Queued for i32 {
        fn may_be_dropped(&self) -> bool {
            *self >= 0
        }
    }

    #[test]
    fn a_full_queue_drops_its_oldest_where_that_is_asked() {
        let queue = Queue::new(3, QueuePolicy::DropOldest);
        for k in 0..10 {
            assert!(queue.push(k));
        }
        assert_eq!(queue.counts(), (3, 3, 7));
        for k in 7..10 {
            assert_eq!(queue.pop(SHORT), Popped::Item(k));
        }
        assert_eq!(queue.pop(SHORT), Popped::Nothing);
        queue.close();
        assert_eq!(queue.pop(SHORT), Popped::Closed);
        assert!(!queue.push(1));
    }

    #[test]
    fn what_may_not_be_dropped_stays_in_its_place() {
        let queue = Queue::new(3, QueuePolicy::DropOldest);
        for k in [-1, 0, -2, 1, 2, -3, -4, -5] {
            assert!(queue.push(k));
        }
        assert_eq!(queue.counts(), (5, 5, 3));
        for k in [-1, -2, -3, -4, -5] {
            assert_eq!(queue.pop(SHORT), Popped::Item(k));
        }
    }

    #[test]
    fn a_blocking_queue_loses_nothing() {
        let queue = Arc::new(Queue::new(2, QueuePolicy::Block));
        let filler = {
            let queue = Arc::clone(&queue);
            thread::spawn(move || (0..1000).for_each(|k| assert!(queue.push(k))))
        };
        for k in 0..1000 {
            assert_eq!(queue.pop(Duration::from_secs(10)), Popped::Item(k));
        }
        filler.join().unwrap();
        let (now, longest, dropped) = queue.counts();
        assert_eq!((now, dropped), (0, 0));
        assert!(longest <= 2);
    }

    /// Whoever waits for room is let go when the queue closes.
    #[test]
    fn closing_wakes_who_waits() {
        let queue = Arc::new(Queue::new(1, QueuePolicy::Block));
        queue.push(1);
        let filler = {
            let queue = Arc::clone(&queue);
            thread::spawn(move || queue.push(2))
        };
        thread::sleep(SHORT);
        queue.close();
        assert!(!filler.join().unwrap());
        assert_eq!(queue.pop(SHORT), Popped::Item(1));
        assert_eq!(queue.pop(SHORT), Popped::Closed);
    }
}
