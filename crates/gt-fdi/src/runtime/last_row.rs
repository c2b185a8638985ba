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

#[cfg(test)]
mod tests {
    use super::*;

    /// `A - K C` of three states in canonical form, one input.
    fn matrices() -> Matrices {
        Matrices {
            a: vec![0.0; 9],
            b: vec![1.0, 2.0, 3.0],
            closed_a: vec![0.1, 1.0, 0.0, 0.2, 0.0, 1.0, 0.3, 0.4, 0.5],
            closed_b: vec![1.0, 2.0, 3.0],
            gain: vec![4.0, 5.0, 6.0],
            c: vec![1.0, 0.0, 0.0],
            d: vec![0.0],
            u0: vec![0.0],
            y0: vec![0.0],
            predicts: true,
        }
    }

    #[test]
    fn the_last_row_of_a_canonical_form_is_found() {
        let lanes = |values: &[f64]| {
            Lanes(core::array::from_fn(|lane| {
                values.get(lane).copied().unwrap_or_default()
            }))
        };
        let none = Lanes::ZERO;
        let expected = LastRow {
            of_inputs: [lanes(&[3.0]), none, none, none],
            of_output: [lanes(&[6.0])],
            others: lanes(&[0.3, 0.4]),
            own: [0.0, 0.0, 0.5, 0.0],
            before: lanes(&[0.0, 1.0]),
            place: 2,
        };
        let mut elements = [7.0; LANES];
        expected.put(8.0, &mut elements);
        assert_eq!(elements.map(f64::to_bits)[2], 8.0_f64.to_bits());
        assert_eq!(expected.last_of(&elements).to_bits(), 8.0_f64.to_bits());
        let narrow = FEW_LANES <= SUMS;
        assert_eq!(LastRow::of(&matrices()), narrow.then_some(expected));
    }

    #[test]
    fn another_form_has_none() {
        let mut other = matrices();
        other.closed_a[1] = 1.0 + f64::EPSILON;
        assert_eq!(LastRow::of(&other), None);
        let mut other = matrices();
        other.c[2] = 0.1;
        assert_eq!(LastRow::of(&other), None);
    }
}
