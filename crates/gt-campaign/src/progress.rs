//! Who is told how far long work has come.

use gtfdi::core::Stop;

use crate::error::CampaignError;

/// An observer of long work; drawing is left to whoever implements it.
pub trait Progress: Sync {
    /// `done` of `total` steps are over; `what` is under way or was just finished.
    fn report(&self, what: &str, done: usize, total: usize);

    /// Whether the work is to end at the next place where it can be taken up again.
    fn is_stopped(&self) -> bool {
        false
    }
}

/// Tells how far work has come, and ends it where that is wanted.
pub(crate) fn report_or_stop(
    progress: &dyn Progress,
    what: &str,
    done: usize,
    total: usize,
) -> Result<(), CampaignError> {
    progress.report(what, done, total);
    if progress.is_stopped() {
        let (done, total) = (done as u64, total as u64);
        return Err(CampaignError::Stopped { done, total });
    }
    Ok(())
}

/// What the rooms below look at, where only an observer of a campaign is there.
pub(crate) struct Watched<'a>(pub &'a dyn Progress);

impl Stop for Watched<'_> {
    fn is_stopped(&self) -> bool {
        self.0.is_stopped()
    }
}

/// Nobody is told.
#[derive(Debug, Clone, Copy, Default)]
pub struct Silent;

impl Progress for Silent {
    fn report(&self, _what: &str, _done: usize, _total: usize) {}
}
