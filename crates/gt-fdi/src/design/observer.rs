//! Pole placement for one output.

use gt_core::StateSpace;
use nalgebra::{Complex, DMatrix, DVector, SVD};

use super::placement;
use crate::FdiError;

/// The largest condition of the observability matrix at which poles are placed: beyond it, fewer
/// than four digits of the gain would be left.
pub const MAX_OBSERVABILITY_CONDITION: f64 = 1e12;

/// Iterations after which singular values are given up (the matrix then counts as singular).
const SVD_ITERATIONS: usize = 10_000;

/// The gain `K (nx)` that gives `A - K C` the eigenvalues `poles`, for a model with one output
/// (the paper's eq. 22). Poles are real, inside the unit circle, and may repeat;
/// [`place_complex`] also takes pairs of complex poles.
///
/// In observable canonical coordinates `O x`, `O = [C; C A; ...; C A^(nx-1)]`, the rows of the gain
/// are its Markov parameters `C A^k K`. With `p` the monic characteristic polynomial of A and `d`
/// the desired one (coefficient `l` belongs to `z^l`), they solve
/// `sum_s p[k+s-1] Kc[s] = d[k-1] - p[k-1]`, `k = 1..nx`, a triangular system; then `O K = Kc`.
///
/// # Errors
/// [`FdiError`] when the model has not one output, the poles do not fit or the pair `(A, C)` is
/// not observable to within [`MAX_OBSERVABILITY_CONDITION`].
pub fn place(model: &StateSpace, poles: &[f64]) -> Result<DVector<f64>, FdiError> {
    check_single_output(model)?;
    check_poles(model.nx(), poles)?;
    place_polynomial(model, &polynomial(poles))
}

/// As [`place`], of poles (nx) of which each that is not real has its complex conjugate in the
/// list, bit for bit; both may repeat.
///
/// # Errors
/// As [`place`], where the modulus stands for a pole outside the unit circle; besides
/// [`PlacementError::Unpaired`](super::PlacementError::Unpaired).
pub fn place_complex(model: &StateSpace, poles: &[Complex<f64>]) -> Result<DVector<f64>, FdiError> {
    check_single_output(model)?;
    placement::check_complex(model.nx(), poles)?;
    place_polynomial(model, &placement::polynomial(poles)?)
}

/// The gain that gives `|zI - A + K C|` these coefficients, that of `z^l` at index `l`.
fn place_polynomial(model: &StateSpace, desired: &[f64]) -> Result<DVector<f64>, FdiError> {
    if model.nx() == 0 {
        return Ok(DVector::zeros(0));
    }
    let Canonical {
        observability,
        polynomial: actual,
    } = Canonical::of(model)?;
    let markov = canonical_gain(&actual, desired);
    match observability.lu().solve(&markov) {
        Some(gain) if gain.iter().all(|value| value.is_finite()) => Ok(gain),
        _ => Err(unobservable(model, f64::INFINITY)),
    }
}

/// The observable canonical form of a model with one output.
pub(super) struct Canonical {
    /// `[C; C A; ...; C A^(nx-1)] (nx x nx)`.
    observability: DMatrix<f64>,
    /// Coefficients of `|zI - A|`, that of `z^l` at index `l` (nx + 1).
    pub(super) polynomial: Vec<f64>,
}

impl Canonical {
    /// Fails when the state is not observable to within [`MAX_OBSERVABILITY_CONDITION`].
    pub(super) fn of(model: &StateSpace) -> Result<Self, FdiError> {
        let nx = model.nx();
        let mut observability = DMatrix::zeros(nx, nx);
        if nx == 0 {
            return Ok(Self {
                observability,
                polynomial: vec![1.0],
            });
        }
        let mut row = model.c().clone();
        for k in 0..nx {
            observability.set_row(k, &row.row(0));
            row *= model.a();
        }
        let condition = condition(&observability);
        if condition > MAX_OBSERVABILITY_CONDITION || !row.iter().all(|value| value.is_finite()) {
            return Err(unobservable(model, condition));
        }
        // Cayley and Hamilton: C A^nx = -sum_l p[l] C A^l.
        let Some(combination) = observability.transpose().lu().solve(&row.transpose()) else {
            return Err(unobservable(model, f64::INFINITY));
        };
        let mut polynomial: Vec<f64> = combination.iter().map(|value| -value).collect();
        polynomial.push(1.0);
        Ok(Self {
            observability,
            polynomial,
        })
    }
}

fn unobservable(model: &StateSpace, condition: f64) -> FdiError {
    FdiError::Unobservable {
        output: model.outputs()[0].name.clone(),
        condition,
        limit: MAX_OBSERVABILITY_CONDITION,
    }
}

/// The gain in observable canonical coordinates, by substitution from the last equation up.
fn canonical_gain(actual: &[f64], desired: &[f64]) -> DVector<f64> {
    let nx = actual.len() - 1;
    let mut gain = DVector::zeros(nx);
    for s in 0..nx {
        let row = nx - 1 - s;
        let known: f64 = (0..s)
            .map(|earlier| actual[row + earlier + 1] * gain[earlier])
            .sum();
        gain[s] = desired[row] - actual[row] - known;
    }
    gain
}

/// Coefficients of the monic polynomial with these roots, that of `z^l` at index `l`.
fn polynomial(roots: &[f64]) -> Vec<f64> {
    let mut coefficients = vec![1.0];
    for root in roots {
        coefficients.insert(0, 0.0);
        for index in 0..coefficients.len() - 1 {
            coefficients[index] -= root * coefficients[index + 1];
        }
    }
    coefficients
}

/// Ratio of the extreme singular values; infinite for a singular matrix or one out of range.
fn condition(matrix: &DMatrix<f64>) -> f64 {
    if !matrix.iter().all(|value| value.is_finite()) {
        return f64::INFINITY;
    }
    SVD::try_new(matrix.clone(), false, false, f64::EPSILON, SVD_ITERATIONS)
        .map(|svd| svd.singular_values.max() / svd.singular_values.min())
        .filter(|condition| condition.is_finite())
        .unwrap_or(f64::INFINITY)
}

/// Refuses a model with another number of outputs than one.
pub(super) fn check_single_output(model: &StateSpace) -> Result<(), FdiError> {
    if model.ny() == 1 {
        Ok(())
    } else {
        Err(FdiError::OutputCount { found: model.ny() })
    }
}

/// Refuses a wrong number of poles, and poles that are not inside the unit circle.
pub(super) fn check_poles(nx: usize, poles: &[f64]) -> Result<(), FdiError> {
    check_pole_count(nx, poles.len())?;
    let outside = |pole: &f64| {
        !matches!(
            pole.abs().partial_cmp(&1.0),
            Some(core::cmp::Ordering::Less)
        )
    };
    match poles.iter().position(outside) {
        Some(index) => Err(FdiError::PoleOutside {
            index,
            found: poles[index],
        }),
        None => Ok(()),
    }
}

/// Refuses a wrong number of poles.
pub(super) fn check_pole_count(nx: usize, found: usize) -> Result<(), FdiError> {
    if found == nx {
        return Ok(());
    }
    Err(FdiError::PoleCount {
        expected: nx,
        found,
    })
}
