//! What a covariance of the state means for a filter: its gains and the next covariance.

use nalgebra::{Cholesky, DMatrix, Dyn};

use super::filter_error::FilterError;
use super::noise::symmetrised;

/// Matrices of `x(t+1) = A x + w`, `y(t) = C x + v` with the covariances `Q`, `R`, `S = E[w v']`.
#[derive(Clone, Copy)]
pub(super) struct Process<'a> {
    pub(super) a: &'a DMatrix<f64>,
    pub(super) c: &'a DMatrix<f64>,
    pub(super) q: &'a DMatrix<f64>,
    pub(super) r: &'a DMatrix<f64>,
    pub(super) s: &'a DMatrix<f64>,
}

/// The gains that belong to a covariance `P` of the predicted state.
#[derive(Debug, Clone)]
pub(super) struct Gains {
    /// `K = (A P C' + S) L^-1 (nx x ny)`, for the state one step ahead.
    pub(super) predictor: DMatrix<f64>,
    /// `P C' L^-1 (nx x ny)`, for the state now.
    pub(super) filter: DMatrix<f64>,
    /// `L = C P C' + R (ny x ny)`, the covariance of the innovation.
    pub(super) innovation: Cholesky<f64, Dyn>,
}

impl Gains {
    /// `C P C' + R (ny x ny)` from its factor.
    pub(super) fn innovation_covariance(&self) -> DMatrix<f64> {
        let l = self.innovation.l();
        &l * l.transpose()
    }

    /// Fails when `C P C' + R` is not positive definite.
    pub(super) fn of(process: Process, p: &DMatrix<f64>) -> Result<Self, FilterError> {
        let pct = p * process.c.transpose();
        let innovation = innovation(process, &pct)?;
        Ok(Self {
            predictor: predictor(process, &pct, &innovation),
            filter: times_inverse(&pct, &innovation),
            innovation,
        })
    }

    /// The covariance one step ahead, in Joseph's form, which keeps it symmetric and positive:
    /// `(A - K C) P (A - K C)' + Q + K R K' - K S' - S K'`.
    pub(super) fn next(&self, process: Process, p: &DMatrix<f64>) -> DMatrix<f64> {
        let ClosedLoop { a, added } = ClosedLoop::new(process, &self.predictor);
        symmetrised(&(&a * p * a.transpose() + added))
    }
}

/// A process with a predictor: what becomes of the state's error in a step, and what the noise adds
/// to its covariance.
#[derive(Debug, Clone)]
pub(super) struct ClosedLoop {
    /// `A - K C (nx x nx)`.
    pub(super) a: DMatrix<f64>,
    /// `Q + K R K' - K S' - S K' (nx x nx)`.
    pub(super) added: DMatrix<f64>,
}

impl ClosedLoop {
    /// With the gain that belongs to a covariance `P` of the predicted state. Fails when
    /// `C P C' + R` is not positive definite.
    pub(super) fn of(process: Process, p: &DMatrix<f64>) -> Result<Self, FilterError> {
        let pct = p * process.c.transpose();
        let innovation = innovation(process, &pct)?;
        Ok(Self::new(process, &predictor(process, &pct, &innovation)))
    }

    fn new(process: Process, k: &DMatrix<f64>) -> Self {
        let cross = k * process.s.transpose();
        Self {
            a: process.a - k * process.c,
            added: process.q + k * process.r * k.transpose() - &cross - cross.transpose(),
        }
    }
}

/// The factor of `C P C' + R`.
fn innovation(process: Process, pct: &DMatrix<f64>) -> Result<Cholesky<f64, Dyn>, FilterError> {
    Cholesky::new(symmetrised(&(process.c * pct + process.r)))
        .filter(|factor| factor.l_dirty().iter().all(|value| value.is_finite()))
        .ok_or(FilterError::SingularInnovation)
}

fn predictor(
    process: Process,
    pct: &DMatrix<f64>,
    innovation: &Cholesky<f64, Dyn>,
) -> DMatrix<f64> {
    times_inverse(&(process.a * pct + process.s), innovation)
}

fn times_inverse(matrix: &DMatrix<f64>, factor: &Cholesky<f64, Dyn>) -> DMatrix<f64> {
    factor.solve(&matrix.transpose()).transpose()
}
