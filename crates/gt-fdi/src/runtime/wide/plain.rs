//! What the compiler makes of arrays.

/// The lanes of a register.
const LANES: usize = 8;

/// The most lanes of the registers of [`Wide::with_few_lanes`].
pub(in super::super) const FEW_LANES: usize = LANES;

/// Arithmetic on registers, lane by lane.
pub(crate) trait Simd: Copy {
    /// A register.
    #[allow(non_camel_case_types)]
    type f64s: Copy;
    /// A truth a lane.
    #[allow(non_camel_case_types)]
    type m64s: Copy;
    const F64_LANES: usize;

    fn splat_f64s(self, value: f64) -> Self::f64s;
    fn add_f64s(self, left: Self::f64s, right: Self::f64s) -> Self::f64s;
    fn sub_f64s(self, left: Self::f64s, right: Self::f64s) -> Self::f64s;
    fn mul_f64s(self, left: Self::f64s, right: Self::f64s) -> Self::f64s;
    fn mul_add_f64s(self, left: Self::f64s, right: Self::f64s, sum: Self::f64s) -> Self::f64s;
    fn abs_f64s(self, values: Self::f64s) -> Self::f64s;
    fn neg_f64s(self, values: Self::f64s) -> Self::f64s;
    fn min_f64s(self, left: Self::f64s, right: Self::f64s) -> Self::f64s;
    fn max_f64s(self, left: Self::f64s, right: Self::f64s) -> Self::f64s;
    fn less_than_f64s(self, left: Self::f64s, right: Self::f64s) -> Self::m64s;
    fn select_f64s(self, mask: Self::m64s, yes: Self::f64s, no: Self::f64s) -> Self::f64s;
    fn reduce_sum_f64s(self, values: Self::f64s) -> f64;

    fn registers(values: &[f64]) -> &[Self::f64s];
    fn registers_mut(values: &mut [f64]) -> &mut [Self::f64s];
    fn lanes_of(registers: &[Self::f64s]) -> &[f64];
}

/// Work on registers of any kind.
pub(crate) trait Work {
    type Output;
    fn with_simd<S: Simd>(self, simd: S) -> Self::Output;
}

/// The only kind of registers.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Wide;

impl Wide {
    pub(crate) fn new() -> Self {
        Self
    }

    pub(crate) fn with_few_lanes() -> Self {
        Self
    }

    #[inline(always)]
    pub(crate) fn run<W: Work>(self, work: W) -> W::Output {
        work.with_simd(self)
    }
}

#[inline(always)]
fn lane_by_lane(
    left: [f64; LANES],
    right: [f64; LANES],
    of: impl Fn(f64, f64) -> f64,
) -> [f64; LANES] {
    core::array::from_fn(|lane| of(left[lane], right[lane]))
}

impl Simd for Wide {
    type f64s = [f64; LANES];
    type m64s = [bool; LANES];
    const F64_LANES: usize = LANES;

    #[inline(always)]
    fn splat_f64s(self, value: f64) -> Self::f64s {
        [value; LANES]
    }
    #[inline(always)]
    fn add_f64s(self, left: Self::f64s, right: Self::f64s) -> Self::f64s {
        lane_by_lane(left, right, |left, right| left + right)
    }
    #[inline(always)]
    fn sub_f64s(self, left: Self::f64s, right: Self::f64s) -> Self::f64s {
        lane_by_lane(left, right, |left, right| left - right)
    }
    #[inline(always)]
    fn mul_f64s(self, left: Self::f64s, right: Self::f64s) -> Self::f64s {
        lane_by_lane(left, right, |left, right| left * right)
    }
    #[inline(always)]
    fn mul_add_f64s(self, left: Self::f64s, right: Self::f64s, sum: Self::f64s) -> Self::f64s {
        core::array::from_fn(|lane| {
            let (left, right, sum) = (left[lane], right[lane], sum[lane]);
            // Matrices are filled up with zeros, and without an instruction for it this takes long.
            if left == 0.0 && right.is_finite() {
                sum
            } else {
                libm::fma(left, right, sum)
            }
        })
    }
    #[inline(always)]
    fn abs_f64s(self, values: Self::f64s) -> Self::f64s {
        values.map(f64::abs)
    }
    #[inline(always)]
    fn neg_f64s(self, values: Self::f64s) -> Self::f64s {
        values.map(|value| -value)
    }
    #[inline(always)]
    fn min_f64s(self, left: Self::f64s, right: Self::f64s) -> Self::f64s {
        lane_by_lane(left, right, f64::min)
    }
    #[inline(always)]
    fn max_f64s(self, left: Self::f64s, right: Self::f64s) -> Self::f64s {
        lane_by_lane(left, right, f64::max)
    }
    #[inline(always)]
    fn less_than_f64s(self, left: Self::f64s, right: Self::f64s) -> Self::m64s {
        core::array::from_fn(|lane| left[lane] < right[lane])
    }
    #[inline(always)]
    fn select_f64s(self, mask: Self::m64s, yes: Self::f64s, no: Self::f64s) -> Self::f64s {
        core::array::from_fn(|lane| if mask[lane] { yes[lane] } else { no[lane] })
    }
    #[inline(always)]
    fn reduce_sum_f64s(self, values: Self::f64s) -> f64 {
        values.iter().sum()
    }

    #[inline(always)]
    fn registers(values: &[f64]) -> &[Self::f64s] {
        values.as_chunks().0
    }
    #[inline(always)]
    fn registers_mut(values: &mut [f64]) -> &mut [Self::f64s] {
        values.as_chunks_mut().0
    }
    #[inline(always)]
    fn lanes_of(registers: &[Self::f64s]) -> &[f64] {
        registers.as_flattened()
    }
}

/// Numbers as registers; their count must be a multiple of the lanes.
#[inline(always)]
pub(crate) fn registers<S: Simd>(values: &[f64]) -> &[S::f64s] {
    S::registers(values)
}

/// As [`registers`].
#[inline(always)]
pub(crate) fn registers_mut<S: Simd>(values: &mut [f64]) -> &mut [S::f64s] {
    S::registers_mut(values)
}

/// The numbers in registers.
#[inline(always)]
pub(in super::super) fn lanes_of<S: Simd>(registers: &[S::f64s]) -> &[f64] {
    S::lanes_of(registers)
}
