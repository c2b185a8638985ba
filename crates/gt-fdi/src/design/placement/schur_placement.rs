//! Pole placement for several outputs.

use gt_core::{DimensionError, StateSpace};
use nalgebra::{Complex, DMatrix};

use super::PlacementError;
use super::assignment::Pool;
use super::least_norm::{one, sum_and_product, two};
use super::placed_poles::pair;
use super::schur::{Block, RealSchur};
use crate::FdiError;

/// Which eigenvalues stay where they are.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum StabilityBound {
    /// Those with a modulus below this radius (discrete time); none at 0.
    Modulus(f64),
    /// Those with a real part below this number (continuous time).
    RealPart(f64),
}

impl StabilityBound {
    fn check(self) -> Result<(), PlacementError> {
        let (expected, found, fits) = match self {
            Self::Modulus(found) => ("a radius not below 0", found, found >= 0.0),
            Self::RealPart(found) => ("a real part", found, !found.is_nan()),
        };
        if fits {
            Ok(())
        } else {
            Err(PlacementError::Bound { expected, found })
        }
    }

    fn holds(self, eigenvalue: Complex<f64>) -> bool {
        match self {
            Self::Modulus(radius) => eigenvalue.norm() < radius,
            Self::RealPart(limit) => eigenvalue.re < limit,
        }
    }
}

/// A gain that leaves the eigenvalues inside a bound alone and moves the others.
///
/// With several outputs the poles do not determine an observer's gain (nx ny numbers for nx
/// poles), so a rule has to: A. Varga, *A Schur method for pole assignment*, IEEE Transactions on
/// Automatic Control 26 (1981), 517-519, as follows.
///
/// 1. The real Schur form is ordered so that the eigenvalues inside the bound come first, the
///    others behind them in the order in which the decomposition finds them.
/// 2. Of the list of poles as many of the first are used as eigenvalues lie outside the bound.
/// 3. The last block is moved by the feedback of least Frobenius norm that does it: a real
///    eigenvalue to the nearest real pole, a complex pair to the nearest pair or, when none is
///    left, to the two nearest real poles. When no real pole is left for a real eigenvalue, it and
///    the real one before it are moved together to the pair nearest to their mean. The first in
///    the list is the nearest of equally near ones.
/// 4. The block goes up behind those that are done, and the next is the last.
///
/// The same input gives the same gain. The norm is least in each step, not as a whole, and units
/// of the states and outputs matter to it.
#[derive(Debug, Clone, PartialEq)]
pub struct SchurPlacement {
    /// `F (m x n)` of [`SchurPlacement::feedback`], `K (nx x ny)` of [`SchurPlacement::observer`].
    pub gain: DMatrix<f64>,
    /// The poles that were placed, in the order in which they were, pairs side by side.
    pub assigned: Vec<Complex<f64>>,
    /// The eigenvalues that stay.
    pub kept: Vec<Complex<f64>>,
}

impl SchurPlacement {
    /// `F (m x n)` such that `A + B F` has `poles` in place of those eigenvalues of `A (n x n)`
    /// that are outside `bound`; `B (n x m)`.
    ///
    /// # Errors
    /// [`FdiError::Dimension`] for sizes that disagree; [`PlacementError`] when an entry or a pole
    /// is not finite, a pole has no conjugate, there are too few poles, or an eigenvalue outside
    /// the bound is not reached from B by more than `n eps max(|A|, |B|)` (1-norms).
    pub fn feedback(
        a: &DMatrix<f64>,
        b: &DMatrix<f64>,
        bound: StabilityBound,
        poles: &[Complex<f64>],
    ) -> Result<Self, FdiError> {
        DimensionError::check("columns of A", a.nrows(), a.ncols())?;
        DimensionError::check("rows of B", a.nrows(), b.nrows())?;
        for (matrix, values) in [("A", a), ("B", b)] {
            if let Some(index) = values.iter().position(|value| !value.is_finite()) {
                let (row, column) = values.vector_to_matrix_index(index);
                let found = values[index];
                return Err(PlacementError::Entry {
                    matrix,
                    row,
                    column,
                    found,
                }
                .into());
            }
        }
        bound.check()?;
        pair(poles)?;
        Ok(Assignment::new(a, b, bound)?.run(poles)?)
    }

    /// `K (nx x ny)` such that `A - K C` of the model has `poles` in place of those eigenvalues of
    /// A whose modulus is not below `radius`: all of them for a radius of 0. This is the feedback
    /// of `A'` and `C'` with its sign changed; for one output and a radius of 0 it is the
    /// gain of [`place_complex`](super::super::place_complex).
    ///
    /// # Errors
    /// As [`SchurPlacement::feedback`]; [`FdiError::Option`] for a radius outside `[0, 1]`,
    /// [`FdiError::PoleOutside`] for a pole that is not inside the unit circle.
    pub fn observer(
        model: &StateSpace,
        radius: f64,
        poles: &[Complex<f64>],
    ) -> Result<Self, FdiError> {
        if !(0.0..=1.0).contains(&radius) {
            return Err(FdiError::Option {
                option: "radius",
                expected: "a radius from 0 to 1",
                found: radius,
            });
        }
        for (index, pole) in poles.iter().enumerate() {
            let found = pole.norm();
            if found.is_nan() || found >= 1.0 {
                return Err(FdiError::PoleOutside { index, found });
            }
        }
        let (a, b) = (model.a().transpose(), model.c().transpose());
        let dual = Self::feedback(&a, &b, StabilityBound::Modulus(radius), poles)?;
        Ok(Self {
            gain: -dual.gain.transpose(),
            ..dual
        })
    }
}

/// A placement under way: rows before `low` are done, the others are to be moved.
struct Assignment {
    schur: RealSchur,
    /// `Z' B (n x m)`.
    g: DMatrix<f64>,
    b: DMatrix<f64>,
    /// `F (m x n)` so far.
    feedback: DMatrix<f64>,
    low: usize,
    /// Reach below which an eigenvalue counts as fixed.
    limit: f64,
    kept: Vec<Complex<f64>>,
}

impl Assignment {
    fn new(
        a: &DMatrix<f64>,
        b: &DMatrix<f64>,
        bound: StabilityBound,
    ) -> Result<Self, PlacementError> {
        let n = a.nrows();
        let mut schur = RealSchur::new(a)?;
        let (mut low, mut kept) = (0, Vec::new());
        for block in schur.blocks(0, n) {
            let eigenvalues = schur.eigenvalues(block);
            if bound.holds(eigenvalues[0]) {
                schur.move_up(block, low)?;
                low += block.order;
                kept.extend(eigenvalues);
            }
        }
        let limit = n as f64 * f64::EPSILON * one_norm(a).max(one_norm(b));
        Ok(Self {
            g: schur.z.transpose() * b,
            schur,
            b: b.clone(),
            feedback: DMatrix::zeros(b.ncols(), n),
            low,
            limit,
            kept,
        })
    }

    fn run(mut self, poles: &[Complex<f64>]) -> Result<SchurPlacement, PlacementError> {
        let n = self.schur.t.nrows();
        let mut pool = Pool::new(poles, n - self.low)?;
        let mut assigned = Vec::with_capacity(n - self.low);
        while let Some(&last) = self.schur.blocks(self.low, n).last() {
            let eigenvalue = self.schur.eigenvalues(last)[0];
            let real = if last.order == 1 {
                pool.real(eigenvalue.re)
            } else {
                None
            };
            let block = if let Some(pole) = real {
                self.check_reach(last)?;
                assigned.push(Complex::new(pole, 0.0));
                let f = one(
                    eigenvalue.re,
                    &self.g.rows(last.start, 1).into_owned(),
                    pole,
                );
                self.apply(last, &f);
                last
            } else {
                let (block, near) = self.pair_up(last)?;
                // As many poles are left as eigenvalues, so there are two.
                let order = n;
                let placed = pool.two(near).ok_or(PlacementError::Schur { order })?;
                assigned.extend(placed);
                let (sum, product) = sum_and_product(placed);
                let g = self.g.rows(block.start, 2).into_owned();
                let f = two(&self.schur.two(block.start), &g, sum, product, self.limit);
                let f = f.ok_or(PlacementError::Fixed {
                    found: near,
                    reach: 0.0,
                    limit: self.limit,
                })?;
                self.apply(block, &f);
                block
            };
            if block.order == 2 {
                self.schur.split(block.start);
            }
            for done in self.schur.blocks(block.start, block.end()) {
                self.schur.move_up(done, self.low)?;
                self.low += done.order;
            }
            self.g = self.schur.z.transpose() * &self.b;
        }
        Ok(SchurPlacement {
            gain: self.feedback,
            assigned,
            kept: self.kept,
        })
    }

    /// The last block, or the last two real ones side by side, with the point that a pair should
    /// be near.
    fn pair_up(&mut self, last: Block) -> Result<(Block, Complex<f64>), PlacementError> {
        self.check_reach(last)?;
        let eigenvalue = self.schur.eigenvalues(last)[0];
        if last.order == 2 {
            return Ok((last, eigenvalue));
        }
        let order = self.schur.t.nrows();
        let before = self.schur.blocks(self.low, last.start);
        let single = before.into_iter().rev().find(|block| block.order == 1);
        let single = single.ok_or(PlacementError::Schur { order })?;
        self.schur.move_down(single, last.start)?;
        self.g = self.schur.z.transpose() * &self.b;
        let block = Block {
            start: last.start - 1,
            order: 2,
        };
        let two = self.schur.two(block.start);
        Ok((block, Complex::new(two.trace() / 2.0, 0.0)))
    }

    /// Refuses to move the last block when no input reaches it.
    fn check_reach(&self, last: Block) -> Result<(), PlacementError> {
        let reach = self.g.rows(last.start, last.order).norm();
        if reach > self.limit {
            return Ok(());
        }
        Err(PlacementError::Fixed {
            found: self.schur.eigenvalues(last)[0],
            reach,
            limit: self.limit,
        })
    }

    /// Adds a feedback from the states of a block.
    fn apply(&mut self, block: Block, f: &DMatrix<f64>) {
        let columns = &self.g * f;
        let mut of_block = self.schur.t.columns_mut(block.start, block.order);
        of_block += columns;
        let directions = self.schur.z.columns(block.start, block.order);
        self.feedback += f * directions.transpose();
    }
}

/// Largest sum of moduli in a column.
fn one_norm(matrix: &DMatrix<f64>) -> f64 {
    let sums = matrix.column_iter().map(|column| column.lp_norm(1));
    sums.fold(0.0, f64::max)
}
