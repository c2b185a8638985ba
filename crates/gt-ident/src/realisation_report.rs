//! Whether a realisation is minimal, and how well it is conditioned.

use gt_core::StateSpace;
use gt_core::la::{as_faer, to_nalgebra};
use nalgebra::{DMatrix, DVector};
use serde::Serialize;

use crate::parameter_covariance::condition;
use crate::{ArxModel, IdentError, RANK_TOLERANCE};

/// A Hankel singular value below this many times the largest counts as zero.
pub const HANKEL_TOLERANCE: f64 = 1e-9;

/// Beyond this condition of `M` half of the digits of `B` may be lost.
pub const CONDITION_WARNING: f64 = 1e8;

/// Doublings after which the Gramian of a model next to the stability limit is given up: they
/// cover `2^40` samples.
const DOUBLINGS: usize = 40;

/// What may be wrong with a realisation.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum RealisationWarning {
    /// `M`, through which `B` is found, is ill-conditioned.
    IllConditioned {
        /// `cond(M)`.
        condition: f64,
        /// [`CONDITION_WARNING`].
        limit: f64,
    },
    /// Some states cannot be reached or seen.
    NotMinimal {
        /// Number of states.
        order: usize,
        /// Number of states that can be reached and seen.
        minimal: usize,
    },
}

/// The realisation of a model, judged.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct RealisationReport {
    /// Number of states.
    pub order: usize,
    /// Rank of the reachable space: states that the inputs move.
    pub reachable: usize,
    /// Rank of the observable space: states that the outputs show.
    pub observable: usize,
    /// Hankel singular values, largest first, in outputs' units per inputs' units; `None` for a
    /// model that is not stable.
    pub hankel_singular_values: Option<Vec<f64>>,
    /// The order of a minimal realisation: the Hankel singular values above [`HANKEL_TOLERANCE`]
    /// of the largest, of the model in units in which every channel counts alike (an output in
    /// pascal would else hide the states of one in kelvin). For a model that is not stable it is the smaller of the two ranks, which
    /// may be too large.
    pub minimal_order: usize,
    /// `|det M|`, which is 1 but for rounding.
    pub m_determinant: f64,
    /// `cond(M)` in the 2-norm, which is not: it grows with the order and with slow poles.
    pub m_condition: f64,
    /// What may be wrong.
    pub warnings: Vec<RealisationWarning>,
}

/// Judges the realisation of [`ArxModel::state_space`].
///
/// Ranks are those of orthonormal bases of the Krylov spaces: a direction of unit length counts
/// where more than [`RANK_TOLERANCE`] of it lies outside the span of those before it.
///
/// # Errors
/// As [`ArxModel::canonical_form`] and [`ArxModel::state_space`].
pub fn realisation_report(model: &ArxModel) -> Result<RealisationReport, IdentError> {
    let space = model.state_space()?;
    let m = model.canonical_form()?.m_matrix();
    let m_condition = condition(&m);
    let order = space.nx();
    let reachable = krylov_rank(space.a(), space.b());
    let observable = krylov_rank(&space.a().transpose(), &space.c().transpose());
    let hankel_singular_values = hankel_singular_values(&space)?;
    let minimal_order = match hankel_values_of_like_channels(&space)? {
        Some(values) => {
            let largest = values.first().copied().unwrap_or(0.0);
            let counts = |value: &&f64| **value > HANKEL_TOLERANCE * largest;
            values.iter().filter(counts).count()
        }
        None => reachable.min(observable),
    };
    let mut warnings = Vec::new();
    if m_condition > CONDITION_WARNING {
        warnings.push(RealisationWarning::IllConditioned {
            condition: m_condition,
            limit: CONDITION_WARNING,
        });
    }
    if minimal_order < order {
        warnings.push(RealisationWarning::NotMinimal {
            order,
            minimal: minimal_order,
        });
    }
    Ok(RealisationReport {
        order,
        reachable,
        observable,
        hankel_singular_values,
        minimal_order,
        m_determinant: m.determinant().abs(),
        m_condition,
        warnings,
    })
}

/// The dimension of the span of `start, A start, A^2 start, ..`.
fn krylov_rank(a: &DMatrix<f64>, start: &DMatrix<f64>) -> usize {
    let mut basis: Vec<DVector<f64>> = Vec::new();
    let mut queue: Vec<DVector<f64>> = start.column_iter().map(DVector::from).collect();
    let mut next = 0;
    while next < queue.len() && basis.len() < a.nrows() {
        let vector = &queue[next];
        next += 1;
        let size = vector.norm();
        if size <= 0.0 {
            continue;
        }
        let mut left = vector / size;
        // Twice: once loses orthogonality where little is left.
        for _ in 0..2 {
            for direction in &basis {
                let along = left.dot(direction);
                left.axpy(-along, direction, 1.0);
            }
        }
        let distance = left.norm();
        if distance > RANK_TOLERANCE {
            left /= distance;
            queue.push(a * &left);
            basis.push(left);
        }
    }
    basis.len()
}

/// The singular values of the Hankel operator: with `P = S S'` and `Q = R R'` the Gramians, those
/// of `R' S`. `None` for a model that is not stable.
fn hankel_singular_values(model: &StateSpace) -> Result<Option<Vec<f64>>, IdentError> {
    if model.nx() == 0 || model.nu() == 0 || model.ny() == 0 {
        return Ok(Some(Vec::new()));
    }
    if model.spectral_radius()? >= 1.0 {
        return Ok(None);
    }
    let reachability = gramian_factor(model.a(), model.b());
    let observability = gramian_factor(&model.a().transpose(), &model.c().transpose());
    let (Some(s), Some(r)) = (reachability, observability) else {
        return Ok(None);
    };
    let product = r.tr_mul(&s);
    let Ok(mut values) = as_faer(&product).singular_values() else {
        return Ok(None);
    };
    values.sort_by(|a, b| b.total_cmp(a));
    values.resize(model.nx(), 0.0);
    Ok(Some(values))
}

/// An impulse response below this part of what it could be is rounding: the channel is left as it is.
const ROUNDING: f64 = 1e-13;

/// Sweeps over inputs and outputs that bring their sizes together.
const SWEEPS: usize = 3;

/// The Hankel singular values of the model with each output over the norm of its impulse responses
/// to all inputs, and each input over the norm of those of all outputs to it.
fn hankel_values_of_like_channels(model: &StateSpace) -> Result<Option<Vec<f64>>, IdentError> {
    let (mut b, mut c) = (model.b().clone(), model.c().clone());
    let counts = |size: f64, most: f64| size > ROUNDING * most && size.is_finite();
    if model.nx() > 0 && model.spectral_radius()? < 1.0 {
        for _ in 0..SWEEPS {
            let Some(s) = gramian_factor(model.a(), &b) else {
                break;
            };
            for mut row in c.row_iter_mut() {
                let size = (&row * &s).norm();
                if counts(size, row.norm() * s.norm()) {
                    row /= size;
                }
            }
            let Some(r) = gramian_factor(&model.a().transpose(), &c.transpose()) else {
                break;
            };
            for mut column in b.column_iter_mut() {
                let size = r.tr_mul(&column).norm();
                if counts(size, column.norm() * r.norm()) {
                    column /= size;
                }
            }
        }
    }
    let like = StateSpace::new(
        [model.a().clone(), b, c, model.d().clone()],
        model.sample_time_s(),
        model.inputs().to_vec(),
        model.outputs().to_vec(),
    )?;
    hankel_singular_values(&like)
}

/// A square root `S` of the Gramian `sum A^k B B' A'^k = S S'`, by doubling: with `A_j = A^(2^j)`,
/// `S_(j+1) = [S_j, A_j S_j]`, compressed to `nx` columns. The Gramian itself, which squares the
/// range of its values, is never formed.
fn gramian_factor(a: &DMatrix<f64>, b: &DMatrix<f64>) -> Option<DMatrix<f64>> {
    let mut power = a.clone();
    let mut root = b.clone();
    for _ in 0..DOUBLINGS {
        let added = &power * &root;
        if !added.iter().all(|value| value.is_finite()) {
            return None;
        }
        if added.norm() <= f64::EPSILON * root.norm() {
            return Some(root);
        }
        let mut both = DMatrix::zeros(root.ncols() + added.ncols(), a.nrows());
        both.rows_mut(0, root.ncols()).copy_from(&root.transpose());
        both.rows_mut(root.ncols(), added.ncols())
            .copy_from(&added.transpose());
        root = to_nalgebra(as_faer(&both).qr().thin_R()).transpose();
        power = &power * &power;
    }
    None
}
