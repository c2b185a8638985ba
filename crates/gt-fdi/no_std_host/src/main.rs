//! A program without std around the runtime of gt-fdi: it has its own panic handler and its own
//! allocator, so that it does not link when any dependency brings std, which has a panic handler
//! too. Run on Linux, it steps every statistic and says by its exit code whether all went well: 0,
//! or the number of the first check that failed. `cargo xtask test` runs it.

#![no_std]
#![no_main]

extern crate alloc;

mod bump;
mod checks;

use core::panic::PanicInfo;

#[link(name = "c")]
unsafe extern "C" {
    fn abort() -> !;
}

#[panic_handler]
fn panic(_: &PanicInfo<'_>) -> ! {
    // SAFETY: the C library's `abort` may be called at any time.
    unsafe { abort() }
}

/// The precompiled `core` names it in its unwinding tables; nothing unwinds.
// SAFETY: no other symbol of that name is linked without std.
#[unsafe(no_mangle)]
extern "C" fn rust_eh_personality() {}

/// Called by the C library's start-up code.
// SAFETY: no other symbol of that name is linked under `no_main`.
#[unsafe(no_mangle)]
extern "C" fn main() -> i32 {
    checks::run()
}
