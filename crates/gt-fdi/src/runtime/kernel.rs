//! A step of a small generator with nothing missing and nothing huge.

use super::blocks::{SUMS, add_products, add_terms, in_pairs};
use super::lanes::{LANES, Lanes};
use super::last_row::LastRow;
use super::rows::Rows;
use super::wide::{Simd, registers, registers_mut};

/// An output further than this from its operating point, in any unit, is judged but kept out of
/// the state: half of the range of doubles, so that no product with a sane gain overflows.
pub(super) const LARGEST_CORRECTION: f64 = 1e150;

/// A sum of squares up to this is of deviations and residuals that need no closer look.
const SAFE: f64 = 1e200;

/// The equations of a generator with up to [`LANES`] states, rows or columns filled up with zeros.
///
/// Of a canonical form the state is multiplied by the first column and the last row of `A - K C` only,
/// and the output is the first state.
#[derive(Clone, Copy)]
pub(super) struct Kernel<'a, const NU: usize, const NY: usize, const CANONICAL: bool> {
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
    /// Of a canonical form.
    pub(super) last: &'a LastRow,
}

/// A state. The last element of a canonical form is kept in all lanes of registers of its own, because
/// the next one waits for it and would wait longer for a number that has to be brought there; its place
/// among the `elements` is taken by no number of any account.
#[derive(Clone, Copy)]
struct State {
    elements: [f64; LANES],
    last: [f64; SUMS],
}

/// What inputs and outputs add to the next state, and to the sums of its last row.
#[derive(Clone, Copy)]
struct Known {
    rows: [f64; LANES],
    last: [f64; SUMS],
}

impl<const NU: usize, const NY: usize, const CANONICAL: bool> Kernel<'_, NU, NY, CANONICAL> {
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
        let (residuals, next) = self.equations(simd, (du, dy), &known, &self.state(x));
        let next = self.elements(&next);
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
        let mut state = self.state(x);
        let mut sizes = Sizes::default();
        let samples = u.arrays::<NU>().zip(y.arrays::<NY>());
        for (residuals, sample) in residuals.iter_mut().zip(samples) {
            let now = self.deviations(sample);
            let known = self.known(simd, &now);
            (*residuals, state) = self.equations(simd, now, &known, &state);
            sizes.add(&now.1, residuals);
        }
        *x = self.elements(&state);
        // What is not finite in a state stays there, times 0 as well.
        sizes.are_safe() & all_finite(x)
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

    /// What inputs and outputs add.
    #[inline(always)]
    fn known<S: Simd>(&self, simd: S, (du, dy): &([f64; NU], [f64; NY])) -> Known {
        let mut known = Known {
            rows: [0.0; LANES],
            last: [0.0; SUMS],
        };
        for (register, known) in registers_mut::<S>(&mut known.rows).iter_mut().enumerate() {
            let mut sum = [simd.splat_f64s(0.0)];
            add_terms(simd, &mut sum, self.b, du, register);
            add_terms(simd, &mut sum, self.gain, dy, register);
            *known = sum[0];
        }
        if CANONICAL {
            let mut sum = [simd.splat_f64s(0.0)];
            add_terms(simd, &mut sum, &self.last.of_inputs, du, 0);
            add_terms(simd, &mut sum, &self.last.of_output, dy, 0);
            registers_mut::<S>(&mut known.last)[0] = sum[0];
        }
        known
    }

    /// A state of these elements.
    #[inline(always)]
    fn state(&self, elements: &[f64; LANES]) -> State {
        let elements = *elements;
        let last = [self.last.last_of(&elements); SUMS];
        State { elements, last }
    }

    /// The elements of a state.
    #[inline(always)]
    fn elements(&self, state: &State) -> [f64; LANES] {
        let mut elements = state.elements;
        if CANONICAL {
            self.last.put(state.last[0], &mut elements);
        }
        elements
    }

    /// Adds in the order of [`Blocks::times`](super::blocks::Blocks::times), [`dot`] and
    /// [`dot_in_order`]; left out are terms that are 0, which changes at most the sign of a zero, and
    /// that no residual shows.
    #[inline(always)]
    fn equations<S: Simd>(
        &self,
        simd: S,
        (du, dy): ([f64; NU], [f64; NY]),
        known: &Known,
        state: &State,
    ) -> ([f64; NY], State) {
        let x = &state.elements;
        if CANONICAL {
            let residual = dy[0] - x[0] - self.of_inputs(&du);
            let next = State {
                elements: self.shifted(simd, &known.rows, state),
                last: self.next_last(simd, &known.last, state),
            };
            return ([residual; NY], next);
        }
        let mut next = known.rows;
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
        let next = State {
            elements: next,
            last: state.last,
        };
        (residuals, next)
    }

    /// All elements but the last of the next state of a canonical form.
    #[inline(always)]
    fn shifted<S: Simd>(&self, simd: S, known: &[f64; LANES], state: &State) -> [f64; LANES] {
        let State { elements: x, last } = state;
        let following: [f64; LANES] =
            core::array::from_fn(|lane| x.get(lane + 1).copied().unwrap_or_default());
        let last = registers::<S>(last)[0];
        let mut next = *known;
        for (register, next) in registers_mut::<S>(&mut next).iter_mut().enumerate() {
            let of = |lanes: &[f64; LANES]| registers::<S>(lanes)[register];
            let first = simd.mul_add_f64s(of(&self.a[0].0), simd.splat_f64s(x[0]), *next);
            let precedes_last = simd.less_than_f64s(simd.splat_f64s(0.0), of(&self.last.before.0));
            let following = simd.select_f64s(precedes_last, last, of(&following));
            *next = simd.add_f64s(first, following);
        }
        next
    }

    /// The last element of the next state of a canonical form.
    #[inline(always)]
    fn next_last<S: Simd>(&self, simd: S, known: &[f64; SUMS], state: &State) -> [f64; SUMS] {
        let mut sums = *known;
        let mut add_products = |factors: &[f64], x: &[f64]| {
            let terms = registers::<S>(factors).iter().zip(registers::<S>(x));
            for (sum, (&factors, &x)) in registers_mut::<S>(&mut sums).iter_mut().zip(terms) {
                *sum = simd.mul_add_f64s(factors, x, *sum);
            }
        };
        for (factors, x) in self
            .last
            .others
            .0
            .chunks(SUMS)
            .zip(state.elements.chunks(SUMS))
        {
            add_products(factors, x);
        }
        add_products(&self.last.own, &state.last);
        let [a, b, c, d] = sums;
        let pairs = add(simd, sums, [b, a, d, c]);
        let [a, b, c, d] = pairs;
        add(simd, pairs, [c, d, a, b])
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
        dy - sum_of_products(products) - self.of_inputs(du)
    }

    /// What the inputs add to a single output.
    #[inline(always)]
    fn of_inputs(&self, du: &[f64; NU]) -> f64 {
        let mut of_inputs = 0.0;
        for (d, du) in self.d.iter().zip(du) {
            of_inputs += d.0[0] * du;
        }
        of_inputs
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

/// The sums of the squares of the outputs' deviations and of residuals: they are safe when all are, and
/// NaN or infinite when one is. An input that is not finite leaves no finite state.
#[derive(Default)]
struct Sizes {
    outputs: f64,
    residuals: f64,
}

impl Sizes {
    #[inline(always)]
    fn add(&mut self, dy: &[f64], residuals: &[f64]) {
        for dy in dy {
            self.outputs += dy * dy;
        }
        for residual in residuals {
            self.residuals += residual * residual;
        }
    }

    #[inline(always)]
    fn are_safe(&self) -> bool {
        self.outputs + self.residuals <= SAFE
    }
}

/// `left + right`, lane by lane.
#[inline(always)]
fn add<S: Simd>(simd: S, left: [f64; SUMS], right: [f64; SUMS]) -> [f64; SUMS] {
    let mut sums = left;
    for (sum, &right) in registers_mut::<S>(&mut sums)
        .iter_mut()
        .zip(registers::<S>(&right))
    {
        *sum = simd.add_f64s(*sum, right);
    }
    sums
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
