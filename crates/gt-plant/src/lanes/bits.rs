//! The exponents of the lanes, written and read.
//!
//! A double is 1 bit of sign, 11 of exponent (bits 52 to 62) and 52 of mantissa. In the numbers
//! from 2048 to 4096 the top 11 bits of the mantissa (41 to 51) count whole numbers. So a shift by
//! 11 bits turns such a number's integer part into an exponent, and an exponent into an integer,
//! both exactly. No bit crosses the middle of the double, which suits pulp: it shifts 32-bit words
//! only.

use pulp::{Simd, bytemuck};

use super::Pack;

/// 1.5 * 2^52: a number of less than 2^51 added to it is rounded to an integer, which stands in the
/// lowest bits.
pub(super) const ROUND: f64 = 6755399441055744.0;

/// From the exponent's lowest bit to the mantissa's eleventh highest.
const SHIFT: u32 = 11;

/// The bits of the exponent's integer, once shifted.
const INTEGER: u64 = 0x7ff << 41;

/// The low 52 bits.
const MANTISSA: u64 = (1 << 52) - 1;

/// Exponent of 1.
const BIAS: f64 = 1023.0;

/// `2^n` for integers `n` from -1022 to 1023.
#[inline(always)]
pub(super) fn power_of_two<S: Simd>(n: Pack<S>) -> Pack<S> {
    // The exponent of 2048 is even: the shift pushes all of it out.
    shift_left(n + (2048.0 + BIAS))
}

/// `x * 2^n` for integers `n` from -1024 to 1024, where `x` and the result are normal.
#[inline(always)]
pub(super) fn scale<S: Simd>(x: Pack<S>, n: Pack<S>) -> Pack<S> {
    // 1024 keeps the number above 2048; where n = 1024, the exponent of 4096 leaves the right bit.
    let simd = x.simd;
    let shifted = simd.transmute_u64s_f64s(shift_left(n + (2048.0 + 1024.0)).value);
    let bits = simd.add_u64s(simd.transmute_u64s_f64s(x.value), shifted);
    let bits = simd.sub_u64s(bits, simd.splat_u64s(1024 << 52));
    Pack::new(simd, simd.transmute_f64s_u64s(bits))
}

/// The integer `n` and `m` from `sqrt(1/2)` to `sqrt(2)` with `x = m * 2^n`, `x` positive and
/// normal.
#[inline(always)]
pub(super) fn split<S: Simd>(x: Pack<S>) -> (Pack<S>, Pack<S>) {
    // Raised by what lies between sqrt(1/2) and 1, the bits of x change their exponent where m
    // wraps, and the mantissa counts from sqrt(1/2).
    let simd = x.simd;
    let least = std::f64::consts::FRAC_1_SQRT_2.to_bits();
    let raise = simd.splat_u64s(1.0_f64.to_bits() - least);
    let raised = simd.add_u64s(simd.transmute_u64s_f64s(x.value), raise);
    let m = simd.add_u64s(
        simd.and_u64s(raised, simd.splat_u64s(MANTISSA)),
        simd.splat_u64s(least),
    );
    let shifted = shift_right(Pack::new(simd, simd.transmute_f64s_u64s(raised)));
    let integer = simd.and_u64s(
        simd.transmute_u64s_f64s(shifted.value),
        simd.splat_u64s(INTEGER),
    );
    let n = simd.or_u64s(integer, simd.splat_u64s(2048.0_f64.to_bits()));
    (
        Pack::new(simd, simd.transmute_f64s_u64s(n)) - (2048.0 + BIAS),
        Pack::new(simd, simd.transmute_f64s_u64s(m)),
    )
}

/// The bits of every lane, 11 to the left; those below the upper word must be zero.
#[inline(always)]
fn shift_left<S: Simd>(x: Pack<S>) -> Pack<S> {
    shift(
        x,
        #[inline(always)]
        |words| {
            x.simd
                .wrapping_dyn_shl_u32s(words, x.simd.splat_u32s(SHIFT))
        },
        #[inline(always)]
        |bits| bits << SHIFT,
    )
}

/// The bits of every lane, 11 to the right; the top 11 of the lower word are undefined.
#[inline(always)]
fn shift_right<S: Simd>(x: Pack<S>) -> Pack<S> {
    shift(
        x,
        #[inline(always)]
        |words| {
            x.simd
                .wrapping_dyn_shr_u32s(words, x.simd.splat_u32s(SHIFT))
        },
        #[inline(always)]
        |bits| bits >> SHIFT,
    )
}

/// `register` of the lanes, or `lane` of each where the words make no register of the same size
/// (pulp's scalar "registers" hold one word).
#[inline(always)]
fn shift<S: Simd>(
    x: Pack<S>,
    register: impl FnOnce(S::u32s) -> S::u32s,
    lane: impl Fn(u64) -> u64,
) -> Pack<S> {
    if let Ok(words) = bytemuck::try_cast::<S::f64s, S::u32s>(x.value)
        && let Ok(shifted) = bytemuck::try_cast::<S::u32s, S::f64s>(register(words))
    {
        return Pack::new(x.simd, shifted);
    }
    Pack::from_fn(
        x.simd,
        #[inline(always)]
        |index| {
            let bits = x.lanes().get(index).map_or(0, |number| number.to_bits());
            f64::from_bits(lane(bits))
        },
    )
}
