//! Many plants at once: a register of `f64` lanes that is a [`Real`].
//!
//! Code that is generic over [`Real`] runs in a [`pulp::WithSimd`] operation, which
//! `pulp::Arch::new().dispatch(operation)` gives the widest instruction set of the machine:
//!
//! ```
//! use gt_plant::lanes::Pack;
//! use gt_plant::real::Real;
//! use pulp::{Arch, Simd, WithSimd};
//!
//! /// `exp(-x / 2)` of every element.
//! struct Decay<'a>(&'a mut [f64]);
//!
//! #[inline(always)]
//! fn law<R: Real>(x: R) -> R {
//!     (-x / 2.0).exp()
//! }
//!
//! impl WithSimd for Decay<'_> {
//!     type Output = ();
//!
//!     #[inline(always)]
//!     fn with_simd<S: Simd>(self, simd: S) {
//!         for group in self.0.chunks_mut(Pack::<S>::LANES) {
//!             law(Pack::load(simd, group)).store(group);
//!         }
//!     }
//! }
//!
//! let mut x = [0.0, 2.0, 4.0];
//! Arch::new().dispatch(Decay(&mut x));
//! assert!((x[2] - (-2.0_f64).exp()).abs() < 1e-15);
//! ```
//!
//! Every function on the way must be `#[inline(always)]`, and so must closures that calculate with
//! packs (`x.where_less(limit, #[inline(always)] || ..., #[inline(always)] || ...)`): outside the
//! dispatched function the compiler may not use the instruction set, and each operation becomes a
//! call. For the same reason fill arrays by `for`, not by `map` or `std::array::from_fn`, where the
//! elements take more than a few operations.
//!
//! A lane's result depends on that lane's numbers only, bit for bit. Instruction sets with and
//! without fused multiplication differ by rounding errors.

mod bits;
mod elementary;

use std::ops::{Add, Div, Mul, Neg, Sub};

use pulp::{Simd, bytemuck};

pub use elementary::LARGEST_ANGLE;

use crate::real::Real;

/// As many `f64` as a register of the instruction set `S` holds.
#[derive(Debug, Clone, Copy)]
pub struct Pack<S: Simd> {
    simd: S,
    value: S::f64s,
}

impl<S: Simd> Pack<S> {
    /// Numbers in a pack: 8 with AVX-512, 4 with AVX2, 1 without either.
    pub const LANES: usize = S::F64_LANES;

    /// The register `value`.
    #[inline(always)]
    pub fn new(simd: S, value: S::f64s) -> Self {
        Self { simd, value }
    }

    /// `value` in every lane.
    #[inline(always)]
    pub fn splat(simd: S, value: f64) -> Self {
        Self::new(simd, simd.splat_f64s(value))
    }

    /// `lane(0)`, `lane(1)`, ... in the lanes.
    #[inline(always)]
    pub fn from_fn(simd: S, mut lane: impl FnMut(usize) -> f64) -> Self {
        let mut value = simd.splat_f64s(0.0);
        let lanes: &mut [f64] = bytemuck::cast_slice_mut(std::slice::from_mut(&mut value));
        for (index, to) in lanes.iter_mut().enumerate() {
            *to = lane(index);
        }
        Self::new(simd, value)
    }

    /// The first [`Self::LANES`] of `numbers`. Where there are fewer, the last one fills the
    /// other lanes (so that they calculate something harmless); where there is none, zero.
    #[inline(always)]
    pub fn load(simd: S, numbers: &[f64]) -> Self {
        if let Some(&value) = S::as_simd_f64s(numbers).0.first() {
            return Self::new(simd, value);
        }
        Self::from_fn(simd, |lane| {
            let number = numbers.get(lane).or(numbers.last());
            number.copied().unwrap_or(0.0)
        })
    }

    /// Writes the lanes to the start of `numbers`, as many as fit.
    #[inline(always)]
    pub fn store(self, numbers: &mut [f64]) {
        if let Some(value) = S::as_mut_simd_f64s(numbers).0.first_mut() {
            *value = self.value;
            return;
        }
        for (number, &lane) in numbers.iter_mut().zip(self.lanes()) {
            *number = lane;
        }
    }

    /// Puts `number` into one lane; a lane that is not there is left alone.
    #[inline(always)]
    pub fn set(&mut self, lane: usize, number: f64) {
        let lanes: &mut [f64] = bytemuck::cast_slice_mut(std::slice::from_mut(&mut self.value));
        if let Some(to) = lanes.get_mut(lane) {
            *to = number;
        }
    }

    /// The numbers in the lanes.
    #[inline(always)]
    pub fn lanes(&self) -> &[f64] {
        bytemuck::cast_slice(std::slice::from_ref(&self.value))
    }

    /// The register.
    #[inline(always)]
    pub fn value(self) -> S::f64s {
        self.value
    }

    /// The instruction set.
    #[inline(always)]
    pub fn simd(self) -> S {
        self.simd
    }

    /// `self` where `mask` is set, else `other`.
    #[inline(always)]
    fn or_else(self, mask: S::m64s, other: Self) -> Self {
        let value = self.simd.select_f64s(mask, self.value, other.value);
        Self::new(self.simd, value)
    }

    /// Where `self < limit`; never for a NaN.
    #[inline(always)]
    fn less(self, limit: Self) -> S::m64s {
        self.simd.less_than_f64s(self.value, limit.value)
    }

    /// `addend - self * factor`.
    #[inline(always)]
    fn negate_mul_add(self, factor: f64, addend: Self) -> Self {
        let factor = self.simd.splat_f64s(factor);
        let value = self
            .simd
            .negate_mul_add_e_f64s(self.value, factor, addend.value);
        Self::new(self.simd, value)
    }
}

macro_rules! operators {
    ($($operator:ident, $method:ident, $intrinsic:ident;)*) => {$(
        impl<S: Simd> $operator for Pack<S> {
            type Output = Self;

            #[inline(always)]
            fn $method(self, other: Self) -> Self {
                Self::new(self.simd, self.simd.$intrinsic(self.value, other.value))
            }
        }

        impl<S: Simd> $operator<f64> for Pack<S> {
            type Output = Self;

            #[inline(always)]
            fn $method(self, other: f64) -> Self {
                $operator::$method(self, Self::splat(self.simd, other))
            }
        }
    )*};
}

operators! {
    Add, add, add_f64s;
    Sub, sub, sub_f64s;
    Mul, mul, mul_f64s;
    Div, div, div_f64s;
}

impl<S: Simd> Neg for Pack<S> {
    type Output = Self;

    #[inline(always)]
    fn neg(self) -> Self {
        Self::new(self.simd, self.simd.neg_f64s(self.value))
    }
}

/// Errors and domains of the elementary functions stand at each; they hold on every instruction
/// set. One unit in the last place (ulp) is 2.2e-16 of the result at most.
impl<S: Simd> Real for Pack<S> {
    #[inline(always)]
    fn like(self, value: f64) -> Self {
        Self::splat(self.simd, value)
    }

    /// Rounds once where the instruction set has the fused operation, else twice.
    #[inline(always)]
    fn mul_add(self, factor: Self, addend: Self) -> Self {
        let value = self
            .simd
            .mul_add_e_f64s(self.value, factor.value, addend.value);
        Self::new(self.simd, value)
    }

    #[inline(always)]
    fn sqrt(self) -> Self {
        Self::new(self.simd, self.simd.sqrt_f64s(self.value))
    }

    /// Within 2 ulp. Results below the smallest normal number (argument below -708.396) are zero,
    /// those above the largest number (argument above 709.782) infinite.
    #[inline(always)]
    fn exp(self) -> Self {
        elementary::exp(self)
    }

    /// Within 2 ulp; infinite above 709.782, -1 below -40.
    #[inline(always)]
    fn exp_m1(self) -> Self {
        elementary::exp_m1(self)
    }

    /// Within 2 ulp. Zero and subnormal numbers of either sign give minus infinity, other negative
    /// numbers NaN.
    #[inline(always)]
    fn ln(self) -> Self {
        elementary::ln(self)
    }

    #[inline(always)]
    fn abs(self) -> Self {
        Self::new(self.simd, self.simd.abs_f64s(self.value))
    }

    /// Within 2 ulp up to [`LARGEST_ANGLE`] (of either sign), NaN beyond.
    #[inline(always)]
    fn sin(self) -> Self {
        elementary::sin(self)
    }

    /// Within 2 ulp up to [`LARGEST_ANGLE`] (of either sign), NaN beyond.
    #[inline(always)]
    fn cos(self) -> Self {
        elementary::cos(self)
    }

    #[inline(always)]
    fn where_less(
        self,
        limit: Self,
        then: impl FnOnce() -> Self,
        otherwise: impl FnOnce() -> Self,
    ) -> Self {
        then().or_else(self.less(limit), otherwise())
    }

    #[inline(always)]
    fn look_up(self, other: Self, function: impl Fn(f64, f64) -> [f64; 3]) -> Self {
        let mut result = self.value;
        let lanes: &mut [f64] = bytemuck::cast_slice_mut(std::slice::from_mut(&mut result));
        for (lane, &other) in lanes.iter_mut().zip(other.lanes()) {
            *lane = function(*lane, other)[0];
        }
        Self::new(self.simd, result)
    }
}
