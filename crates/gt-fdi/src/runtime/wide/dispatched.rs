//! The widest instruction set of the machine.

use pulp::{Arch, WithSimd, bytemuck};

pub(crate) use pulp::{Simd, WithSimd as Work};

/// The widest instruction set of the machine, found once.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Wide(Arch);

impl Wide {
    pub(crate) fn new() -> Self {
        Self(Arch::new())
    }

    /// Does `work` with it. What is not inlined into `work` falls out of it.
    #[inline(always)]
    pub(crate) fn run<W: WithSimd>(self, work: W) -> W::Output {
        self.0.dispatch(work)
    }
}

/// Numbers as registers; their count must be a multiple of the lanes.
#[inline(always)]
pub(in super::super) fn registers<S: Simd>(values: &[f64]) -> &[S::f64s] {
    bytemuck::cast_slice(values)
}

/// As [`registers`].
#[inline(always)]
pub(in super::super) fn registers_mut<S: Simd>(values: &mut [f64]) -> &mut [S::f64s] {
    bytemuck::cast_slice_mut(values)
}

/// The numbers in registers.
#[inline(always)]
pub(in super::super) fn lanes_of<S: Simd>(registers: &[S::f64s]) -> &[f64] {
    bytemuck::cast_slice(registers)
}
