//! Whether long work is to end early.

use std::sync::atomic::{AtomicBool, Ordering};

use thiserror::Error;

/// What long work looks at between steps, to end where nobody waits for its result any more. A look is
/// cheap: it is taken once a sample, an evaluation of a likelihood or the like.
pub trait Stop: Sync {
    /// Whether the work is to end.
    fn is_stopped(&self) -> bool;

    /// An error where the work is to end.
    ///
    /// # Errors
    /// [`Stopped`].
    fn check(&self) -> Result<(), Stopped> {
        if self.is_stopped() {
            Err(Stopped)
        } else {
            Ok(())
        }
    }
}

/// A flag that somebody else sets.
impl Stop for AtomicBool {
    fn is_stopped(&self) -> bool {
        self.load(Ordering::Relaxed)
    }
}

/// Work that comes to its own end.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Never;

impl Stop for Never {
    fn is_stopped(&self) -> bool {
        false
    }
}

/// Work was ended by whoever watches it, so it has no result.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Error)]
#[error("expected work that comes to its end, found it stopped by its caller")]
pub struct Stopped;

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_flag_stops_once_it_is_set() {
        let flag = AtomicBool::new(false);
        assert_eq!((flag.check(), Never.check()), (Ok(()), Ok(())));
        flag.store(true, Ordering::Relaxed);
        assert_eq!((flag.check(), Never.check()), (Err(Stopped), Ok(())));
    }
}
