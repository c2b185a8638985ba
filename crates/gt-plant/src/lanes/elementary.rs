//! The elementary functions of the lanes.
//!
//! Arguments are reduced by Cody and Waite (*Software Manual for the Elementary Functions*, 1980),
//! with constants in parts whose products with the integer are exact. The polynomials are minimax
//! in the error relative to the function, found by Remez exchange in 60 digits on the reduced
//! interval and then rounded to doubles; each says what error it had before. The rest of the error
//! is rounding: last additions are ordered so that the large term is exact or nearly so.

use std::f64::consts::{FRAC_2_PI, LOG2_E};

use pulp::Simd;

use super::Pack;
use super::bits::{ROUND, power_of_two, scale, split};
use crate::real::Real;

/// Largest angle of which [`Real::sin`] and [`Real::cos`] of lanes know the value: 2^20.
pub const LARGEST_ANGLE: f64 = 1048576.0;

/// ln 2 in two parts, the first of 42 bits.
const LN_2: [f64; 2] = [0.6931471805598903, 5.497923018708371e-14];

/// pi / 2 in three parts, the first two of 33 bits.
const HALF_PI: [f64; 3] = [
    1.5707963267341256,
    6.077100506303966e-11,
    2.0222662487959506e-21,
];

/// `(exp(r) - 1 - r) / r^2` for `|r| <= ln(2) / 2`; error 2^-61.7 of `exp(r) - 1`.
const EXP: [f64; 11] = [
    0.5,
    0.16666666666666677,
    0.0416666666666667,
    0.00833333333332161,
    0.0013888888888866828,
    0.00019841269886193563,
    2.480158736060149e-05,
    2.7557244129063987e-06,
    2.755724270705425e-07,
    2.5109068644873564e-08,
    2.092446262635191e-09,
];

/// `(2 artanh(s) / s - 2) / s^2` in `s^2`, for `s` up to `(sqrt(2) - 1) / (sqrt(2) + 1)`; error
/// 2^-59.5 of `2 artanh(s)`.
const LN: [f64; 7] = [
    0.6666666666666734,
    0.39999999999418806,
    0.2857142874162515,
    0.22222198640642007,
    0.1818356123164999,
    0.1531412154983048,
    0.14795305449772309,
];

/// `(sin(r) / r - 1) / r^2` in `r^2`, for `|r| <= pi / 4`: the first, then the others; error
/// 2^-58.0 of `sin(r)`.
const SIN: (f64, [f64; 5]) = (
    -0.16666666666666632,
    [
        0.008333333333322411,
        -0.0001984126982980324,
        2.7557313689657713e-06,
        -2.505075767959213e-08,
        1.5896766529913083e-10,
    ],
);

/// `(cos(r) - 1 + r^2 / 2) / r^4` in `r^2`, for `|r| <= pi / 4`; error 2^-64.2.
const COS: [f64; 6] = [
    0.0416666666666666,
    -0.001388888888887422,
    2.480158728953195e-05,
    -2.7557314364458063e-07,
    2.087572468348365e-09,
    -1.1359710891650056e-11,
];

/// The exponential of -708.396... is the smallest normal number, that of 709.782... the largest.
const EXP_RANGE: [f64; 2] = [-708.3964185322641, 709.782712893384];

/// `c[0] + c[1] x + c[2] x^2 + ...` in two chains (even and odd powers), for half the latency.
#[inline(always)]
fn polynomial<S: Simd, const N: usize>(x: Pack<S>, c: &[f64; N]) -> Pack<S> {
    let square = x * x;
    let [mut even, mut odd] = [x.like(0.0); 2];
    for (power, &c) in c.iter().enumerate().rev() {
        let chain = if power % 2 == 0 { &mut even } else { &mut odd };
        *chain = if power + 2 < N {
            chain.mul_add(square, x.like(c))
        } else {
            x.like(c)
        };
    }
    odd.mul_add(x, even)
}

/// `n`, `r` and `rest` with `x = n ln 2 + r`, `n` an integer and `exp(r) = 1 + r + rest`.
#[inline(always)]
fn reduce<S: Simd>(x: Pack<S>) -> [Pack<S>; 3] {
    let n = x.mul_add(x.like(LOG2_E), x.like(ROUND)) - ROUND;
    let high = n.negate_mul_add(LN_2[0], x);
    let low = n * LN_2[1];
    let r = high - low;
    // What the difference lost: the derivative of exp(r) is near enough to 1 for it.
    let lost = (high - r) - low;
    [n, r, (r * r).mul_add(polynomial(r, &EXP), lost)]
}

/// See [`Real::exp`] of [`Pack`].
#[inline(always)]
pub(super) fn exp<S: Simd>(x: Pack<S>) -> Pack<S> {
    let [n, r, rest] = reduce(x);
    let result = scale((r + rest) + 1.0, n);
    let result = x.like(0.0).or_else(x.less(x.like(EXP_RANGE[0])), result);
    not_above_range(x, result)
}

/// See [`Real::exp_m1`] of [`Pack`].
#[inline(always)]
pub(super) fn exp_m1<S: Simd>(x: Pack<S>) -> Pack<S> {
    let [n, r, rest] = reduce(x);
    // Halved, because 2^1024 is no number. The small term comes last: where 2^n - 1 and 2^n r
    // cancel, their sum is exact.
    let half = power_of_two(n - 1.0);
    let result = half.mul_add(rest, half.mul_add(r, half - 0.5));
    let result = result + result;
    let result = x.like(-1.0).or_else(x.less(x.like(-40.0)), result);
    // The smallest numbers lose bits by halving, and zero its sign.
    let result = x.or_else(x.abs().less(x.like(1e-17)), result);
    not_above_range(x, result)
}

/// `result`, but infinite where `x` is above the range of the exponential, NaN where it is NaN.
#[inline(always)]
fn not_above_range<S: Simd>(x: Pack<S>, result: Pack<S>) -> Pack<S> {
    let simd = x.simd;
    let within = simd.less_than_or_equal_f64s(x.value, simd.splat_f64s(EXP_RANGE[1]));
    result.or_else(within, x + f64::INFINITY)
}

/// See [`Real::ln`] of [`Pack`].
#[inline(always)]
pub(super) fn ln<S: Simd>(x: Pack<S>) -> Pack<S> {
    // ln(1 + f) = 2 artanh(s) = 2 s + s rest, where s = f / (2 + f) and thus
    // 2 s = f - s f = f - f^2 / 2 + s f^2 / 2: f stays exact and the corrections are small.
    let (n, m) = split(x);
    let f = m - 1.0;
    let s = f / (m + 1.0);
    let square = s * s;
    let rest = polynomial(square, &LN) * square;
    let half = f * f * 0.5;
    let low = s.mul_add(half + rest, n * LN_2[1]);
    let result = n.mul_add(x.like(LN_2[0]), f - (half - low));

    let result = result.or_else(x.less(x.like(f64::INFINITY)), x);
    let least = x.less(x.like(f64::MIN_POSITIVE));
    let result = x.like(f64::NEG_INFINITY).or_else(least, result);
    let negative = x
        .simd
        .less_than_or_equal_f64s(x.value, x.simd.splat_f64s(-f64::MIN_POSITIVE));
    x.like(f64::NAN).or_else(negative, result)
}

/// See [`Real::sin`] of [`Pack`].
#[inline(always)]
pub(super) fn sin<S: Simd>(x: Pack<S>) -> Pack<S> {
    circular(x, 0)
}

/// See [`Real::cos`] of [`Pack`].
#[inline(always)]
pub(super) fn cos<S: Simd>(x: Pack<S>) -> Pack<S> {
    circular(x, 1)
}

/// The sine of `x` and as many quarters of a turn.
#[inline(always)]
fn circular<S: Simd>(x: Pack<S>, quarters: u64) -> Pack<S> {
    let simd = x.simd;
    let rounded = x.mul_add(x.like(FRAC_2_PI), x.like(ROUND));
    let n = rounded - ROUND;
    // r + low = x - n pi / 2, to far more bits than a double has.
    let first = n.negate_mul_add(HALF_PI[0], x);
    let second = n * HALF_PI[1];
    let difference = first - second;
    let third = (n * HALF_PI[2]) - ((first - difference) - second);
    let r = difference - third;
    let low = (difference - r) - third;
    let square = r * r;

    let cube = square * r;
    let curve = polynomial(square, &SIN.1);
    let curve = (low * 0.5 - cube * curve) * square - low;
    let sine = r - cube.negate_mul_add(SIN.0, curve);

    let half = square * 0.5;
    let fall = x.like(1.0) - half;
    let lost = (x.like(1.0) - fall) - half;
    let curve = square * square * polynomial(square, &COS);
    let cosine = fall + (lost + (curve - r * low));

    // The integer's last two bits are the quarter.
    let quarter = simd.transmute_u64s_f64s(rounded.value);
    let quarter = simd.add_u64s(quarter, simd.splat_u64s(quarters));
    let [one, two] = [simd.splat_u64s(1), simd.splat_u64s(2)];
    let odd = simd.equal_u64s(simd.and_u64s(quarter, one), one);
    let below = simd.equal_u64s(simd.and_u64s(quarter, two), two);
    let size = cosine.or_else(odd, sine);
    let result = (-size).or_else(below, size);
    let known = simd.less_than_or_equal_f64s(x.abs().value, simd.splat_f64s(LARGEST_ANGLE));
    result.or_else(known, x.like(f64::NAN))
}
