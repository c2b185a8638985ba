//! The lanes against plain numbers, on every instruction set that the machine has.

mod functions;
mod integration;
mod operations;

use pulp::Arch;

/// The instruction sets that the machine has.
fn sets() -> Vec<(&'static str, Arch)> {
    let mut sets = vec![("scalar", Arch::Scalar)];
    #[cfg(any(target_arch = "x86", target_arch = "x86_64"))]
    {
        sets.extend(pulp::x86::V3::try_new().map(|simd| ("V3", Arch::V3(simd))));
        sets.extend(pulp::x86::V4::try_new().map(|simd| ("V4", Arch::V4(simd))));
    }
    if !cfg!(any(target_arch = "x86", target_arch = "x86_64")) {
        sets.push(("native", Arch::new()));
    }
    sets
}
