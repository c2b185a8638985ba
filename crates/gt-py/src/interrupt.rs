//! Long work that Ctrl-C ends.
//!
//! Python handles signals between two instructions of its own, so a call that computes for minutes
//! would answer to Ctrl-C only at its end. The work therefore runs on a thread of its own while the
//! calling thread looks for signals.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{RecvTimeoutError, sync_channel};
use std::thread;
use std::time::Duration;

use gtfdi::core::Stop;
use pyo3::exceptions::PyKeyboardInterrupt;
use pyo3::prelude::*;

use crate::error::Failure;

/// Time between two looks for signals: short beside the second that a user waits, long beside what
/// a look costs.
const LOOK_EVERY: Duration = Duration::from_millis(50);

/// Stack of the working thread: that of a main thread.
const STACK_BYTES: usize = 8 << 20;

/// Whether the caller has gone; work that can end early looks at it.
#[derive(Debug, Clone, Default)]
pub struct Abandoned(Arc<AtomicBool>);

impl Abandoned {
    /// Whether nobody waits for the result any more.
    pub fn is_set(&self) -> bool {
        self.0.load(Ordering::Relaxed)
    }
}

impl Stop for Abandoned {
    fn is_stopped(&self) -> bool {
        self.is_set()
    }
}

/// Does `work` without the lock on the interpreter and gives what it gives. A signal whose handler
/// raises ends the wait with that exception, which says what becomes of the work: it ends at the
/// next place where it looks at [`Abandoned`], or else at its own end, in the background.
///
/// Where the exception is raised is up to Python: signals reach its main thread only.
pub fn interruptible<T, F>(py: Python<'_>, work: F) -> Result<T, Failure>
where
    T: Send + 'static,
    F: FnOnce(&Abandoned) -> Result<T, Failure> + Send + 'static,
{
    let abandoned = Abandoned::default();
    let watched = abandoned.clone();
    let (sender, mut receiver) = sync_channel(1);
    thread::Builder::new()
        .name("gtfdi".to_owned())
        .stack_size(STACK_BYTES)
        .spawn(move || {
            // Nobody listens any more where the caller was interrupted.
            let _ = sender.send(work(&watched));
        })
        .map_err(|cause| Failure::Thread { cause })?;
    loop {
        let (back, outcome) = py.detach(move || {
            let outcome = receiver.recv_timeout(LOOK_EVERY);
            (receiver, outcome)
        });
        receiver = back;
        match outcome {
            Ok(result) => return result,
            Err(RecvTimeoutError::Timeout) => {}
            Err(RecvTimeoutError::Disconnected) => return Err(Failure::Died),
        }
        if let Err(error) = py.check_signals() {
            abandoned.0.store(true, Ordering::Relaxed);
            note(py, &error)?;
            return Err(error.into());
        }
    }
}

/// Says on an interrupt what becomes of the work (Python 3.11 has notes on exceptions).
fn note(py: Python<'_>, error: &PyErr) -> PyResult<()> {
    let value = error.value(py);
    if error.is_instance_of::<PyKeyboardInterrupt>(py) && value.hasattr("add_note")? {
        let text = "gtfdi: the result is given up; what was under way ends by itself in a thread \
                    of its own";
        value.call_method1("add_note", (text,))?;
    }
    Ok(())
}
