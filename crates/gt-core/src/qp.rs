//! Convex quadratic programmes, solved by the interior-point method of clarabel (Goulart and
//! Chen, 2024). This is the only file that names clarabel.

use clarabel::algebra::CscMatrix;
use clarabel::solver::{
    DefaultSettings, DefaultSolver, IPSolver, SolverStatus, SupportedConeT::NonnegativeConeT,
    SupportedConeT::ZeroConeT,
};
use nalgebra::{Cholesky, DMatrix, DVector};
use thiserror::Error;

use crate::DimensionError;

/// `P` may lack symmetry, or have negative eigenvalues, by this part of its largest entry.
pub const ROUNDING: f64 = 1e-10;

/// Tolerance on residuals and duality gap, after the solver's own scaling of the problem.
const TOLERANCE: f64 = 1e-10;
/// Far more than a convex programme takes: 8 to 25 are usual.
const ITERATIONS: u32 = 100;

/// `minimise 1/2 x'P x + q'x` subject to `E x = e` and `lower <= G x <= upper`.
///
/// Shapes: `P (n x n)`, symmetric and positive semidefinite; `q (n)`; `E (k x n)`, `e (k)`;
/// `G (m x n)`, `lower (m)`, `upper (m)`, where an infinite bound is none. Bounds beyond 1e20 in
/// size count as infinite.
#[derive(Debug, Clone, PartialEq)]
pub struct QuadraticProgram {
    p: DMatrix<f64>,
    q: DVector<f64>,
    equalities: (DMatrix<f64>, DVector<f64>),
    bounded: (DMatrix<f64>, DVector<f64>, DVector<f64>),
}

/// The minimiser of a [`QuadraticProgram`] with its multipliers, which satisfy
/// `P x + q + E' y + G' z = 0`.
#[derive(Debug, Clone, PartialEq)]
pub struct QpSolution {
    /// `x (n)`.
    pub x: DVector<f64>,
    /// `y (k)`, free in sign.
    pub equality_multipliers: DVector<f64>,
    /// `z (m)`: positive where `upper` binds, negative where `lower` binds, near 0 elsewhere.
    pub bound_multipliers: DVector<f64>,
    /// `1/2 x'P x + q'x`.
    pub objective: f64,
    /// Iterations spent.
    pub iterations: usize,
    /// Whether the solver stalled before its full accuracy (1e-10, scaled) but within 5e-5.
    pub reduced_accuracy: bool,
}

/// A quadratic programme that cannot be posed or has no solution.
#[derive(Debug, Clone, PartialEq, Error)]
pub enum QpError {
    /// Sizes disagree.
    #[error(transparent)]
    Dimension(#[from] DimensionError),
    /// There is nothing to choose.
    #[error("variables: expected at least 1, found none")]
    NoVariables,
    /// An entry is NaN, or infinite where no infinity is allowed.
    #[error("{what}({row}, {column}): expected a finite number, found {found}")]
    NotFinite {
        /// `P`, `q`, `E`, `e`, `G`, `lower` or `upper`.
        what: &'static str,
        /// 0-based row.
        row: usize,
        /// 0-based column.
        column: usize,
        /// The value found.
        found: f64,
    },
    /// `P` is not symmetric.
    #[error("P({row}, {column}): expected {expected} (symmetry), found {found}")]
    NotSymmetric {
        /// 0-based row.
        row: usize,
        /// 0-based column.
        column: usize,
        /// The mirrored entry.
        expected: f64,
        /// The value found.
        found: f64,
    },
    /// `P` has a negative eigenvalue, so that the programme is not convex.
    #[error("P: expected no negative eigenvalue, found one of at most {bound:e}")]
    NotConvex {
        /// An upper bound of the smallest eigenvalue.
        bound: f64,
    },
    /// A lower bound lies above the upper one.
    #[error("bounds of row {row}: expected lower <= upper, found {lower} > {upper}")]
    CrossedBounds {
        /// 0-based row of `G`.
        row: usize,
        /// Lower bound.
        lower: f64,
        /// Upper bound.
        upper: f64,
    },
    /// No `x` satisfies the constraints.
    #[error("constraints: expected a point that satisfies them all, found a proof of none")]
    Infeasible,
    /// The objective falls without bound.
    #[error("objective: expected a lower bound, found a direction without one")]
    Unbounded,
    /// The solver stopped early.
    #[error("quadratic programme: expected a solution, found {status} after {iterations} steps")]
    NoConvergence {
        /// The solver's own word.
        status: String,
        /// Iterations spent.
        iterations: usize,
    },
}

impl QuadraticProgram {
    /// The programme without constraints.
    ///
    /// # Errors
    /// [`QpError::NoVariables`], [`QpError::Dimension`], [`QpError::NotFinite`],
    /// [`QpError::NotSymmetric`] or [`QpError::NotConvex`].
    pub fn new(p: DMatrix<f64>, q: DVector<f64>) -> Result<Self, QpError> {
        let n = q.len();
        if n == 0 {
            return Err(QpError::NoVariables);
        }
        DimensionError::check("rows of P", n, p.nrows())?;
        DimensionError::check("columns of P", n, p.ncols())?;
        finite("P", &p)?;
        finite("q", &DMatrix::from_column_slice(n, 1, q.as_slice()))?;
        let allowance = ROUNDING * p.amax();
        for column in 0..n {
            for row in 0..column {
                let (found, expected) = (p[(row, column)], p[(column, row)]);
                if (found - expected).abs() > allowance {
                    return Err(QpError::NotSymmetric {
                        row,
                        column,
                        expected,
                        found,
                    });
                }
            }
        }
        // The shifted matrix has a Cholesky factor unless an eigenvalue lies below -allowance.
        let shifted = &p + DMatrix::identity(n, n) * allowance;
        if allowance > 0.0 && Cholesky::new(shifted).is_none() {
            return Err(QpError::NotConvex { bound: -allowance });
        }
        Ok(Self {
            p,
            q,
            equalities: (DMatrix::zeros(0, n), DVector::zeros(0)),
            bounded: (DMatrix::zeros(0, n), DVector::zeros(0), DVector::zeros(0)),
        })
    }

    /// The same programme subject to `E x = e`; replaces earlier equalities.
    ///
    /// # Errors
    /// [`QpError::Dimension`] or [`QpError::NotFinite`].
    pub fn equalities(mut self, e: DMatrix<f64>, right: DVector<f64>) -> Result<Self, QpError> {
        DimensionError::check("columns of E", self.q.len(), e.ncols())?;
        DimensionError::check("rows of e", e.nrows(), right.len())?;
        finite("E", &e)?;
        finite(
            "e",
            &DMatrix::from_column_slice(right.len(), 1, right.as_slice()),
        )?;
        self.equalities = (e, right);
        Ok(self)
    }

    /// The same programme subject to `lower <= G x <= upper`; replaces earlier bounds.
    ///
    /// # Errors
    /// [`QpError::Dimension`], [`QpError::NotFinite`] (a bound that is NaN, or infinite on the side
    /// that excludes everything) or [`QpError::CrossedBounds`].
    pub fn bounds(
        mut self,
        g: DMatrix<f64>,
        lower: DVector<f64>,
        upper: DVector<f64>,
    ) -> Result<Self, QpError> {
        DimensionError::check("columns of G", self.q.len(), g.ncols())?;
        DimensionError::check("rows of lower", g.nrows(), lower.len())?;
        DimensionError::check("rows of upper", g.nrows(), upper.len())?;
        finite("G", &g)?;
        for row in 0..g.nrows() {
            let excludes_all = [
                ("lower", lower[row], lower[row] >= f64::INFINITY),
                ("upper", upper[row], upper[row] <= f64::NEG_INFINITY),
            ];
            for (what, found, excluded) in excludes_all {
                if found.is_nan() || excluded {
                    let column = 0;
                    return Err(QpError::NotFinite {
                        what,
                        row,
                        column,
                        found,
                    });
                }
            }
            if lower[row] > upper[row] {
                return Err(QpError::CrossedBounds {
                    row,
                    lower: lower[row],
                    upper: upper[row],
                });
            }
        }
        self.bounded = (g, lower, upper);
        Ok(self)
    }

    /// Solves the programme; the same problem gives the same bits.
    ///
    /// # Errors
    /// [`QpError::Infeasible`], [`QpError::Unbounded`] or [`QpError::NoConvergence`].
    pub fn solve(&self) -> Result<QpSolution, QpError> {
        let n = self.q.len();
        let (e, right) = &self.equalities;
        let (g, lower, upper) = &self.bounded;
        // Clarabel's form is A x + s = b with s zero, then s >= 0: a bounded row appears once for
        // each finite side, with its sign.
        let sides: Vec<(usize, f64, f64)> = (0..g.nrows())
            .flat_map(|row| [(row, 1.0, upper[row]), (row, -1.0, -lower[row])])
            .filter(|&(_, _, bound)| bound.is_finite())
            .collect();
        let k = e.nrows();
        let mut a = DMatrix::zeros(k + sides.len(), n);
        a.rows_mut(0, k).copy_from(e);
        for (index, &(row, sign, _)) in sides.iter().enumerate() {
            a.set_row(k + index, &(g.row(row) * sign));
        }
        let b: Vec<f64> = right
            .iter()
            .copied()
            .chain(sides.iter().map(|&(_, _, bound)| bound))
            .collect();
        let settings = DefaultSettings {
            verbose: false,
            max_iter: ITERATIONS,
            tol_gap_abs: TOLERANCE,
            tol_gap_rel: TOLERANCE,
            tol_feas: TOLERANCE,
            ..DefaultSettings::default()
        };
        let failure =
            |status: String, iterations: usize| QpError::NoConvergence { status, iterations };
        let mut solver = DefaultSolver::new(
            &sparse(&self.p.upper_triangle()),
            self.q.as_slice(),
            &sparse(&a),
            &b,
            &[ZeroConeT(k), NonnegativeConeT(sides.len())],
            settings,
        )
        .map_err(|error| failure(error.to_string(), 0))?;
        solver.solve();
        let found = &solver.solution;
        let iterations = usize::try_from(found.iterations).unwrap_or(usize::MAX);
        let reduced_accuracy = match found.status {
            SolverStatus::Solved => false,
            SolverStatus::AlmostSolved => true,
            SolverStatus::PrimalInfeasible | SolverStatus::AlmostPrimalInfeasible => {
                return Err(QpError::Infeasible);
            }
            SolverStatus::DualInfeasible | SolverStatus::AlmostDualInfeasible => {
                return Err(QpError::Unbounded);
            }
            status => return Err(failure(format!("{status:?}"), iterations)),
        };
        let x = DVector::from_column_slice(&found.x);
        let mut bound_multipliers = DVector::zeros(g.nrows());
        for (&(row, sign, _), z) in sides.iter().zip(&found.z[k..]) {
            bound_multipliers[row] += sign * z;
        }
        let objective = 0.5 * (&self.p * &x).dot(&x) + self.q.dot(&x);
        Ok(QpSolution {
            objective,
            equality_multipliers: DVector::from_column_slice(&found.z[..k]),
            bound_multipliers,
            iterations,
            reduced_accuracy,
            x,
        })
    }
}

fn finite(what: &'static str, matrix: &DMatrix<f64>) -> Result<(), QpError> {
    for column in 0..matrix.ncols() {
        for row in 0..matrix.nrows() {
            let found = matrix[(row, column)];
            if !found.is_finite() {
                return Err(QpError::NotFinite {
                    what,
                    row,
                    column,
                    found,
                });
            }
        }
    }
    Ok(())
}

/// The non-zero entries by columns.
fn sparse(matrix: &DMatrix<f64>) -> CscMatrix<f64> {
    let (mut starts, mut rows, mut values) = (vec![0], Vec::new(), Vec::new());
    for column in matrix.column_iter() {
        for (row, &value) in column.iter().enumerate() {
            if value != 0.0 {
                rows.push(row);
                values.push(value);
            }
        }
        starts.push(rows.len());
    }
    CscMatrix::new(matrix.nrows(), matrix.ncols(), starts, rows, values)
}
