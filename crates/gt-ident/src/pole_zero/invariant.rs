//! Invariant zeros of a state-space model.

use gt_core::la::{as_faer, to_nalgebra};
use gt_core::{ModelError, StateSpace};
use nalgebra::{Complex, DMatrix};

use crate::IdentError;

/// Singular values below this many times the size of the scaled model count as zero.
const RANK_TOLERANCE: f64 = 1e-10;

/// The finite invariant zeros of a model: the `z` at which `[A - z I, B; C, D]` loses rank.
///
/// They are the transmission zeros together with the modes that cannot be reached or seen. The
/// model is first reduced by orthogonal transformations to one whose direct term is square and
/// invertible, which takes the zeros at infinity out (Emami-Naeini and Van Dooren, Automatica
/// 18(4), 1982); the zeros are the eigenvalues of what is left. Inputs and outputs are
/// scaled beforehand, rank decisions are at `1e-10` of the size of the scaled model.
///
/// A model whose transfer matrix is zero has none.
///
/// # Errors
/// [`IdentError::Model`] where the eigenvalues do not converge.
pub fn invariant_zeros(model: &StateSpace) -> Result<Vec<Complex<f64>>, IdentError> {
    let mut system = System {
        a: model.a().clone(),
        b: model.b().clone(),
        c: model.c().clone(),
        d: model.d().clone(),
    };
    system.scale();
    let tolerance = RANK_TOLERANCE * system.a.norm().max(1.0);
    system.reduce(tolerance);
    system = system.dual();
    system.reduce(tolerance);
    let (states, channels) = (system.a.nrows(), system.d.nrows());
    if states == 0 || system.d.ncols() != channels {
        return Ok(Vec::new());
    }
    eigenvalues(&system).ok_or(IdentError::Model(ModelError::NoConvergence {
        order: states,
        iterations: 30 * states,
    }))
}

/// Orthonormal columns that span what a matrix' columns span, and their complement.
struct Ranges {
    rank: usize,
    /// Square, the range first.
    basis: DMatrix<f64>,
}

/// The range of `matrix` and its orthogonal complement.
fn ranges(matrix: &DMatrix<f64>, tolerance: f64) -> Ranges {
    let rows = matrix.nrows();
    let identity = Ranges {
        rank: 0,
        basis: DMatrix::identity(rows, rows),
    };
    if matrix.is_empty() {
        return identity;
    }
    let Ok(decomposed) = as_faer(matrix).svd() else {
        return identity;
    };
    let values = decomposed.S().column_vector();
    let rank = values.iter().filter(|&&value| value > tolerance).count();
    Ranges {
        rank,
        basis: to_nalgebra(decomposed.U()),
    }
}

struct System {
    a: DMatrix<f64>,
    b: DMatrix<f64>,
    c: DMatrix<f64>,
    d: DMatrix<f64>,
}

impl System {
    /// Inputs and outputs in units that give the columns of `[B; D]` and then the rows of `[C D]`
    /// unit length.
    fn scale(&mut self) {
        for column in 0..self.b.ncols() {
            let size = self
                .b
                .column(column)
                .norm()
                .hypot(self.d.column(column).norm());
            if size > 0.0 {
                self.b.column_mut(column).unscale_mut(size);
                self.d.column_mut(column).unscale_mut(size);
            }
        }
        for row in 0..self.c.nrows() {
            let size = self.c.row(row).norm().hypot(self.d.row(row).norm());
            if size > 0.0 {
                self.c.row_mut(row).unscale_mut(size);
                self.d.row_mut(row).unscale_mut(size);
            }
        }
    }

    fn dual(self) -> Self {
        Self {
            a: self.a.transpose(),
            b: self.c.transpose(),
            c: self.b.transpose(),
            d: self.d.transpose(),
        }
    }

    /// Takes out states that the outputs force to zero until `D` has full row rank.
    fn reduce(&mut self, tolerance: f64) {
        // Each turn takes a state, or ends.
        for _ in 0..=self.a.nrows() + 1 {
            let rows = ranges(&self.d, tolerance);
            let left = self.d.nrows() - rows.rank;
            if left == 0 {
                return;
            }
            let c = rows.basis.tr_mul(&self.c);
            let d = rows.basis.tr_mul(&self.d);
            let (direct, free) = (c.rows(0, rows.rank), c.rows(rows.rank, left));
            let forced = ranges(&free.transpose(), tolerance);
            if forced.rank == 0 {
                self.c = direct.into_owned();
                self.d = d.rows(0, rows.rank).into_owned();
                return;
            }
            let (taken, states) = (forced.rank, self.a.nrows());
            let kept = states - taken;
            let a = forced.basis.tr_mul(&self.a) * &forced.basis;
            let b = forced.basis.tr_mul(&self.b);
            let direct = direct * &forced.basis;
            self.a = a.view((taken, taken), (kept, kept)).into_owned();
            self.b = b.rows(taken, kept).into_owned();
            let mut next_c = DMatrix::zeros(rows.rank + taken, kept);
            next_c
                .rows_mut(0, rows.rank)
                .copy_from(&direct.columns(taken, kept));
            next_c
                .rows_mut(rows.rank, taken)
                .copy_from(&a.view((0, taken), (taken, kept)));
            let mut next_d = DMatrix::zeros(rows.rank + taken, d.ncols());
            next_d
                .rows_mut(0, rows.rank)
                .copy_from(&d.rows(0, rows.rank));
            next_d
                .rows_mut(rows.rank, taken)
                .copy_from(&b.rows(0, taken));
            (self.c, self.d) = (next_c, next_d);
        }
    }
}

/// The zeros of a model with an invertible direct term: with `W` the null space of `[C D]`, the
/// eigenvalues of the pencil of `[A B] W` and `[I 0] W`. `D` itself is never inverted, and `[I 0] W`
/// is well-conditioned unless a zero lies far out.
fn eigenvalues(system: &System) -> Option<Vec<Complex<f64>>> {
    let (states, channels) = (system.a.nrows(), system.d.nrows());
    let mut outputs = DMatrix::zeros(channels, states + channels);
    outputs.columns_mut(0, states).copy_from(&system.c);
    outputs.columns_mut(states, channels).copy_from(&system.d);
    let spans = ranges(&outputs.transpose(), 0.0);
    let null = spans.basis.columns(channels, states);
    let (top, bottom) = (null.rows(0, states), null.rows(states, channels));
    let left = &system.a * top + &system.b * bottom;
    let quotient = top.into_owned().full_piv_lu().solve(&left)?;
    if !quotient.iter().all(|value| value.is_finite()) {
        return None;
    }
    let values = as_faer(&quotient).eigenvalues().ok()?;
    let all = values
        .into_iter()
        .map(|value| Complex::new(value.re, value.im));
    Some(all.collect())
}
