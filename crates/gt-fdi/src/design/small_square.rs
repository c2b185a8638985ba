//! Square matrices of a few rows in flat arrays, which allocate nothing for up to eight. What an
//! iteration does is inlined into it, so that it uses the registers that the iteration may use.

use nalgebra::DMatrix;

use crate::runtime::lanes::{LANES, Lanes};
use crate::runtime::wide::{Simd, Wide, Work, registers, registers_mut};

/// Rows of [`LANES`] columns, as many rows.
type Block = [Lanes; LANES];

/// A square matrix in blocks, those of the first rows first, filled up with zeros. Products and sums
/// are rounded once.
#[derive(Debug, Clone)]
pub(super) struct SmallSquare {
    size: usize,
    /// Blocks of a row.
    across: usize,
    /// The only block, which takes no allocation.
    only: Block,
    /// The blocks, where there are several.
    several: Vec<Block>,
}

impl SmallSquare {
    pub(super) fn zeros(size: usize) -> Self {
        let across = size.div_ceil(LANES).max(1);
        let several = if across > 1 { across * across } else { 0 };
        Self {
            size,
            across,
            only: [Lanes::ZERO; LANES],
            several: vec![[Lanes::ZERO; LANES]; several],
        }
    }

    #[inline(always)]
    fn blocks(&self) -> &[Block] {
        match self.across {
            1 => std::slice::from_ref(&self.only),
            _ => &self.several,
        }
    }

    #[inline(always)]
    fn blocks_mut(&mut self) -> &mut [Block] {
        match self.across {
            1 => std::slice::from_mut(&mut self.only),
            _ => &mut self.several,
        }
    }

    pub(super) fn from_matrix(matrix: &DMatrix<f64>) -> Self {
        let mut made = Self::zeros(matrix.nrows());
        let (size, across) = (made.size, made.across);
        for (index, own) in made.blocks_mut().iter_mut().enumerate() {
            let (row, column) = (index / across * LANES, index % across * LANES);
            let mut columns = [Lanes::ZERO; LANES];
            let values = matrix.as_slice().chunks(size.max(1)).skip(column);
            for (own, values) in columns.iter_mut().zip(values) {
                for (own, value) in own.0.iter_mut().zip(&values[row..]) {
                    *own = *value;
                }
            }
            *own = transposed(&columns);
        }
        made
    }

    pub(super) fn to_matrix(&self) -> DMatrix<f64> {
        let blocks = self.blocks();
        DMatrix::from_fn(self.size, self.size, |row, column| {
            let block = row / LANES * self.across + column / LANES;
            blocks[block][row % LANES].0[column % LANES]
        })
    }

    /// Of a matrix of `ACROSS` blocks a row, or any number where it is 0.
    #[inline(always)]
    fn at<const ACROSS: usize>(&self, row: usize, column: usize) -> f64 {
        let index = row / LANES * self.across + column / LANES;
        let block = if ACROSS == 1 {
            &self.only
        } else {
            &self.several[index]
        };
        block[row % LANES].0[column % LANES]
    }

    /// A row of the blocks in a column of blocks, likewise.
    #[inline(always)]
    fn row_mut<const ACROSS: usize>(&mut self, row: usize, block: usize) -> &mut Lanes {
        let index = row / LANES * self.across + block;
        let block = if ACROSS == 1 {
            &mut self.only
        } else {
            &mut self.several[index]
        };
        &mut block[row % LANES]
    }

    /// Becomes `left right`.
    #[inline(always)]
    pub(super) fn set_product<S: Simd>(&mut self, simd: S, left: &Self, right: &Self) {
        let across = self.across;
        for (index, own) in self.blocks_mut().iter_mut().enumerate() {
            *own = [Lanes::ZERO; LANES];
            for between in 0..across {
                let left = &left.blocks()[index / across * across + between];
                let right = &right.blocks()[between * across + index % across];
                add_product(simd, own, left, right);
            }
        }
    }

    /// Becomes the transpose of `other`.
    #[inline(always)]
    pub(super) fn set_transpose(&mut self, other: &Self) {
        let across = self.across;
        for (index, own) in self.blocks_mut().iter_mut().enumerate() {
            *own = transposed(&other.blocks()[index % across * across + index / across]);
        }
    }

    /// Becomes the mean of itself and its transpose.
    #[inline(always)]
    pub(super) fn symmetrise(&mut self) {
        let across = self.across;
        let blocks = self.blocks_mut();
        for row in 0..across {
            for column in row..across {
                let (upper, lower) = (row * across + column, column * across + row);
                let other = transposed(&blocks[lower]);
                for (own, other) in blocks[upper].iter_mut().zip(&other) {
                    for (own, other) in own.0.iter_mut().zip(&other.0) {
                        *own = 0.5 * (*own + other);
                    }
                }
                if row != column {
                    blocks[lower] = transposed(&blocks[upper]);
                }
            }
        }
    }

    #[inline(always)]
    pub(super) fn add(&mut self, other: &Self) {
        let own = self.blocks_mut().as_flattened_mut().iter_mut();
        for (own, other) in own.zip(other.blocks().as_flattened()) {
            for (own, other) in own.0.iter_mut().zip(&other.0) {
                *own += other;
            }
        }
    }

    #[inline(always)]
    pub(super) fn subtract(&mut self, other: &Self) {
        let own = self.blocks_mut().as_flattened_mut().iter_mut();
        for (own, other) in own.zip(other.blocks().as_flattened()) {
            for (own, other) in own.0.iter_mut().zip(&other.0) {
                *own -= other;
            }
        }
    }

    #[inline(always)]
    pub(super) fn add_identity(&mut self) {
        let (size, across) = (self.size, self.across);
        let blocks = self.blocks_mut();
        for index in 0..size {
            let block = index / LANES * (across + 1);
            blocks[block][index % LANES].0[index % LANES] += 1.0;
        }
    }

    /// Frobenius norm.
    #[inline(always)]
    pub(super) fn norm(&self) -> f64 {
        let mut sums = [0.0; LANES];
        for values in self.blocks().as_flattened() {
            for (sum, value) in sums.iter_mut().zip(&values.0) {
                *sum += value * value;
            }
        }
        sums.iter().sum::<f64>().sqrt()
    }

    /// Solves `self X = right` for several right sides, which become the solutions, by elimination
    /// with the largest pivot of each column; what is left of `self` is of no use. `false` where a
    /// pivot is zero.
    #[inline(always)]
    pub(super) fn solve<S: Simd, const SIDES: usize>(
        &mut self,
        simd: S,
        right: [&mut Self; SIDES],
    ) -> bool {
        match self.across {
            1 => self.solve_of::<S, 1, SIDES>(simd, right),
            _ => self.solve_of::<S, 0, SIDES>(simd, right),
        }
    }

    /// With as many blocks a row, or any number where it is 0.
    #[inline(always)]
    fn solve_of<S: Simd, const ACROSS: usize, const SIDES: usize>(
        &mut self,
        simd: S,
        mut right: [&mut Self; SIDES],
    ) -> bool {
        let across = if ACROSS > 0 { ACROSS } else { self.across };
        for column in 0..self.size {
            let larger = |best: usize, row: usize| {
                let further =
                    self.at::<ACROSS>(row, column).abs() > self.at::<ACROSS>(best, column).abs();
                if further { row } else { best }
            };
            let best = (column + 1..self.size).fold(column, larger);
            let pivot = self.at::<ACROSS>(best, column);
            if pivot == 0.0 {
                return false;
            }
            if best != column {
                self.swap_rows::<ACROSS>(across, column, best);
                for right in &mut right {
                    right.swap_rows::<ACROSS>(across, column, best);
                }
            }
            let inverse = pivot.recip();
            for row in column + 1..self.size {
                let factor = self.at::<ACROSS>(row, column) * inverse;
                self.subtract_row::<S, ACROSS>(simd, across, [column, row], factor);
                for right in &mut right {
                    right.subtract_row::<S, ACROSS>(simd, across, [column, row], factor);
                }
            }
        }
        for column in (0..self.size).rev() {
            let inverse = self.at::<ACROSS>(column, column).recip();
            for right in &mut right {
                for block in 0..across {
                    for value in &mut right.row_mut::<ACROSS>(column, block).0 {
                        *value *= inverse;
                    }
                }
                for row in 0..column {
                    right.subtract_row::<S, ACROSS>(
                        simd,
                        across,
                        [column, row],
                        self.at::<ACROSS>(row, column),
                    );
                }
            }
        }
        true
    }

    #[inline(always)]
    fn swap_rows<const ACROSS: usize>(&mut self, across: usize, left: usize, right: usize) {
        for block in 0..across {
            let own = *self.row_mut::<ACROSS>(left, block);
            *self.row_mut::<ACROSS>(left, block) = *self.row_mut::<ACROSS>(right, block);
            *self.row_mut::<ACROSS>(right, block) = own;
        }
    }

    /// Subtracts `factor` times the first of two rows from the second.
    #[inline(always)]
    fn subtract_row<S: Simd, const ACROSS: usize>(
        &mut self,
        simd: S,
        across: usize,
        rows: [usize; 2],
        factor: f64,
    ) {
        let factor = simd.splat_f64s(-factor);
        for block in 0..across {
            let subtracted = *self.row_mut::<ACROSS>(rows[0], block);
            let own = registers_mut::<S>(&mut self.row_mut::<ACROSS>(rows[1], block).0);
            for (own, &value) in own.iter_mut().zip(registers::<S>(&subtracted.0)) {
                *own = simd.mul_add_f64s(factor, value, *own);
            }
        }
    }
}

/// `F P F'`.
pub(super) fn congruence(f: &DMatrix<f64>, p: &SmallSquare) -> SmallSquare {
    let mut product = p.clone();
    let (f, between) = (SmallSquare::from_matrix(f), p.clone());
    Wide::new().run(Congruence {
        f,
        p,
        between,
        product: &mut product,
    });
    product
}

struct Congruence<'a> {
    f: SmallSquare,
    p: &'a SmallSquare,
    between: SmallSquare,
    product: &'a mut SmallSquare,
}

impl Work for Congruence<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(mut self, simd: S) {
        self.between.set_product(simd, &self.f, self.p);
        let mut transposed = self.f.clone();
        transposed.set_transpose(&self.f);
        self.product.set_product(simd, &self.between, &transposed);
    }
}

/// Adds `left right`.
#[inline(always)]
fn add_product<S: Simd>(simd: S, sum: &mut Block, left: &Block, right: &Block) {
    for (sum, factors) in sum.iter_mut().zip(left) {
        for (register, sum) in registers_mut::<S>(&mut sum.0).iter_mut().enumerate() {
            let mut own = *sum;
            for (&factor, values) in factors.0.iter().zip(right) {
                let values = registers::<S>(&values.0)[register];
                own = simd.mul_add_f64s(simd.splat_f64s(factor), values, own);
            }
            *sum = own;
        }
    }
}

#[inline(always)]
fn transposed(block: &Block) -> Block {
    let mut transposed = [Lanes::ZERO; LANES];
    for (row, values) in block.iter().enumerate() {
        for (value, other) in values.0.iter().zip(&mut transposed) {
            other.0[row] = *value;
        }
    }
    transposed
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Numbers in -0.5 .. 0.5.
    fn random(size: usize, seed: u64) -> DMatrix<f64> {
        let mut state = seed;
        DMatrix::from_fn(size, size, |_, _| {
            state = state
                .wrapping_mul(6364136223846793005)
                .wrapping_add(1442695040888963407);
            (state >> 11) as f64 / (1_u64 << 53) as f64 - 0.5
        })
    }

    struct Solve<'a>(&'a mut SmallSquare, &'a mut SmallSquare);

    impl Work for Solve<'_> {
        type Output = bool;

        #[inline(always)]
        fn with_simd<S: Simd>(self, simd: S) -> bool {
            self.0.solve(simd, [self.1])
        }
    }

    /// In one block and in several, whole and not; sums of up to 17 products of numbers below 1.
    #[test]
    fn results_are_those_of_nalgebra() {
        for size in [0, 1, 2, 7, 8, 9, 16, 17] {
            let (left, right) = (random(size, 1), random(size, 2));
            let small = SmallSquare::from_matrix(&right);
            let found = congruence(&left, &small).to_matrix();
            let expected = &left * &right * left.transpose();
            assert!((&found - &expected).amax() < 1e-14, "{size}");
            // Zeros that fill up stay zeros.
            let norm = congruence(&left, &small).norm();
            assert!((norm - expected.norm()).abs() < 1e-14, "{size}");

            let mut symmetric = small.clone();
            symmetric.symmetrise();
            let expected = 0.5 * (&right + right.transpose());
            assert!(symmetric.to_matrix() == expected, "{size}");
            symmetric.subtract(&small);
            symmetric.add_identity();
            symmetric.add(&small);
            let identity = DMatrix::identity(size, size);
            assert!((symmetric.to_matrix() - (expected + identity)).amax() < 1e-15);

            // With small diagonals, so that rows change places.
            let mut matrix = random(size, 3);
            matrix.fill_diagonal(1e-3);
            let mut solution = small.clone();
            let done =
                Wide::new().run(Solve(&mut SmallSquare::from_matrix(&matrix), &mut solution));
            assert!(done || size == 0, "{size}");
            let left = &matrix * solution.to_matrix() - &right;
            assert!(left.amax() < 1e-10, "{size}: {:e}", left.amax());
        }
        let mut singular = SmallSquare::zeros(3);
        let mut right = SmallSquare::from_matrix(&random(3, 1));
        assert!(!Wide::new().run(Solve(&mut singular, &mut right)));
    }
}
