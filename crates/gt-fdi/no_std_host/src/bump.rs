//! An allocator that hands out a block of static memory from its beginning to its end.

use core::alloc::{GlobalAlloc, Layout};
use core::cell::UnsafeCell;
use core::ptr::null_mut;
use core::sync::atomic::{AtomicUsize, Ordering};

/// Enough for every statistic of the checks.
const SIZE: usize = 1 << 20;

/// Static memory and how much of it is used. Nothing is given back.
pub struct Bump {
    memory: UnsafeCell<[u8; SIZE]>,
    used: AtomicUsize,
}

// SAFETY: parts of the memory are handed out once each, by an atomic counter.
unsafe impl Sync for Bump {}

#[global_allocator]
static ALLOCATOR: Bump = Bump {
    memory: UnsafeCell::new([0; SIZE]),
    used: AtomicUsize::new(0),
};

/// Bytes handed out so far.
pub fn used() -> usize {
    ALLOCATOR.used.load(Ordering::Relaxed)
}

// SAFETY: each block lies within the memory, is aligned and overlaps with no other.
unsafe impl GlobalAlloc for Bump {
    unsafe fn alloc(&self, layout: Layout) -> *mut u8 {
        let base = self.memory.get().cast::<u8>();
        // The address at which the free rest begins decides how much the alignment costs.
        let end_of = |used: usize| {
            let address = (base as usize).checked_add(used)?;
            let start = used.checked_add(address.next_multiple_of(layout.align()) - address)?;
            let end = start.checked_add(layout.size())?;
            (end <= SIZE).then_some((start, end))
        };
        let taken = self
            .used
            .fetch_update(Ordering::Relaxed, Ordering::Relaxed, |used| {
                end_of(used).map(|(_, end)| end)
            });
        match taken.ok().and_then(end_of) {
            // SAFETY: `start` is within the memory.
            Some((start, _)) => unsafe { base.add(start) },
            None => null_mut(),
        }
    }

    unsafe fn dealloc(&self, _: *mut u8, _: Layout) {}
}
