//! A campaign as the workers of an executor are given it.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

use gt_campaign::Progress;
use gt_campaign::campaign::Task;
use pyo3::prelude::*;
use pyo3::types::{PyBytes, PyType};

use crate::error::Failure;
use crate::interrupt::{Abandoned, interruptible};

/// A chunk's number, the SHA-256 of its file and the bytes of that.
type Part<'py> = (u64, String, Bound<'py, PyBytes>);

/// What a worker needs to run chunks of a campaign.
///
/// Its pickle is read by any version, so that the worker can say that it has another one; the reader
/// of pickles would end the worker.
#[pyclass(name = "_CampaignTask", module = "gtfdi._gtfdi", frozen)]
pub struct PyCampaignTask {
    version: String,
    text: String,
    /// Set by the campaign's owner in this process; in another one nobody sets it.
    stopped: Arc<AtomicBool>,
}

/// Ends the work of a worker when its caller has gone or the campaign has ended.
struct Watch<'a> {
    abandoned: &'a Abandoned,
    stopped: &'a AtomicBool,
}

impl Progress for Watch<'_> {
    fn report(&self, _what: &str, _done: usize, _total: usize) {}

    fn is_stopped(&self) -> bool {
        self.abandoned.is_set() || self.stopped.load(Ordering::Relaxed)
    }
}

impl PyCampaignTask {
    /// A task of this version that ends once `stopped` is set.
    pub fn new(task: &Task, stopped: Arc<AtomicBool>) -> Result<Self, Failure> {
        Ok(Self {
            version: env!("CARGO_PKG_VERSION").to_owned(),
            text: task.to_json()?,
            stopped,
        })
    }
}

#[pymethods]
impl PyCampaignTask {
    #[new]
    fn py_new(version: String, text: String) -> Self {
        Self {
            version,
            text,
            stopped: Arc::default(),
        }
    }

    /// Runs chunks one after the other, on one core.
    fn parts<'py>(&self, py: Python<'py>, chunks: Vec<u64>) -> Result<Vec<Part<'py>>, Failure> {
        let task = Task::from_json(&self.version, &self.text)?;
        let stopped = Arc::clone(&self.stopped);
        let parts = interruptible(py, move |abandoned| {
            let stopped = &stopped;
            Ok(task.parts(&chunks, &Watch { abandoned, stopped })?)
        })?;
        let parts = parts.into_iter();
        Ok(parts
            .map(|part| (part.chunk, part.sha256, PyBytes::new(py, &part.bytes)))
            .collect())
    }

    fn __reduce__<'py>(&self, py: Python<'py>) -> (Bound<'py, PyType>, (&str, &str)) {
        (py.get_type::<Self>(), (&self.version, &self.text))
    }
}
