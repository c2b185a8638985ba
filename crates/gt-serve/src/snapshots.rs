//! What machines remember, on the disk.

use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::thread;
use std::time::{Duration, Instant};

use gt_log::write_atomically;

use crate::hub::Hub;
use crate::pipeline::MachineSnapshot;

/// How often a waiting thread looks whether to stop.
const PATIENCE: Duration = Duration::from_millis(100);

/// How long a snapshot waits for the journal.
const JOURNAL: Duration = Duration::from_secs(1);

/// The file of a machine's snapshot.
fn file(folder: &Path, machine: &str) -> PathBuf {
    folder.join(format!("{machine}.snapshot.json"))
}

/// The snapshot of a machine, where there is one; one that cannot be read is as none, which the log
/// says.
pub fn read(folder: &Path, machine: &str) -> Option<MachineSnapshot> {
    let path = file(folder, machine);
    let text = std::fs::read(&path).ok()?;
    match serde_json::from_slice(&text) {
        Ok(snapshot) => Some(snapshot),
        Err(cause) => {
            tracing::warn!(path = %path.display(), %cause, "no snapshot of this version");
            None
        }
    }
}

/// Writes the snapshots of all machines, one after the other, each whole or not at all.
pub fn write_all(hub: &Hub, folder: &Path) {
    for cell in &hub.cells {
        let (snapshot, events) = {
            let machine = cell.lock();
            (machine.snapshot(), hub.outbox().count())
        };
        let Some(snapshot) = snapshot else {
            continue;
        };
        // A snapshot knows of no alarm that the journal does not know.
        if !hub.outbox().is_written(events, JOURNAL) {
            tracing::warn!(
                machine = cell.name,
                "no snapshot: the journal's disk is slow"
            );
            continue;
        }
        let path = file(folder, &cell.name);
        let written = serde_json::to_vec(&snapshot).map_err(|cause| cause.to_string());
        let written = written
            .and_then(|text| write_atomically(&path, &text).map_err(|error| error.to_string()));
        if let Err(error) = written {
            tracing::error!(path = %path.display(), error, "no snapshot");
        }
    }
}

/// Writes snapshots every `period` until the service stops.
pub fn run(hub: &Arc<Hub>, folder: &Path, period: Duration) {
    let mut written = Instant::now();
    while !hub.is_stopping() {
        thread::sleep(PATIENCE);
        if written.elapsed() >= period {
            write_all(hub, folder);
            written = Instant::now();
        }
    }
}
