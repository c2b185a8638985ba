//! The owner of a campaign whose runs are made by the workers of an executor.

use std::path::PathBuf;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex, PoisonError};

use gt_campaign::campaign::{Campaign, Folder, Part, Task, prepare};
use pyo3::prelude::*;

use crate::array::json_out;
use crate::campaign::{Watch, summary_of};
use crate::campaign_task::PyCampaignTask;
use crate::error::Failure;
use crate::interrupt::interruptible;

/// A campaign with its folder, which is locked until this is closed; gives out chunks and keeps what
/// comes back.
#[pyclass(name = "_CampaignDesk", module = "gtfdi._gtfdi", frozen)]
pub struct PyCampaignDesk {
    open: Mutex<Option<(Arc<Campaign>, Arc<Folder>)>>,
    /// What workers of this process look at.
    stopped: Arc<AtomicBool>,
}

impl PyCampaignDesk {
    fn opened(&self) -> Result<(Arc<Campaign>, Arc<Folder>), Failure> {
        let open = self.open.lock().unwrap_or_else(PoisonError::into_inner);
        open.clone().ok_or_else(|| Failure::Option {
            option: "campaign",
            expected: "one that is open".to_owned(),
            found: "one that was closed".to_owned(),
        })
    }
}

#[pymethods]
impl PyCampaignDesk {
    /// Opens or begins a campaign, and makes its bank on all cores where it has none yet.
    #[new]
    fn new(py: Python<'_>, spec: PathBuf, out: PathBuf) -> Result<Self, Failure> {
        let (campaign, folder) = interruptible(py, move |abandoned| {
            Ok(prepare(&spec, &out, &Watch(abandoned))?)
        })?;
        Ok(Self {
            open: Mutex::new(Some((Arc::new(campaign), Arc::new(folder)))),
            stopped: Arc::default(),
        })
    }

    /// Number of runs.
    #[getter]
    fn runs(&self) -> Result<u64, Failure> {
        Ok(self.opened()?.0.spec().runs)
    }

    /// The chunks that are still to be run; none where all rows are in one file.
    fn missing(&self, py: Python<'_>) -> Result<Vec<u64>, Failure> {
        let (_, folder) = self.opened()?;
        py.detach(|| match folder.finished() {
            Some(_) => Ok(Vec::new()),
            None => Ok(folder.missing()?),
        })
    }

    /// The first run of a chunk and that after its last.
    fn runs_of(&self, chunk: u64) -> Result<(u64, u64), Failure> {
        let runs = self.opened()?.1.runs_of(chunk);
        Ok((runs.start, runs.end))
    }

    /// What a worker needs.
    fn task(&self) -> Result<PyCampaignTask, Failure> {
        let (campaign, folder) = self.opened()?;
        let task = Task::new(&campaign, &folder)?;
        PyCampaignTask::new(&task, Arc::clone(&self.stopped))
    }

    /// Keeps what a worker made of a chunk.
    fn keep(
        &self,
        py: Python<'_>,
        chunk: u64,
        sha256: String,
        bytes: Vec<u8>,
    ) -> Result<(), Failure> {
        let (_, folder) = self.opened()?;
        let part = Part {
            chunk,
            sha256,
            bytes,
        };
        py.detach(|| Ok(folder.keep_part(&part)?))
    }

    /// Puts all rows into one file and says what they say; a chunk that is still missing is run here.
    fn finish<'py>(&self, py: Python<'py>) -> Result<Bound<'py, PyAny>, Failure> {
        let (campaign, folder) = self.opened()?;
        let summary = interruptible(py, move |abandoned| {
            summary_of(&campaign, &folder, &Watch(abandoned))
        })?;
        json_out(py, "summary", &summary)
    }

    /// Unlocks the folder, and ends the workers of this process that still run chunks of it.
    fn close(&self) {
        self.stopped.store(true, Ordering::Relaxed);
        self.open
            .lock()
            .unwrap_or_else(PoisonError::into_inner)
            .take();
    }
}
