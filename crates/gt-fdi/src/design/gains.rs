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
        let Process { a, c, r, s, .. } = process;
        let pct = p * c.transpose();
        let innovation = Cholesky::new(symmetrised(&(c * &pct + r)))
            .filter(|factor| factor.l_dirty().iter().all(|value| value.is_finite()))
            .ok_or(FilterError::SingularInnovation)?;
        let times_inverse =
            |matrix: &DMatrix<f64>| innovation.solve(&matrix.transpose()).transpose();
        Ok(Self {
            predictor: times_inverse(&(a * &pct + s)),
            filter: times_inverse(&pct),
            innovation,
        })
    }

    /// `A - K C`.
    pub(super) fn closed_loop(&self, process: Process) -> DMatrix<f64> {
        process.a - &self.predictor * process.c
    }

    /// What the noise adds to the covariance in a step with this gain:
    /// `Q + K R K' - K S' - S K' (nx x nx)`.
    pub(super) fn added(&self, process: Process) -> DMatrix<f64> {
        let k = &self.predictor;
        let cross = k * process.s.transpose();
        process.q + k * process.r * k.transpose() - &cross - cross.transpose()
    }

    /// The covariance one step ahead, in Joseph's form, which keeps it symmetric and positive:
    /// `(A - K C) P (A - K C)' + Q + K R K' - K S' - S K'`.
    pub(super) fn next(&self, process: Process, p: &DMatrix<f64>) -> DMatrix<f64> {
        let closed = self.closed_loop(process);
        symmetrised(&(&closed * p * closed.transpose() + self.added(process)))
    }
}
