//! The last row of a canonical form.

use super::Matrices;
use super::blocks::SUMS;
use super::lanes::{LANES, Lanes};
use super::wide::FEW_LANES;

/// The most inputs of a form whose last row is kept by itself.
const MOST_INPUTS: usize = 4;

/// The last row of the equations of a generator of one output in canonical form: all other rows of
/// its `A - K C` are the first state's column and the next state.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct LastRow {
    /// `B - K D` of the row, each number the first of otherwise zeros.
    pub(super) of_inputs: [Lanes; MOST_INPUTS],
    /// `K` of the row, likewise.
    pub(super) of_output: [Lanes; 1],
    /// `A - K C` of the row, but of the last element.
    pub(super) others: Lanes,
    /// `A - K C` of the row and the last element, in the place of the sum that takes it.
    pub(super) own: [f64; SUMS],
    /// 1 in the place before the row's, else 0.
    pub(super) before: Lanes,
    /// The place of the row.
    place: usize,
}

impl LastRow {
    /// That of no form.
    pub(super) const NONE: Self = Self {
        of_inputs: [Lanes::ZERO; MOST_INPUTS],
        of_output: [Lanes::ZERO],
        others: Lanes::ZERO,
        own: [0.0; SUMS],
        before: Lanes::ZERO,
        place: 0,
    };

    /// The last row of a canonical form with 2 to [`LANES`] states and up to 4 inputs; `None` of any
    /// other generator, and where no registers are as narrow as [`SUMS`].
    pub(super) fn of(matrices: &Matrices) -> Option<Self> {
        let (nu, nx) = (matrices.u0.len(), matrices.nx());
        let small = (2..=LANES).contains(&nx) && (1..=MOST_INPUTS).contains(&nu);
        if FEW_LANES > SUMS || !small || !matrices.are_canonical() {
            return None;
        }
        let mut row = Self::NONE;
        let of_inputs = &matrices.closed_b[(nx - 1) * nu..];
        for (column, &value) in row.of_inputs.iter_mut().zip(of_inputs) {
            column.0[0] = value;
        }
        row.of_output[0].0[0] = matrices.gain[nx - 1];
        row.place = nx - 1;
        let [others @ .., own] = &matrices.closed_a[(nx - 1) * nx..] else {
            return None;
        };
        row.others.0[..row.place].copy_from_slice(others);
        row.own[row.place % SUMS] = *own;
        row.before.0[row.place - 1] = 1.0;
        Some(row)
    }

    /// The last of the elements of a state.
    #[inline(always)]
    pub(super) fn last_of(&self, elements: &[f64; LANES]) -> f64 {
        elements[self.place % LANES]
    }

    /// Puts it there.
    #[inline(always)]
    pub(super) fn put(&self, last: f64, elements: &mut [f64; LANES]) {
        elements[self.place % LANES] = last;
    }
}
