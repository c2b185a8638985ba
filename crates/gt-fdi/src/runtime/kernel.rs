//! A step of a small generator with nothing missing and nothing huge.

use super::blocks::{SUMS, add_products, add_terms, in_pairs};
use super::lanes::{LANES, Lanes};
use super::rows::Rows;
use super::wide::{Simd, registers, registers_mut};

/// An output further than this from its operating point, in any unit, is judged but kept out of
/// the state: half of the range of doubles, so that no product with a sane gain overflows.
pub(super) const LARGEST_CORRECTION: f64 = 1e150;

/// A sum of squares up to this is of deviations, residuals and states that need no closer look.
const SAFE: f64 = 1e200;

/// The equations of a generator with up to [`LANES`] states, rows or columns filled up with zeros.
#[derive(Clone, Copy)]
pub(super) struct Kernel<'a, const NU: usize, const NY: usize> {
    /// `B - K D` by columns.
    pub(super) b: &'a [Lanes; NU],
    /// `K` by columns.
    pub(super) gain: &'a [Lanes; NY],
    /// `A - K C` by columns.
    pub(super) a: &'a [Lanes; LANES],
    /// `C` and `D` by columns.
    pub(super) c: &'a [Lanes; LANES],
    /// `C` by rows.
    pub(super) c_rows: &'a [[f64; LANES]; NY],
    pub(super) d: &'a [Lanes; NU],
    pub(super) u0: &'a [f64; NU],
    pub(super) y0: &'a [f64; NY],
}

impl<const NU: usize, const NY: usize> Kernel<'_, NU, NY> {
    /// Residuals and next state of one sample; `None` for a sample that needs a closer look.
    #[inline(always)]
    pub(super) fn step<S: Simd>(
        &self,
        simd: S,
        sample: (&[f64; NU], &[f64; NY]),
        x: &[f64; LANES],
    ) -> Option<([f64; NY], [f64; LANES])> {
        let (du, dy) = self.deviations(sample);
        let known = self.known(simd, &(du, dy));
        let (residuals, next) = self.equations(simd, (du, dy), &known, x);
        let corrects = |dy: &f64| dy.abs() <= LARGEST_CORRECTION;
        // An input that is not finite leaves no finite state.
        let fair = dy.iter().all(corrects) & all_finite(&residuals) & all_finite(&next);
        fair.then_some((residuals, next))
    }

    /// Samples one after the other, with their residuals (samples x NY); `false`, and neither
    /// residuals nor state of any account, when one needs a closer look.
    #[inline(always)]
    pub(super) fn run<S: Simd>(
        &self,
        simd: S,
        (u, y): (Rows<'_>, Rows<'_>),
        x: &mut [f64; LANES],
        residuals: &mut [[f64; NY]],
    ) -> bool {
        let mut sizes = Sizes::none(simd);
        let mut samples = u.arrays::<NU>().zip(y.arrays::<NY>());
        let Some(first) = samples.next() else {
            return true;
        };
        // What does not wait for the state is computed a sample ahead.
        let mut deviations = self.deviations(first);
        let mut known = self.known(simd, &deviations);
        for residuals in residuals {
            let now = deviations;
            let of_known = known;
            if let Some(sample) = samples.next() {
                deviations = self.deviations(sample);
                known = self.known(simd, &deviations);
            }
            (*residuals, *x) = self.equations(simd, now, &of_known, x);
            sizes.add(simd, &now.1, residuals, x);
        }
        sizes.are_safe(simd)
    }

    /// Inputs and outputs from the operating point.
    #[inline(always)]
    fn deviations(&self, (u, y): (&[f64; NU], &[f64; NY])) -> ([f64; NU], [f64; NY]) {
        let (mut du, mut dy) = (*u, *y);
        for (du, u0) in du.iter_mut().zip(self.u0) {
            *du -= u0;
        }
        for (dy, y0) in dy.iter_mut().zip(self.y0) {
            *dy -= y0;
        }
        (du, dy)
    }

    /// What inputs and outputs add to the next state.
    #[inline(always)]
    fn known<S: Simd>(&self, simd: S, (du, dy): &([f64; NU], [f64; NY])) -> [f64; LANES] {
        let mut known = [0.0; LANES];
        for (register, known) in registers_mut::<S>(&mut known).iter_mut().enumerate() {
            let mut sum = [simd.splat_f64s(0.0)];
            add_terms(simd, &mut sum, self.b, du, register);
            add_terms(simd, &mut sum, self.gain, dy, register);
            *known = sum[0];
        }
        known
    }

    /// Adds in the order of [`Blocks::times`](super::blocks::Blocks::times), [`dot`] and
    /// [`dot_in_order`].
    #[inline(always)]
    fn equations<S: Simd>(
        &self,
        simd: S,
        (du, dy): ([f64; NU], [f64; NY]),
        known: &[f64; LANES],
        x: &[f64; LANES],
    ) -> ([f64; NY], [f64; LANES]) {
        let mut next = *known;
        for (register, next) in registers_mut::<S>(&mut next).iter_mut().enumerate() {
            let mut sums = [simd.splat_f64s(0.0); SUMS];
            sums[0] = *next;
            add_terms(simd, &mut sums, self.a, x, register);
            *next = in_pairs(simd, sums);
        }
        let residuals = match self.c_rows.as_slice() {
            [c] => [self.residual(simd, c, (&du, dy[0]), x); NY],
            _ => self.residuals(simd, (&du, &dy), x),
        };
        (residuals, next)
    }

    /// The residual of a single output, of which `c` is the row: by columns all lanes but one would
    /// be idle.
    #[inline(always)]
    fn residual<S: Simd>(
        &self,
        simd: S,
        c: &[f64; LANES],
        (du, dy): (&[f64; NU], f64),
        x: &[f64; LANES],
    ) -> f64 {
        let mut products = [0.0; LANES];
        let factors = registers::<S>(c).iter().zip(registers::<S>(x));
        for (product, (&c, &x)) in registers_mut::<S>(&mut products).iter_mut().zip(factors) {
            *product = simd.mul_f64s(c, x);
        }
        let of_state = sum_of_products(products);
        let mut of_inputs = 0.0;
        for (d, du) in self.d.iter().zip(du) {
            of_inputs += d.0[0] * du;
        }
        dy - of_state - of_inputs
    }

    /// The residuals of several outputs side by side.
    #[inline(always)]
    fn residuals<S: Simd>(
        &self,
        simd: S,
        (du, dy): (&[f64; NU], &[f64; NY]),
        x: &[f64; LANES],
    ) -> [f64; NY] {
        let (mut of_state, mut of_inputs) = ([0.0; LANES], [0.0; LANES]);
        for register in 0..NY.div_ceil(S::F64_LANES) {
            let mut sum = [simd.splat_f64s(0.0)];
            add_products(simd, &mut sum, self.d, du, register);
            registers_mut::<S>(&mut of_inputs)[register] = sum[0];
            let mut sums = [simd.splat_f64s(0.0); SUMS];
            add_products(simd, &mut sums, self.c, x, register);
            registers_mut::<S>(&mut of_state)[register] = in_pairs(simd, sums);
        }
        let mut residuals = *dy;
        for (output, residual) in residuals.iter_mut().enumerate() {
            *residual = *residual - of_state[output] - of_inputs[output];
        }
        residuals
    }
}

/// The sums of the squares of the outputs' deviations, of residuals and states: they are safe when all
/// are, and NaN or infinite when one is. An input that is not finite leaves no finite state.
struct Sizes<S: Simd> {
    outputs: f64,
    residuals: f64,
    state: S::f64s,
}

impl<S: Simd> Sizes<S> {
    #[inline(always)]
    fn none(simd: S) -> Self {
        Self {
            outputs: 0.0,
            residuals: 0.0,
            state: simd.splat_f64s(0.0),
        }
    }

    #[inline(always)]
    fn add(&mut self, simd: S, dy: &[f64], residuals: &[f64], x: &[f64; LANES]) {
        for dy in dy {
            self.outputs += dy * dy;
        }
        for residual in residuals {
            self.residuals += residual * residual;
        }
        for &x in registers::<S>(x) {
            self.state = simd.mul_add_f64s(x, x, self.state);
        }
    }

    #[inline(always)]
    fn are_safe(&self, simd: S) -> bool {
        self.outputs + self.residuals + simd.reduce_sum_f64s(self.state) <= SAFE
    }
}

/// As [`dot`], of products that there are already.
#[inline(always)]
fn sum_of_products(products: [f64; LANES]) -> f64 {
    let sums: [f64; SUMS] = core::array::from_fn(|first| products[first] + products[first + SUMS]);
    (sums[0] + sums[1]) + (sums[2] + sums[3])
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
