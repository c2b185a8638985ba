//! Square matrices of a few rows in flat arrays, for iterations that allocate nothing. What an
//! iteration does is inlined into it, so that it uses the registers that the iteration may use.

use nalgebra::DMatrix;

/// Columns that are summed side by side.
const LANES: usize = 8;

/// A square matrix row by row, each row filled up with zeros to whole chunks of [`LANES`] columns.
#[derive(Debug, Clone)]
pub(super) struct SmallSquare {
    size: usize,
    /// Chunks of a row.
    across: usize,
    values: Vec<[f64; LANES]>,
}

impl SmallSquare {
    pub(super) fn zeros(size: usize) -> Self {
        let across = size.div_ceil(LANES).max(1);
        Self {
            size,
            across,
            values: vec![[0.0; LANES]; size * across],
        }
    }

    pub(super) fn from_matrix(matrix: &DMatrix<f64>) -> Self {
        let mut made = Self::zeros(matrix.nrows());
        for (row, column) in made.places() {
            *made.at_mut(row, column) = matrix[(row, column)];
        }
        made
    }

    pub(super) fn to_matrix(&self) -> DMatrix<f64> {
        DMatrix::from_fn(self.size, self.size, |row, column| self.at(row, column))
    }

    fn at(&self, row: usize, column: usize) -> f64 {
        self.values[row * self.across + column / LANES][column % LANES]
    }

    fn at_mut(&mut self, row: usize, column: usize) -> &mut f64 {
        &mut self.values[row * self.across + column / LANES][column % LANES]
    }

    /// All pairs of a row and a column.
    fn places(&self) -> impl Iterator<Item = (usize, usize)> + use<> {
        let size = self.size;
        (0..size).flat_map(move |row| (0..size).map(move |column| (row, column)))
    }

    /// Becomes `left right`.
    #[inline(always)]
    pub(super) fn set_product(&mut self, left: &Self, right: &Self) {
        match self.across {
            1 => self.set_product_of::<1>(left, right),
            _ => self.set_product_of::<0>(left, right),
        }
    }

    /// With as many chunks a row, or any number where it is 0.
    #[inline(always)]
    fn set_product_of<const ACROSS: usize>(&mut self, left: &Self, right: &Self) {
        let across = if ACROSS > 0 { ACROSS } else { self.across };
        let rows = self.values.chunks_exact_mut(across);
        for (own, factors) in rows.zip(left.values.chunks_exact(across)) {
            for (chunk, own) in own.iter_mut().enumerate() {
                let mut sums = [0.0; LANES];
                let factors = factors.as_flattened().iter();
                for (factor, values) in factors.zip(right.values.chunks_exact(across)) {
                    for (sum, value) in sums.iter_mut().zip(&values[chunk]) {
                        *sum += factor * value;
                    }
                }
                *own = sums;
            }
        }
    }

    /// Becomes the transpose of `other`.
    #[inline(always)]
    pub(super) fn set_transpose(&mut self, other: &Self) {
        for (row, column) in other.places() {
            *self.at_mut(column, row) = other.at(row, column);
        }
    }

    /// Becomes the mean of itself and its transpose.
    #[inline(always)]
    pub(super) fn symmetrise(&mut self) {
        for row in 0..self.size {
            for column in row + 1..self.size {
                let mean = 0.5 * (self.at(row, column) + self.at(column, row));
                *self.at_mut(row, column) = mean;
                *self.at_mut(column, row) = mean;
            }
        }
    }

    #[inline(always)]
    pub(super) fn add(&mut self, other: &Self) {
        let own = self.values.as_flattened_mut().iter_mut();
        for (own, other) in own.zip(other.values.as_flattened()) {
            *own += other;
        }
    }

    #[inline(always)]
    pub(super) fn add_identity(&mut self) {
        for index in 0..self.size {
            *self.at_mut(index, index) += 1.0;
        }
    }

    /// Frobenius norm.
    #[inline(always)]
    pub(super) fn norm(&self) -> f64 {
        let mut sums = [0.0; LANES];
        for values in &self.values {
            for (sum, value) in sums.iter_mut().zip(values) {
                *sum += value * value;
            }
        }
        sums.iter().sum::<f64>().sqrt()
    }

    /// Solves `self X = right` for several right sides, which become the solutions, by elimination
    /// with the largest pivot of each column; what is left of `self` is of no use. `false` where a
    /// pivot is zero.
    #[inline(always)]
    pub(super) fn solve<const SIDES: usize>(&mut self, right: [&mut Self; SIDES]) -> bool {
        match self.across {
            1 => self.solve_of::<1, SIDES>(right),
            _ => self.solve_of::<0, SIDES>(right),
        }
    }

    /// With as many chunks a row, or any number where it is 0.
    #[inline(always)]
    fn solve_of<const ACROSS: usize, const SIDES: usize>(
        &mut self,
        mut right: [&mut Self; SIDES],
    ) -> bool {
        let across = if ACROSS > 0 { ACROSS } else { self.across };
        for column in 0..self.size {
            let larger = |best: usize, row: usize| {
                let further = self.at(row, column).abs() > self.at(best, column).abs();
                if further { row } else { best }
            };
            let best = (column + 1..self.size).fold(column, larger);
            let pivot = self.at(best, column);
            if pivot == 0.0 {
                return false;
            }
            self.swap_rows(column, best);
            for right in &mut right {
                right.swap_rows(column, best);
            }
            let inverse = pivot.recip();
            for row in column + 1..self.size {
                let factor = self.at(row, column) * inverse;
                subtract_row(&mut self.values, across, [column, row], factor);
                for right in &mut right {
                    subtract_row(&mut right.values, across, [column, row], factor);
                }
            }
        }
        for column in (0..self.size).rev() {
            let inverse = self.at(column, column).recip();
            for right in &mut right {
                right.scale_row(column, inverse);
                for row in 0..column {
                    let factor = self.at(row, column);
                    subtract_row(&mut right.values, across, [column, row], factor);
                }
            }
        }
        true
    }

    #[inline(always)]
    fn swap_rows(&mut self, left: usize, right: usize) {
        for chunk in 0..self.across {
            let (left, right) = (left * self.across, right * self.across);
            self.values.swap(left + chunk, right + chunk);
        }
    }

    #[inline(always)]
    fn scale_row(&mut self, row: usize, factor: f64) {
        let own = &mut self.values[row * self.across..(row + 1) * self.across];
        for value in own.as_flattened_mut() {
            *value *= factor;
        }
    }
}

/// Subtracts `factor` times the first of two rows from the second.
#[inline(always)]
fn subtract_row(values: &mut [[f64; LANES]], across: usize, rows: [usize; 2], factor: f64) {
    for chunk in 0..across {
        let subtracted = values[rows[0] * across + chunk];
        let own = &mut values[rows[1] * across + chunk];
        for (own, value) in own.iter_mut().zip(subtracted) {
            *own -= factor * value;
        }
    }
}
