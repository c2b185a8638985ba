//! Numbers that carry their derivatives: the forward mode of automatic differentiation (Griewank
//! and Walther, Evaluating Derivatives, 2nd ed., chapter 3).

#![allow(
    clippy::inline_always,
    reason = "a law of the plant is hundreds of these, of a few instructions each"
)]

use std::array::from_fn;
use std::ops::{Add, Div, Mul, Neg, Sub};

use crate::real::Real;

/// A number and its partial derivatives by `N` variables, exact up to rounding.
///
/// Every operation gives the value that it gives for `f64`, to the last bit, and applies the chain
/// rule to the derivatives. Where a function has none, they follow the formula: `abs` takes 0 at
/// zero (the mean of both sides), `sqrt` at zero gives infinite ones, or NaN where the argument
/// does not depend on the variable. [`Real::where_less`] compares values only, and the derivative
/// is that of the branch taken.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Dual<const N: usize> {
    /// The number itself.
    pub value: f64,
    /// Its derivative by each variable.
    pub partials: [f64; N],
}

impl<const N: usize> Dual<N> {
    /// A number that depends on no variable.
    #[inline(always)]
    pub const fn constant(value: f64) -> Self {
        Self {
            value,
            partials: [0.0; N],
        }
    }

    /// The variable number `index` (from 0) at `value`; a constant where `index` is not below `N`.
    #[inline(always)]
    pub fn variable(value: f64, index: usize) -> Self {
        Self {
            value,
            partials: from_fn(|i| f64::from(u8::from(i == index))),
        }
    }

    /// All `N` variables, at `values`.
    #[inline(always)]
    pub fn variables(values: &[f64; N]) -> [Self; N] {
        from_fn(|index| Self::variable(values[index], index))
    }

    /// The function of `self` with this `value` and derivative.
    #[inline(always)]
    fn chain(self, value: f64, slope: f64) -> Self {
        Self {
            value,
            partials: from_fn(|i| slope * self.partials[i]),
        }
    }

    /// The function of `self` and `other` with this `value` and these partial derivatives.
    #[inline(always)]
    fn chain_two(self, other: Self, value: f64, slope: f64, other_slope: f64) -> Self {
        Self {
            value,
            partials: from_fn(|i| slope * self.partials[i] + other_slope * other.partials[i]),
        }
    }
}

impl<const N: usize> Neg for Dual<N> {
    type Output = Self;

    #[inline(always)]
    fn neg(self) -> Self {
        Self {
            value: -self.value,
            partials: from_fn(|i| -self.partials[i]),
        }
    }
}

impl<const N: usize> Add for Dual<N> {
    type Output = Self;

    #[inline(always)]
    fn add(self, other: Self) -> Self {
        Self {
            value: self.value + other.value,
            partials: from_fn(|i| self.partials[i] + other.partials[i]),
        }
    }
}

impl<const N: usize> Sub for Dual<N> {
    type Output = Self;

    #[inline(always)]
    fn sub(self, other: Self) -> Self {
        Self {
            value: self.value - other.value,
            partials: from_fn(|i| self.partials[i] - other.partials[i]),
        }
    }
}

impl<const N: usize> Mul for Dual<N> {
    type Output = Self;

    #[inline(always)]
    fn mul(self, other: Self) -> Self {
        self.chain_two(other, self.value * other.value, other.value, self.value)
    }
}

impl<const N: usize> Div for Dual<N> {
    type Output = Self;

    #[inline(always)]
    fn div(self, other: Self) -> Self {
        let value = self.value / other.value;
        let slope = 1.0 / other.value;
        self.chain_two(other, value, slope, -value * slope)
    }
}

impl<const N: usize> Add<f64> for Dual<N> {
    type Output = Self;

    #[inline(always)]
    fn add(self, constant: f64) -> Self {
        Self {
            value: self.value + constant,
            ..self
        }
    }
}

impl<const N: usize> Sub<f64> for Dual<N> {
    type Output = Self;

    #[inline(always)]
    fn sub(self, constant: f64) -> Self {
        Self {
            value: self.value - constant,
            ..self
        }
    }
}

impl<const N: usize> Mul<f64> for Dual<N> {
    type Output = Self;

    #[inline(always)]
    fn mul(self, constant: f64) -> Self {
        self.chain(self.value * constant, constant)
    }
}

impl<const N: usize> Div<f64> for Dual<N> {
    type Output = Self;

    #[inline(always)]
    fn div(self, constant: f64) -> Self {
        self.chain(self.value / constant, 1.0 / constant)
    }
}

impl<const N: usize> Real for Dual<N> {
    #[inline(always)]
    fn like(self, value: f64) -> Self {
        Self::constant(value)
    }

    #[inline(always)]
    fn mul_add(self, factor: Self, addend: Self) -> Self {
        Self {
            value: Real::mul_add(self.value, factor.value, addend.value),
            partials: from_fn(|i| {
                factor.value * self.partials[i]
                    + self.value * factor.partials[i]
                    + addend.partials[i]
            }),
        }
    }

    #[inline(always)]
    fn sqrt(self) -> Self {
        let value = self.value.sqrt();
        self.chain(value, 0.5 / value)
    }

    #[inline(always)]
    fn exp(self) -> Self {
        let value = self.value.exp();
        self.chain(value, value)
    }

    #[inline(always)]
    fn exp_m1(self) -> Self {
        // `exp_m1 + 1` would lose the digits of a small slope.
        self.chain(self.value.exp_m1(), self.value.exp())
    }

    #[inline(always)]
    fn ln(self) -> Self {
        self.chain(self.value.ln(), 1.0 / self.value)
    }

    #[inline(always)]
    fn abs(self) -> Self {
        let slope = if self.value == 0.0 {
            0.0
        } else {
            self.value.signum()
        };
        self.chain(self.value.abs(), slope)
    }

    #[inline(always)]
    fn sin(self) -> Self {
        let (sine, cosine) = (self.value.sin(), self.value.cos());
        self.chain(sine, cosine)
    }

    #[inline(always)]
    fn cos(self) -> Self {
        let (sine, cosine) = (self.value.sin(), self.value.cos());
        self.chain(cosine, -sine)
    }

    #[inline(always)]
    fn where_less(
        self,
        limit: Self,
        then: impl FnOnce() -> Self,
        otherwise: impl FnOnce() -> Self,
    ) -> Self {
        if self.value < limit.value {
            then()
        } else {
            otherwise()
        }
    }

    #[inline(always)]
    fn look_up(self, other: Self, function: impl Fn(f64, f64) -> [f64; 3]) -> Self {
        let [value, slope, other_slope] = function(self.value, other.value);
        self.chain_two(other, value, slope, other_slope)
    }
}
