//! Who is told how far long work has come.

/// An observer of long work; drawing is left to whoever implements it.
pub trait Progress: Sync {
    /// `done` of `total` steps are over; `what` is under way or was just finished.
    fn report(&self, what: &str, done: usize, total: usize);

    /// Whether the work is to end at the next place where it can be taken up again.
    fn is_stopped(&self) -> bool {
        false
    }
}

/// Nobody is told.
#[derive(Debug, Clone, Copy, Default)]
pub struct Silent;

impl Progress for Silent {
    fn report(&self, _what: &str, _done: usize, _total: usize) {}
}
