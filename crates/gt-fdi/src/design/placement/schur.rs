//! A real Schur form whose diagonal blocks can change places.

use nalgebra::{Complex, DMatrix, Matrix2, Schur};

use super::PlacementError;

/// Iterations per eigenvalue after which the Schur form is given up; LAPACK allows 30.
const ITERATIONS_PER_EIGENVALUE: usize = 100;
/// What an exchange of two blocks may leave below the diagonal, in roundings of the largest entry
/// and row.
const EXCHANGE_ROUNDINGS: f64 = 1e3;

/// `A = Z T Z'` with `Z` orthogonal and `T` upper triangular but for blocks of order 2.
pub(super) struct RealSchur {
    pub(super) t: DMatrix<f64>,
    pub(super) z: DMatrix<f64>,
}

/// A diagonal block: its first row and its order, 1 or 2.
#[derive(Clone, Copy, PartialEq)]
pub(super) struct Block {
    pub(super) start: usize,
    pub(super) order: usize,
}

impl Block {
    pub(super) fn end(self) -> usize {
        self.start + self.order
    }
}

impl RealSchur {
    /// Every block of order 2 has complex eigenvalues.
    pub(super) fn new(a: &DMatrix<f64>) -> Result<Self, PlacementError> {
        let order = a.nrows();
        let largest = a.amax();
        if largest == 0.0 || order == 0 {
            return Ok(Self {
                t: DMatrix::zeros(order, order),
                z: DMatrix::identity(order, order),
            });
        }
        // With a largest entry of 1 the decomposition's own scaling is exact.
        let scaled = a / largest;
        let schur = Schur::try_new(scaled, f64::EPSILON, ITERATIONS_PER_EIGENVALUE * order)
            .ok_or(PlacementError::Schur { order })?;
        let (z, t) = schur.unpack();
        let mut schur = Self { t: t * largest, z };
        if !schur.t.iter().all(|value| value.is_finite()) {
            return Err(PlacementError::Schur { order });
        }
        schur.clean();
        Ok(schur)
    }

    /// Sets what is zero to working accuracy to zero and splits blocks with real eigenvalues.
    fn clean(&mut self) {
        let order = self.t.nrows();
        for column in 0..order {
            for row in column + 2..order {
                self.t[(row, column)] = 0.0;
            }
        }
        for row in 1..order {
            let beside = self.t[(row, row)].abs() + self.t[(row - 1, row - 1)].abs();
            if self.t[(row, row - 1)].abs() <= f64::EPSILON * beside {
                self.t[(row, row - 1)] = 0.0;
            }
        }
        for row in 1..order {
            if self.t[(row, row - 1)] != 0.0 {
                self.split(row - 1);
            }
        }
    }

    /// Makes the block of order 2 that begins at `start` triangular if its eigenvalues are real.
    pub(super) fn split(&mut self, start: usize) {
        let block = self.two(start);
        let half = (block[(0, 0)] - block[(1, 1)]) / 2.0;
        let discriminant = half * half + block[(0, 1)] * block[(1, 0)];
        if block[(1, 0)] == 0.0 || discriminant < 0.0 {
            return;
        }
        // The eigenvector of the eigenvalue further from the second diagonal entry.
        let x = half + discriminant.sqrt().copysign(half);
        let length = x.hypot(block[(1, 0)]);
        let (c, s) = (x / length, block[(1, 0)] / length);
        let rotation = DMatrix::from_row_slice(2, 2, &[c, -s, s, c]);
        self.rotate(start, &rotation);
        self.t[(start + 1, start)] = 0.0;
    }

    /// The block of order 2 that begins at `start`, triangular or not.
    pub(super) fn two(&self, start: usize) -> Matrix2<f64> {
        self.t.fixed_view::<2, 2>(start, start).into_owned()
    }

    /// The blocks from the row `from` up to the row `to`.
    pub(super) fn blocks(&self, from: usize, to: usize) -> Vec<Block> {
        let mut blocks = Vec::new();
        let mut start = from;
        while start < to {
            let order = if start + 1 < to && self.t[(start + 1, start)] != 0.0 {
                2
            } else {
                1
            };
            blocks.push(Block { start, order });
            start += order;
        }
        blocks
    }

    /// The eigenvalues of a block, that with the positive imaginary part first.
    pub(super) fn eigenvalues(&self, block: Block) -> Vec<Complex<f64>> {
        if block.order == 1 {
            return vec![Complex::new(self.t[(block.start, block.start)], 0.0)];
        }
        let two = self.two(block.start);
        let half = (two[(0, 0)] - two[(1, 1)]) / 2.0;
        let root = Complex::new(half * half + two[(0, 1)] * two[(1, 0)], 0.0).sqrt();
        let middle = f64::midpoint(two[(0, 0)], two[(1, 1)]);
        vec![root + middle, -root + middle]
    }

    /// Moves a block up to the row `to`, which begins a block.
    pub(super) fn move_up(&mut self, block: Block, to: usize) -> Result<(), PlacementError> {
        for other in self.blocks(to, block.start).into_iter().rev() {
            self.exchange(other, block.order)?;
        }
        Ok(())
    }

    /// Moves a block down until it ends at the row `to`, where a block ends.
    pub(super) fn move_down(&mut self, block: Block, to: usize) -> Result<(), PlacementError> {
        let mut moved = block;
        for other in self.blocks(block.end(), to) {
            self.exchange(moved, other.order)?;
            moved.start += other.order;
        }
        Ok(())
    }

    /// Exchanges a block with the one below it, of order `below`: with `T11 Y - Y T22 = -T12` the
    /// columns of `[Y; I]` span what belongs to the eigenvalues of the lower one
    /// (Z. Bai, J. W. Demmel, Linear Algebra and its Applications 186, 1993).
    fn exchange(&mut self, upper: Block, below: usize) -> Result<(), PlacementError> {
        let (start, above) = (upper.start, upper.order);
        let order = self.t.nrows();
        let both = above + below;
        let block = self.t.view((start, start), (both, both)).into_owned();
        let mut system = DMatrix::zeros(above * below, above * below);
        let mut right = nalgebra::DVector::zeros(above * below);
        for j in 0..below {
            for i in 0..above {
                let row = j * above + i;
                for k in 0..above {
                    system[(row, j * above + k)] += block[(i, k)];
                }
                for k in 0..below {
                    system[(row, k * above + i)] -= block[(above + k, above + j)];
                }
                right[row] = -block[(i, above + j)];
            }
        }
        let Some(y) = system.lu().solve(&right) else {
            // Equal eigenvalues: in whatever order they stand, it is the same.
            return if above == below {
                Ok(())
            } else {
                Err(PlacementError::Schur { order })
            };
        };
        let mut basis = DMatrix::zeros(both, both);
        for j in 0..below {
            basis
                .view_mut((0, j), (above, 1))
                .copy_from(&y.rows(j * above, above));
            basis[(above + j, j)] = 1.0;
        }
        for i in 0..above {
            basis[(i, below + i)] = 1.0;
        }
        self.rotate(start, &basis.qr().q());
        let mut left = self.t.view_mut((start + below, start), (above, below));
        let residue = left.amax();
        left.fill(0.0);
        let allowed = EXCHANGE_ROUNDINGS * f64::EPSILON * block.amax();
        if residue <= allowed {
            Ok(())
        } else {
            Err(PlacementError::Schur { order })
        }
    }

    /// `T = Q' T Q`, `Z = Z Q` with an orthogonal Q that acts on the rows from `start` on.
    fn rotate(&mut self, start: usize, q: &DMatrix<f64>) {
        let (order, size) = (self.t.nrows(), q.nrows());
        let rows = q.transpose() * self.t.rows(start, size);
        self.t.rows_mut(start, size).copy_from(&rows);
        let columns = self.t.columns(start, size) * q;
        self.t.columns_mut(start, size).copy_from(&columns);
        let columns = self.z.view((0, start), (order, size)) * q;
        self.z.columns_mut(start, size).copy_from(&columns);
    }
}
