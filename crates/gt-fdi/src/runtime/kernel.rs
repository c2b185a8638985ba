//! A step of a small generator with nothing missing and nothing huge.

use super::blocks::{LANES, SUMS, add_terms, in_pairs};
use super::wide::{Simd, registers_mut};

/// An output further than this from its operating point, in any unit, is judged but kept out of
/// the state: half of the range of doubles, so that no product with a sane gain overflows.
pub(super) const LARGEST_CORRECTION: f64 = 1e150;

/// The equations of a generator with up to [`LANES`] states, rows or columns filled up with zeros.
#[derive(Clone, Copy)]
pub(super) struct Kernel<'a, const NU: usize, const NY: usize> {
    /// `B - K D` by columns.
    pub(super) b: &'a [[f64; LANES]; NU],
    /// `K` by columns.
    pub(super) gain: &'a [[f64; LANES]; NY],
    /// `A - K C` by columns.
    pub(super) a: &'a [[f64; LANES]; LANES],
    /// `C` and `D` by rows.
    pub(super) c: &'a [[f64; LANES]; NY],
    pub(super) d: &'a [[f64; NU]; NY],
    pub(super) u0: &'a [f64; NU],
    pub(super) y0: &'a [f64; NY],
    /// Where each input stands among inputs and, after them, outputs.
    pub(super) places: &'a [usize; NU],
}

impl<const NU: usize, const NY: usize> Kernel<'_, NU, NY> {
    /// Writes the residuals and gives the next state; `None`, and residuals of no account, for a
    /// sample that needs a closer look.
    ///
    /// Adds in the order of [`Blocks::times`](super::blocks::Blocks::times) and [`dot`].
    #[inline(always)]
    pub(super) fn step<S: Simd>(
        &self,
        simd: S,
        (u, y): (&[f64], &[f64]),
        first: usize,
        x: &[f64; LANES],
        residuals: &mut [f64],
    ) -> Option<[f64; LANES]> {
        let own_y = y.get(first..)?.first_chunk::<NY>()?;
        let mut du = [0.0; NU];
        for ((du, &place), u0) in du.iter_mut().zip(self.places).zip(self.u0) {
            let value = match place.checked_sub(u.len()) {
                None => u.get(place),
                Some(output) => y.get(output),
            };
            *du = value? - u0;
        }
        let residuals = residuals.first_chunk_mut::<NY>()?;
        let mut dy = [0.0; NY];
        let mut finite = true;
        for output in 0..NY {
            dy[output] = own_y[output] - self.y0[output] + 0.0;
            let of_inputs = dot_in_order(&self.d[output], &du);
            residuals[output] = dy[output] - dot(&self.c[output], x) - of_inputs;
            finite &= dy[output].abs() <= LARGEST_CORRECTION;
            finite &= residuals[output].is_finite();
        }
        let mut next = [0.0; LANES];
        for (register, next) in registers_mut::<S>(&mut next).iter_mut().enumerate() {
            let mut sums = [simd.splat_f64s(0.0); SUMS];
            add_terms(simd, &mut sums[..1], self.b, &du, register);
            add_terms(simd, &mut sums[..1], self.gain, &dy, register);
            add_terms(simd, &mut sums, self.a, x, register);
            *next = in_pairs(simd, sums);
        }
        // An input that is not finite leaves no finite state.
        finite &= all_finite(&next);
        finite.then_some(next)
    }
}

/// The sum of products in [`SUMS`] sums, of which each takes every fourth.
#[inline(always)]
pub(super) fn dot(left: &[f64], right: &[f64]) -> f64 {
    let mut sums = [0.0; SUMS];
    let (left, right) = (left.as_chunks::<SUMS>().0, right.as_chunks::<SUMS>().0);
    for (left, right) in left.iter().zip(right) {
        for ((sum, left), right) in sums.iter_mut().zip(left).zip(right) {
            *sum += left * right;
        }
    }
    (sums[0] + sums[1]) + (sums[2] + sums[3])
}

/// The sum of products one after the other.
#[inline(always)]
pub(super) fn dot_in_order(left: &[f64], right: &[f64]) -> f64 {
    let products = left.iter().zip(right);
    products.fold(0.0, |sum, (left, right)| sum + left * right)
}

/// Looks at all values, which costs less than stopping early.
#[inline(always)]
pub(super) fn all_finite(values: &[f64]) -> bool {
    values
        .iter()
        .fold(true, |finite, value| finite & value.is_finite())
}
