//! The look-ups of the generic laws.

#![expect(clippy::float_cmp, reason = "the same evaluation, bit for bit")]

use std::ops::{Add, Div, Mul, Neg, Sub};

use super::*;
use crate::real::Real;

/// Two lanes that can only look up.
#[derive(Clone, Copy)]
struct Lanes([f64; 2]);

macro_rules! no_operators {
    ($($operator:ident $method:ident),*) => {$(
        impl $operator for Lanes {
            type Output = Self;
            fn $method(self, _: Self) -> Self { unreachable!() }
        }
        impl $operator<f64> for Lanes {
            type Output = Self;
            fn $method(self, _: f64) -> Self { unreachable!() }
        }
    )*};
}

macro_rules! no_functions {
    ($($function:ident),*) => {$(fn $function(self) -> Self { unreachable!() })*};
}

no_operators!(Add add, Sub sub, Mul mul, Div div);

impl Neg for Lanes {
    type Output = Self;
    fn neg(self) -> Self {
        unreachable!()
    }
}

impl Real for Lanes {
    no_functions!(sqrt, exp, exp_m1, ln, abs, sin, cos);

    fn like(self, value: f64) -> Self {
        Self([value; 2])
    }

    fn mul_add(self, _: Self, _: Self) -> Self {
        unreachable!()
    }

    fn where_less(self, _: Self, _: impl FnOnce() -> Self, _: impl FnOnce() -> Self) -> Self {
        unreachable!()
    }

    fn look_up(self, other: Self, function: impl Fn(f64, f64) -> [f64; 3]) -> Self {
        let ([a, b], [c, d]) = (self.0, other.0);
        Self([function(a, c)[0], function(b, d)[0]])
    }
}

proptest! {
    /// Bit for bit, also where one lane follows another in the memory of the last point.
    #[test]
    fn prop_look_ups_are_the_evaluation(
        [a, b] in [0.6..1.2f64, 0.6..1.2f64],
        [c, d] in [2.0..12.0f64, 2.0..12.0f64],
        same in proptest::bool::ANY,
    ) {
        let table = axial_table(5, 6);
        let [b, d] = if same { [a, c] } else { [b, d] };
        let [first, second] = [table.evaluate(a, c), table.evaluate(b, d)];
        prop_assert_eq!(table.flow(a, c), first.flow[0]);
        prop_assert_eq!(table.efficiency(a, c), first.efficiency[0]);
        prop_assert_eq!(
            table.flow_and_efficiency(a, c),
            [first.flow[0], first.efficiency[0]]
        );
        let [flow, efficiency] = table.flow_and_efficiency(Lanes([a, b]), Lanes([c, d]));
        prop_assert_eq!(flow.0, [first.flow[0], second.flow[0]]);
        prop_assert_eq!(efficiency.0, [first.efficiency[0], second.efficiency[0]]);
    }
}
