//! The equations of a generator on several streams side by side.

use alloc::vec::Vec;

use super::Matrices;
use super::blocks::{SUMS, in_pairs};
use super::wide::Simd;

/// The most states that are computed many streams at once.
pub(super) const MOST_STATES: usize = 12;
/// The most inputs and outputs, likewise.
pub(super) const MOST_SIGNALS: usize = 16;

/// The matrices of a generator by columns, added as in
/// [`Blocks::times`](super::blocks::Blocks::times). A term that is 0 may be left out, which changes
/// at most the sign of a zero, and that no residual shows.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Columns {
    /// `[B - K D, K]`, column by column.
    known: Vec<f64>,
    /// `A - K C`, column by column.
    state: Vec<f64>,
    /// `C` and `D`, row by row.
    c: Vec<f64>,
    d: Vec<f64>,
    inputs: usize,
    canonical: bool,
}

impl Columns {
    pub(super) fn new(matrices: &Matrices) -> Self {
        let (nu, ny) = (matrices.u0.len(), matrices.y0.len());
        let nx = matrices.nx();
        let by_columns = |matrix: &[f64], width: usize| -> Vec<f64> {
            let column = |column| (0..nx).map(move |row| matrix[row * width + column]);
            (0..width).flat_map(column).collect()
        };
        let mut known = by_columns(&matrices.closed_b, nu);
        known.extend(by_columns(&matrices.gain, ny));
        Self {
            known,
            state: by_columns(&matrices.closed_a, nx),
            c: matrices.c.clone(),
            d: matrices.d.clone(),
            inputs: nu,
            canonical: matrices.are_canonical(),
        }
    }

    /// As [`Matrices::are_canonical`].
    pub(super) fn canonical(&self) -> bool {
        self.canonical
    }

    /// How much larger than inputs, outputs and state, whichever is largest, the next state can be,
    /// and how much larger a residual.
    pub(super) fn growth(&self, nx: usize) -> (f64, f64) {
        let row = |row: usize| {
            let all = self.known.iter().chain(&self.state);
            all.skip(row).step_by(nx).map(|value| value.abs()).sum()
        };
        let rows = (0..nx).map(row).fold(1.0, f64::max);
        let outputs: f64 = self.c.iter().chain(&self.d).map(|value| value.abs()).sum();
        (rows, 1.0 + outputs)
    }

    /// What state and inputs make of an output: `C x` and `D (u - u0)`.
    #[inline(always)]
    pub(super) fn expected<S: Simd, const NX: usize>(
        &self,
        simd: S,
        output: usize,
        inputs: &[S::f64s],
        x: &[S::f64s; NX],
    ) -> [S::f64s; 2] {
        let row = self.c.get(output * NX..).unwrap_or(&[]);
        let mut of_state = [simd.splat_f64s(0.0); SUMS];
        for (column, (&factor, &x)) in row.iter().zip(x).enumerate() {
            let own = &mut of_state[column % SUMS];
            *own = product_added(simd, factor, x, *own);
        }
        let row = self.d.get(output * self.inputs..).unwrap_or(&[]);
        let mut of_inputs = simd.splat_f64s(0.0);
        for (&factor, &input) in row.iter().zip(inputs) {
            of_inputs = product_added(simd, factor, input, of_inputs);
        }
        [in_pairs(simd, of_state), of_inputs]
    }

    /// The next state, of the deviations of inputs and outputs and of the state.
    #[inline(always)]
    pub(super) fn next<S: Simd, const NX: usize>(
        &self,
        simd: S,
        known: &[S::f64s],
        x: &[S::f64s; NX],
    ) -> [S::f64s; NX] {
        let mut sums = [simd.splat_f64s(0.0); NX];
        let (columns, _) = self.known.as_chunks::<NX>();
        for (column, &value) in columns.iter().zip(known) {
            for (sum, &factor) in sums.iter_mut().zip(column) {
                *sum = multiply_add(simd, factor, value, *sum);
            }
        }
        let (columns, _) = self.state.as_chunks::<NX>();
        let Some(columns) = columns.first_chunk::<NX>() else {
            return sums;
        };
        for (row, sum) in sums.iter_mut().enumerate() {
            *sum = state_terms(simd, columns, row, x, *sum);
        }
        sums
    }

    /// The numbers of a canonical form of this size.
    #[inline(always)]
    pub(super) fn canonical_form<const NX: usize, const NU: usize>(
        &self,
    ) -> Option<Form<'_, NX, NU>> {
        let (known, _) = self.known.as_chunks::<NX>();
        let (state, _) = self.state.as_chunks::<NX>();
        Some(Form {
            b: known.first_chunk::<NU>()?,
            gain: known.get(NU)?,
            a: state.first_chunk::<NX>()?,
            d: self.d.first_chunk::<NU>()?,
        })
    }
}

/// A generator of one output in canonical form: `x_i+ = (known terms) + a_i1 x_1 + x_(i+1)` in all
/// rows but the last, and `r = dy - x_1 - D du`.
pub(super) struct Form<'a, const NX: usize, const NU: usize> {
    b: &'a [[f64; NX]; NU],
    gain: &'a [f64; NX],
    a: &'a [[f64; NX]; NX],
    d: &'a [f64; NU],
}

impl<const NX: usize, const NU: usize> Form<'_, NX, NU> {
    /// The residual and the next state.
    #[inline(always)]
    pub(super) fn step<S: Simd>(
        &self,
        simd: S,
        du: &[S::f64s; NU],
        dy: S::f64s,
        x: &[S::f64s; NX],
    ) -> (S::f64s, [S::f64s; NX]) {
        let mut of_inputs = simd.splat_f64s(0.0);
        let mut next = [of_inputs; NX];
        for ((&factor, column), &du) in self.d.iter().zip(self.b).zip(du) {
            of_inputs = product_added(simd, factor, du, of_inputs);
            for (next, &factor) in next.iter_mut().zip(column) {
                *next = multiply_add(simd, factor, du, *next);
            }
        }
        for (next, &factor) in next.iter_mut().zip(self.gain) {
            *next = multiply_add(simd, factor, dy, *next);
        }
        let shifts = next.iter_mut().zip(&self.a[0]).zip(x.iter().skip(1));
        for ((next, &factor), &following) in shifts {
            *next = simd.add_f64s(multiply_add(simd, factor, x[0], *next), following);
        }
        next[NX - 1] = state_terms(simd, self.a, NX - 1, x, next[NX - 1]);
        let residual = simd.sub_f64s(simd.sub_f64s(dy, x[0]), of_inputs);
        (residual, next)
    }
}

/// `sum` and what the state adds to a row.
#[inline(always)]
fn state_terms<S: Simd, const NX: usize>(
    simd: S,
    columns: &[[f64; NX]; NX],
    row: usize,
    x: &[S::f64s; NX],
    sum: S::f64s,
) -> S::f64s {
    let mut sums = [simd.splat_f64s(0.0); SUMS];
    for (column, (factors, &x)) in columns.iter().zip(x).enumerate() {
        let own = &mut sums[column % SUMS];
        *own = match column {
            0 => multiply_add(simd, factors[row], x, sum),
            1..SUMS => simd.mul_f64s(simd.splat_f64s(factors[row]), x),
            _ => multiply_add(simd, factors[row], x, *own),
        };
    }
    match NX {
        0 => sum,
        1 => sums[0],
        2 => simd.add_f64s(sums[0], sums[1]),
        3 => simd.add_f64s(simd.add_f64s(sums[0], sums[1]), sums[2]),
        _ => in_pairs(simd, sums),
    }
}

/// `factor x value + sum`, rounded once.
#[inline(always)]
fn multiply_add<S: Simd>(simd: S, factor: f64, value: S::f64s, sum: S::f64s) -> S::f64s {
    simd.mul_add_f64s(simd.splat_f64s(factor), value, sum)
}

/// `factor x value`, rounded, and `sum`: as outputs are added, which no later sample waits for.
#[inline(always)]
fn product_added<S: Simd>(simd: S, factor: f64, value: S::f64s, sum: S::f64s) -> S::f64s {
    simd.add_f64s(sum, simd.mul_f64s(simd.splat_f64s(factor), value))
}
