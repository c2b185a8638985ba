//! The numbers that the laws of the plant are written in.
//!
//! Every law is generic over [`Real`], so that one text gives the plant's value (`f64`), its exact
//! derivative (dual numbers) and many plants at once (lanes). Constants stand
//! on the right of an operator (`x * 2.0`), because a pack of lanes is made from another one only.

use std::ops::{Add, Div, Mul, Neg, Sub};

/// A real number, or something that calculates like one.
pub trait Real:
    Copy
    + Neg<Output = Self>
    + Add<Output = Self>
    + Sub<Output = Self>
    + Mul<Output = Self>
    + Div<Output = Self>
    + Add<f64, Output = Self>
    + Sub<f64, Output = Self>
    + Mul<f64, Output = Self>
    + Div<f64, Output = Self>
{
    /// The constant `value`, of the kind of `self`.
    #[must_use]
    fn like(self, value: f64) -> Self;

    /// `self * factor + addend`; whether it rounds once or twice is left to the machine.
    #[must_use]
    fn mul_add(self, factor: Self, addend: Self) -> Self;

    /// Square root.
    #[must_use]
    fn sqrt(self) -> Self;

    /// Exponential.
    #[must_use]
    fn exp(self) -> Self;

    /// `exp(self) - 1`, exact near zero.
    #[must_use]
    fn exp_m1(self) -> Self;

    /// Natural logarithm.
    #[must_use]
    fn ln(self) -> Self;

    /// Absolute value.
    #[must_use]
    fn abs(self) -> Self;

    /// The sine.
    #[must_use]
    fn sin(self) -> Self;

    /// The cosine.
    #[must_use]
    fn cos(self) -> Self;

    /// `then()` where `self < limit`, else `otherwise()`; also for a NaN. Plain numbers evaluate
    /// only the branch that is taken, lanes both.
    #[must_use]
    fn where_less(
        self,
        limit: Self,
        then: impl FnOnce() -> Self,
        otherwise: impl FnOnce() -> Self,
    ) -> Self;

    /// A function of two numbers that is known with its partial derivatives: `function(a, b)` gives
    /// the value, its derivative by `a` and that by `b`. Lanes call it once for each lane.
    #[must_use]
    fn look_up(self, other: Self, function: impl Fn(f64, f64) -> [f64; 3]) -> Self;

    /// The square.
    #[inline(always)]
    #[must_use]
    fn squared(self) -> Self {
        self * self
    }

    /// The smaller of the two; `self` for a NaN in either.
    #[inline(always)]
    #[must_use]
    fn at_most(self, limit: Self) -> Self {
        limit.where_less(
            self,
            #[inline(always)]
            || limit,
            #[inline(always)]
            || self,
        )
    }

    /// The larger of the two; `self` for a NaN in either.
    #[inline(always)]
    #[must_use]
    fn at_least(self, limit: Self) -> Self {
        self.where_less(
            limit,
            #[inline(always)]
            || limit,
            #[inline(always)]
            || self,
        )
    }
}

impl Real for f64 {
    #[inline(always)]
    fn like(self, value: f64) -> Self {
        value
    }

    #[inline(always)]
    fn mul_add(self, factor: Self, addend: Self) -> Self {
        // Without the instruction, a fused operation would be a call.
        self * factor + addend
    }

    #[inline(always)]
    fn sqrt(self) -> Self {
        f64::sqrt(self)
    }

    #[inline(always)]
    fn exp(self) -> Self {
        f64::exp(self)
    }

    #[inline(always)]
    fn exp_m1(self) -> Self {
        f64::exp_m1(self)
    }

    #[inline(always)]
    fn ln(self) -> Self {
        f64::ln(self)
    }

    #[inline(always)]
    fn abs(self) -> Self {
        f64::abs(self)
    }

    #[inline(always)]
    fn sin(self) -> Self {
        f64::sin(self)
    }

    #[inline(always)]
    fn cos(self) -> Self {
        f64::cos(self)
    }

    #[inline(always)]
    fn where_less(
        self,
        limit: Self,
        then: impl FnOnce() -> Self,
        otherwise: impl FnOnce() -> Self,
    ) -> Self {
        if self < limit { then() } else { otherwise() }
    }

    #[inline(always)]
    fn look_up(self, other: Self, function: impl Fn(f64, f64) -> [f64; 3]) -> Self {
        function(self, other)[0]
    }
}

/// The polynomial `c[0] + c[1] x + ...` by Horner's rule.
#[inline(always)]
pub fn polynomial<R: Real, const N: usize>(x: R, coefficients: [f64; N]) -> R {
    let mut sum = x.like(coefficients[N - 1]);
    for index in (0..N - 1).rev() {
        sum = sum.mul_add(x, x.like(coefficients[index]));
    }
    sum
}
