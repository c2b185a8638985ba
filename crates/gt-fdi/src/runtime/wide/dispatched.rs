//! The widest instruction set of the machine.

use pulp::{Arch, WithSimd, bytemuck};

pub(crate) use pulp::{Simd, WithSimd as Work};

/// The most lanes of the registers of [`Wide::with_few_lanes`].
pub(in super::super) const FEW_LANES: usize = 4;

/// The widest instruction set of the machine, found once.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Wide(Arch);

impl Wide {
    pub(crate) fn new() -> Self {
        Self(Arch::new())
    }

    /// The set for a few sums that wait for each other: registers of four where there are also some
    /// of eight, whose numbers take longer from one lane to all others.
    pub(crate) fn with_few_lanes() -> Self {
        #[cfg(target_arch = "x86_64")]
        if let Some(simd) = pulp::x86::V3::try_new() {
            return Self(Arch::V3(simd));
        }
        Self::new()
    }

    /// Does `work` with it. What is not inlined into `work` falls out of it.
    #[inline(always)]
    pub(crate) fn run<W: WithSimd>(self, work: W) -> W::Output {
        self.0.dispatch(work)
    }
}

/// Numbers as registers; their count must be a multiple of the lanes.
#[inline(always)]
pub(crate) fn registers<S: Simd>(values: &[f64]) -> &[S::f64s] {
    bytemuck::cast_slice(values)
}

/// As [`registers`].
#[inline(always)]
pub(crate) fn registers_mut<S: Simd>(values: &mut [f64]) -> &mut [S::f64s] {
    bytemuck::cast_slice_mut(values)
}

/// The numbers in registers.
#[inline(always)]
pub(in super::super) fn lanes_of<S: Simd>(registers: &[S::f64s]) -> &[f64] {
    bytemuck::cast_slice(registers)
}
