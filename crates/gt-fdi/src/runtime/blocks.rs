//! Matrices by columns, for sums that do not wait for each other.

use alloc::vec::Vec;

use super::lanes::{LANES, Lanes};
use super::wide::{Simd, registers, registers_mut};

/// Sums of a row that do not wait for each other.
pub(super) const SUMS: usize = 4;

/// The matrix `[known, state]` in blocks of [`LANES`] rows and, of the state, as many columns, each
/// block column by column, filled up with zeros.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Blocks {
    /// Columns of `known`.
    width: usize,
    known: Vec<Lanes>,
    /// Blocks of columns of the state.
    across: usize,
    state: Vec<[Lanes; LANES]>,
}

impl Blocks {
    /// The matrix with the parts of `known` side by side, each part row by row with the number of
    /// its columns.
    pub(super) fn new(known: &[(&[f64], usize)], state: (&[f64], usize), rows: usize) -> Self {
        let column = |(part, width): (&[f64], usize), column: usize, first: usize| {
            Lanes(core::array::from_fn(|lane| {
                let row = first + lane;
                let inside = row < rows && column < width;
                if inside {
                    part[row * width + column]
                } else {
                    0.0
                }
            }))
        };
        let across = state.1.div_ceil(LANES);
        let (mut of_known, mut of_state) = (Vec::new(), Vec::new());
        for first in (0..rows).step_by(LANES) {
            for &part in known {
                of_known.extend((0..part.1).map(|index| column(part, index, first)));
            }
            for block in 0..across {
                let begin = block * LANES;
                of_state.push(core::array::from_fn(|index| {
                    column(state, begin + index, first)
                }));
            }
        }
        Self {
            width: known.iter().map(|(_, width)| width).sum(),
            known: of_known,
            across,
            state: of_state,
        }
    }

    /// All numbers.
    pub(super) fn values(&self) -> impl Iterator<Item = &f64> {
        let columns = self.known.iter().chain(self.state.as_flattened());
        columns.flat_map(|column| &column.0)
    }

    /// `next = matrix [known; x]` in [`SUMS`] sums, of which the first begins with the terms of
    /// `known`, each takes every fourth state, and all are added in pairs: `known` comes first
    /// because the sums can begin with it while `x` is still being computed, and the parts of `x` do
    /// not wait for each other.
    ///
    /// [`Columns`](super::columns::Columns) adds in the same order.
    #[inline(always)]
    pub(super) fn times<S: Simd>(
        &self,
        simd: S,
        known: &[f64],
        x: &[[f64; LANES]],
        next: &mut [[f64; LANES]],
    ) {
        for (block, next) in next.iter_mut().enumerate() {
            let of_known = self.known.get(block * self.width..).unwrap_or(&[]);
            let of_state = self.state.get(block * self.across..).unwrap_or(&[]);
            for (register, next) in registers_mut::<S>(next).iter_mut().enumerate() {
                let mut sums = [simd.splat_f64s(0.0); SUMS];
                add_terms(simd, &mut sums[..1], of_known, known, register);
                for (columns, x) in of_state.iter().zip(x) {
                    add_terms(simd, &mut sums, columns, x, register);
                }
                *next = in_pairs(simd, sums);
            }
        }
    }
}

impl Blocks {
    /// The columns of `known` in two parts and those of the state, of a matrix of up to [`LANES`]
    /// rows and states; `None` of a larger one.
    #[inline(always)]
    pub(super) fn parts<const NU: usize, const NY: usize>(&self) -> Option<Parts<'_, NU, NY>> {
        let (first, second) = self.known.split_at_checked(NU)?;
        let [state] = self.state.as_slice() else {
            return None;
        };
        Some((first.first_chunk()?, second.first_chunk()?, state))
    }
}

type Parts<'a, const NU: usize, const NY: usize> =
    (&'a [Lanes; NU], &'a [Lanes; NY], &'a [Lanes; LANES]);

/// Adds terms to as many sums in turn, product and sum rounded once.
#[inline(always)]
pub(super) fn add_terms<S: Simd>(
    simd: S,
    sums: &mut [S::f64s],
    columns: &[Lanes],
    factors: &[f64],
    register: usize,
) {
    let count = sums.len();
    for (index, (column, &factor)) in columns.iter().zip(factors).enumerate() {
        let column = registers::<S>(&column.0)[register];
        let sum = &mut sums[index % count];
        *sum = simd.mul_add_f64s(column, simd.splat_f64s(factor), *sum);
    }
}

/// As [`add_terms`], each product rounded before it is added: as outputs are added, which no later
/// sample waits for.
#[inline(always)]
pub(super) fn add_products<S: Simd>(
    simd: S,
    sums: &mut [S::f64s],
    columns: &[Lanes],
    factors: &[f64],
    register: usize,
) {
    let count = sums.len();
    for (index, (column, &factor)) in columns.iter().zip(factors).enumerate() {
        let column = registers::<S>(&column.0)[register];
        let sum = &mut sums[index % count];
        *sum = simd.add_f64s(*sum, simd.mul_f64s(column, simd.splat_f64s(factor)));
    }
}

/// The sum of sums.
#[inline(always)]
pub(super) fn in_pairs<S: Simd>(simd: S, [a, b, c, d]: [S::f64s; SUMS]) -> S::f64s {
    simd.add_f64s(simd.add_f64s(a, b), simd.add_f64s(c, d))
}
