//! The canonical form of any observable state-space model.

use gt_core::StateSpace;
use nalgebra::{DMatrix, DVector, RowDVector};

use crate::least_squares::LeastSquares;
use crate::structure::shared_index;
use crate::{CanonicalForm, IdentError};

/// A row of unit length counts as dependent on others when its distance from their span is at most
/// this.
pub const RANK_TOLERANCE: f64 = 1e-10;

/// A state-space model brought to canonical form, and how sure its indices are.
///
/// The indices are a rank decision: where `largest_rejected` is not far below `smallest_accepted`,
/// a small change of the model gives other indices.
#[derive(Debug, Clone, PartialEq)]
pub struct Similarity {
    /// The canonical form.
    pub form: CanonicalForm,
    /// `T (nx x nx)`: canonical state = `T` times the model's state; its rows are `c_i A^k`.
    pub transformation: DMatrix<f64>,
    /// The smallest distance of an accepted row `c_i A^k` (unit length) from those before it.
    pub smallest_accepted: f64,
    /// The largest distance of a rejected row; 0 where none had to be rejected.
    pub largest_rejected: f64,
}

impl Similarity {
    /// Brings an observable model to canonical form.
    ///
    /// The rows `c_1, .., c_m, c_1 A, .., c_m A, ..` are taken in this order; a chain ends at its
    /// first row that depends on those before it (distance at most [`RANK_TOLERANCE`], unit rows),
    /// which gives the indices `v_i`. `T = [c_i A^k]`, output by output, then gives
    /// `(T A T^-1, T B, C T^-1)` in canonical form.
    ///
    /// # Errors
    /// [`IdentError::NotObservable`] when fewer than `nx` rows are independent,
    /// [`IdentError::IndexZero`] when an output depends on those before it at the same instant.
    pub fn new(model: &StateSpace) -> Result<Self, IdentError> {
        let (nx, ny) = (model.nx(), model.ny());
        if ny == 0 {
            return Err(IdentError::NoOutputs);
        }
        let mut chains: Vec<Chain> = (0..ny)
            .map(|output| Chain::start(model.c().row(output).into_owned()))
            .collect();
        let mut basis: Vec<DVector<f64>> = Vec::with_capacity(nx);
        let (mut smallest_accepted, mut largest_rejected) = (f64::INFINITY, 0.0_f64);
        while basis.len() < nx && chains.iter().any(|chain| !chain.closed) {
            for chain in chains.iter_mut().filter(|chain| !chain.closed) {
                let (distance, direction) = distance(&chain.next, &basis);
                if basis.len() < nx && distance > RANK_TOLERANCE {
                    smallest_accepted = smallest_accepted.min(distance);
                    basis.push(direction);
                    chain.accept(model.a());
                } else {
                    if basis.len() < nx {
                        largest_rejected = largest_rejected.max(distance);
                    }
                    chain.closed = true;
                }
            }
        }
        if basis.len() < nx {
            return Err(IdentError::NotObservable {
                expected: nx,
                found: basis.len(),
            });
        }
        let indices: Vec<usize> = chains.iter().map(|chain| chain.rows.len()).collect();
        if let Some(output) = indices.iter().position(|&index| index == 0) {
            return Err(IdentError::IndexZero { output });
        }
        let alpha = (0..ny)
            .map(|i| coefficients(&chains, &indices, i))
            .collect();
        let rows: Vec<RowDVector<f64>> = chains
            .iter()
            .flat_map(|chain| chain.rows.iter().map(|(row, scale)| row * *scale))
            .collect();
        let transformation = DMatrix::from_rows(&rows);
        let beta = indices
            .iter()
            .map(|&index| vec![vec![0.0; model.nu()]; index])
            .collect();
        let outputs_only = CanonicalForm::new(indices, alpha, beta)?;
        let form = outputs_only.with_inputs(&(&transformation * model.b()), model.d())?;
        Ok(Self {
            form,
            transformation,
            smallest_accepted,
            largest_rejected,
        })
    }
}

/// The rows `c A^k` of one output, each of unit length with its scale apart.
struct Chain {
    rows: Vec<(RowDVector<f64>, f64)>,
    next: RowDVector<f64>,
    next_scale: f64,
    closed: bool,
}

impl Chain {
    fn start(row: RowDVector<f64>) -> Self {
        let mut chain = Self {
            rows: Vec::new(),
            next: row,
            next_scale: 1.0,
            closed: false,
        };
        chain.normalise();
        chain
    }

    fn accept(&mut self, a: &DMatrix<f64>) {
        let next = &self.next * a;
        let row = std::mem::replace(&mut self.next, next);
        self.rows.push((row, self.next_scale));
        self.normalise();
    }

    fn normalise(&mut self) {
        let norm = self.next.norm();
        if norm > 0.0 {
            self.next /= norm;
            self.next_scale *= norm;
        }
    }
}

/// The distance of a row from the span of an orthonormal basis, and the unit vector of what is
/// left. Projected twice: once loses orthogonality where the distance is small.
fn distance(row: &RowDVector<f64>, basis: &[DVector<f64>]) -> (f64, DVector<f64>) {
    let mut left = row.transpose();
    for _ in 0..2 {
        for direction in basis {
            let along = left.dot(direction);
            left.axpy(-along, direction, 1.0);
        }
    }
    let distance = left.norm();
    let direction = if distance > 0.0 {
        left / distance
    } else {
        left
    };
    (distance, direction)
}

/// `alpha_i`: the row `c_i A^{v_i}` in terms of the rows that eq. 9 allows.
fn coefficients(chains: &[Chain], indices: &[usize], i: usize) -> Vec<Vec<f64>> {
    let allowed: Vec<usize> = (0..indices.len())
        .map(|j| shared_index(indices, i, j))
        .collect();
    let mut columns = Vec::new();
    let mut scales = Vec::new();
    for (chain, &count) in chains.iter().zip(&allowed) {
        for (row, scale) in &chain.rows[..count] {
            columns.push(row.transpose());
            scales.push(*scale);
        }
    }
    let target = chains[i].next.transpose();
    let target = DMatrix::from_columns(&[target]);
    let solution = LeastSquares::new(&DMatrix::from_columns(&columns), &target);
    let mut values = solution
        .coefficients
        .iter()
        .zip(scales)
        .map(|(value, scale)| value * chains[i].next_scale / scale);
    allowed
        .iter()
        .map(|&count| values.by_ref().take(count).collect())
        .collect()
}
