//! Exports hold a block of rows, however long the log is: counted by this program's own allocator.
#![allow(unsafe_code)] // a global allocator is an unsafe trait; this one counts and forwards
#![allow(clippy::unwrap_used, reason = "helpers of tests")]

use std::alloc::{GlobalAlloc, Layout, System};
use std::cell::Cell;
use std::path::Path;

use gt_core::Signal;
use gt_log::{ExportOptions, LogCompression, LogWriter, RunMetadata, export, sample_time_ns};
use tempfile::tempdir;

thread_local! {
    /// Bytes that this thread has now, and the most that it ever had.
    static LIVE: Cell<isize> = const { Cell::new(0) };
    static MOST: Cell<isize> = const { Cell::new(0) };
}

struct Counting;

fn count(bytes: isize) {
    LIVE.with(|live| {
        live.set(live.get() + bytes);
        MOST.with(|most| most.set(most.get().max(live.get())));
    });
}

// SAFETY: every call is forwarded to the system's allocator unchanged; the counters are
// thread-local `Cell`s with constant initialisers and no destructor, so they allocate nothing.
unsafe impl GlobalAlloc for Counting {
    unsafe fn alloc(&self, layout: Layout) -> *mut u8 {
        count(layout.size().cast_signed());
        unsafe { System.alloc(layout) }
    }

    unsafe fn dealloc(&self, pointer: *mut u8, layout: Layout) {
        count(-layout.size().cast_signed());
        unsafe { System.dealloc(pointer, layout) }
    }

    unsafe fn realloc(&self, pointer: *mut u8, layout: Layout, new_size: usize) -> *mut u8 {
        count(new_size.cast_signed() - layout.size().cast_signed());
        unsafe { System.realloc(pointer, layout, new_size) }
    }
}

#[global_allocator]
static ALLOCATOR: Counting = Counting;

/// The most bytes that some work has beside those that are there before it.
fn most_bytes(work: impl FnOnce()) -> isize {
    let before = LIVE.with(Cell::get);
    MOST.with(|most| most.set(before));
    work();
    MOST.with(Cell::get) - before
}

/// A log of this many samples; every thousandth pair is in the wrong order.
fn write(path: &Path, samples: usize) {
    let by = LogCompression::Lz4;
    let mut log = LogWriter::create_with(path, &RunMetadata::default(), by).unwrap();
    let signals = Signal::named(&["a", "b", "c", "d", "e", "f", "g"]);
    let topic = log
        .add_topic("/plant/measured", "Measured", &signals, 0.08, "GT1")
        .unwrap();
    for k in 0..samples {
        let row = match k % 1000 {
            500 => k + 1,
            501 => k - 1,
            _ => k,
        };
        log.write(topic, sample_time_ns(row, 0.08), &[row as f64; 7])
            .unwrap();
    }
    log.finish().unwrap();
}

#[test]
fn a_longer_log_needs_no_more_memory() {
    let folder = tempdir().unwrap();
    let log = folder.path().join("a.mcap");
    for name in ["a.csv", "a.parquet"] {
        let out = folder.path().join(name);
        let [short, long] = [300_000, 600_000].map(|samples| {
            write(&log, samples);
            most_bytes(|| {
                let done = export(&log, &out, &ExportOptions::default()).unwrap();
                assert_eq!(done.rows, samples);
            })
        });
        // Where each row is that is out of order: two numbers a message. Without that the log of
        // 600 000 rows would be 67 MB of cells, and as much before they are columns.
        let order = 300_000 * 2 * 8 + (1 << 20);
        assert!(long - short < order, "{name}: {short} and {long} bytes");
        assert!(long < 64 << 20, "{name}: {long} bytes");
    }
}
