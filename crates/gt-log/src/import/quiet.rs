//! Panics of somebody else's code, which are answers and no news.

use std::cell::Cell;
use std::panic::{AssertUnwindSafe, catch_unwind, set_hook, take_hook};
use std::sync::Once;

thread_local! {
    /// Whether this thread expects a panic.
    static EXPECTED: Cell<bool> = const { Cell::new(false) };
}

/// Runs `work`; none where it panics, of which nothing is printed. What `work` changes must be thrown
/// away then. The hook that prints panics is wrapped once: all others are told as before.
pub(super) fn quietly<T>(work: impl FnOnce() -> T) -> Option<T> {
    static WRAPPED: Once = Once::new();
    WRAPPED.call_once(|| {
        let usual = take_hook();
        set_hook(Box::new(move |panic| {
            if !EXPECTED.get() {
                usual(panic);
            }
        }));
    });
    let before = EXPECTED.replace(true);
    let result = catch_unwind(AssertUnwindSafe(work));
    EXPECTED.set(before);
    result.ok()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_panic_is_an_answer_and_the_next_call_is_as_before() {
        assert_eq!(quietly(|| 3), Some(3));
        let bytes: Vec<u8> = Vec::new();
        assert_eq!(quietly(|| bytes[7]), None);
        assert!(!EXPECTED.get());
        assert_eq!(
            quietly(|| quietly(|| bytes[7]).is_none() && EXPECTED.get()),
            Some(true)
        );
    }
}
