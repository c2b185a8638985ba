//! Rows of correlated equation errors, estimated together.

use nalgebra::{Cholesky, DMatrix, DVector};

use crate::least_squares::{CONDITION_LIMIT, LeastSquares};
use crate::record::{Records, Window};
use crate::tall::triangle;
use crate::{Channel, Regressor};

/// Rounds of covariance and coefficients in turn.
const ROUNDS: usize = 50;
/// Relative change of the coefficients at which the rounds end: far below the standard errors.
const SETTLED: f64 = 1e-10;

/// The rows of a model, estimated together.
pub(crate) struct Joint {
    /// One list a row.
    pub coefficients: Vec<DVector<f64>>,
    /// Covariance of the coefficients, one a row, without the factor `T / (T - d)`.
    pub covariances: Vec<DMatrix<f64>>,
    /// Residual sums of squares.
    pub squares: Vec<f64>,
    /// Condition of the regressors of each row, outputs at lag 0 replaced by their projections.
    pub conditions: Vec<f64>,
}

/// A row that is not identified, with the solution that shows it.
pub(crate) struct Unidentified {
    pub output: usize,
    pub solution: LeastSquares,
}

/// Iterated three-stage least squares (Zellner and Theil 1962): the instruments are the lagged
/// channels of all rows, and with them and the present outputs factorised, a projection on the
/// instruments is the top of the triangular factor.
pub(crate) fn solve(
    records: &Records,
    window: &Window,
    rows: &[Vec<Regressor>],
) -> Result<Joint, Box<Unidentified>> {
    let present = |each: &Regressor| each.lag == 0 && matches!(each.channel, Channel::Output(_));
    let mut columns: Vec<Regressor> = Vec::new();
    for each in rows.iter().flatten().filter(|each| !present(each)) {
        if !columns.contains(each) {
            columns.push(*each);
        }
    }
    let instruments = columns.len();
    columns.extend((0..rows.len()).map(|output| Regressor {
        channel: Channel::Output(output),
        lag: 0,
    }));
    let factor = triangle(records, window, &columns, false);
    let place = |each: &Regressor| columns.iter().position(|column| column == each);
    let systems: Vec<System> = rows
        .iter()
        .enumerate()
        .map(|(output, row)| {
            let chosen: Vec<usize> = row.iter().filter_map(place).collect();
            System {
                design: factor.select_columns(&chosen),
                target: factor.column(instruments + output).into_owned(),
            }
        })
        .collect();

    let mut conditions = Vec::with_capacity(rows.len());
    let mut coefficients = Vec::with_capacity(rows.len());
    for (output, system) in systems.iter().enumerate() {
        let p = system.design.ncols();
        // Fewer instruments than coefficients: rows of zeros make the rank speak for itself.
        let height = instruments.max(p + 1);
        let mut design = DMatrix::zeros(height, p);
        let mut target = DMatrix::zeros(height, 1);
        design
            .rows_mut(0, instruments)
            .copy_from(&system.top(instruments));
        target
            .rows_mut(0, instruments)
            .copy_from(&system.target.rows(0, instruments));
        let solution = LeastSquares::new(&design, &target);
        if !solution.full_rank() {
            return Err(Box::new(Unidentified { output, solution }));
        }
        conditions.push(solution.condition);
        coefficients.push(solution.coefficients.column(0).into_owned());
    }

    let t = records.rows(window.longest, window.first_row) as f64;
    let mut covariances: Vec<DMatrix<f64>> = Vec::new();
    for _ in 0..ROUNDS {
        let errors = errors(&systems, &coefficients);
        let Some((next, spread)) = weighted(&systems, instruments, &(errors.tr_mul(&errors) / t))
        else {
            break;
        };
        let change = next
            .iter()
            .zip(&coefficients)
            .map(|(new, old)| (new - old).norm() / new.norm().max(f64::MIN_POSITIVE))
            .fold(0.0, f64::max);
        coefficients = next;
        covariances = spread;
        if change <= SETTLED {
            break;
        }
    }
    let errors = errors(&systems, &coefficients);
    if covariances.is_empty() {
        // Errors without a covariance of full rank (exact data): nothing to weigh, no spread.
        covariances = systems
            .iter()
            .map(|system| DMatrix::zeros(system.design.ncols(), system.design.ncols()))
            .collect();
    }
    Ok(Joint {
        coefficients,
        covariances,
        squares: errors
            .column_iter()
            .map(|each| each.norm_squared())
            .collect(),
        conditions,
    })
}

/// One row in rotated coordinates.
struct System {
    design: DMatrix<f64>,
    target: DVector<f64>,
}

impl System {
    fn top(&self, instruments: usize) -> DMatrix<f64> {
        self.design.rows(0, instruments).into_owned()
    }
}

/// The equation errors in rotated coordinates, a column a row of the model.
fn errors(systems: &[System], coefficients: &[DVector<f64>]) -> DMatrix<f64> {
    let columns: Vec<DVector<f64>> = systems
        .iter()
        .zip(coefficients)
        .map(|(system, theta)| &system.target - &system.design * theta)
        .collect();
    DMatrix::from_columns(&columns)
}

/// Coefficients and their covariances, one a row.
type Weighted = (Vec<DVector<f64>>, Vec<DMatrix<f64>>);

/// All rows at once, whitened by the covariance of their errors: the coefficients and their
/// covariances; nothing where the covariance or the stack has no full rank.
fn weighted(systems: &[System], instruments: usize, covariance: &DMatrix<f64>) -> Option<Weighted> {
    let m = systems.len();
    let mut whitener = DMatrix::identity(m, m);
    if !Cholesky::new(covariance.clone())?
        .l()
        .solve_lower_triangular_mut(&mut whitener)
    {
        return None;
    }
    let total: usize = systems.iter().map(|system| system.design.ncols()).sum();
    let mut design = DMatrix::zeros(m * instruments, total);
    let mut target = DMatrix::zeros(m * instruments, 1);
    for a in 0..m {
        let mut first = 0;
        let mut part = DVector::zeros(instruments);
        for (i, system) in systems.iter().enumerate() {
            let p = system.design.ncols();
            design
                .view_mut((a * instruments, first), (instruments, p))
                .copy_from(&(system.top(instruments) * whitener[(a, i)]));
            part.axpy(whitener[(a, i)], &system.target.rows(0, instruments), 1.0);
            first += p;
        }
        target
            .view_mut((a * instruments, 0), (instruments, 1))
            .copy_from(&part);
    }
    if design.nrows() < total {
        return None;
    }
    let solution = LeastSquares::new(&design, &target);
    if solution.condition > CONDITION_LIMIT {
        return None;
    }
    let spread = solution.unit_covariance(0.0);
    let mut first = 0;
    let mut parts = (Vec::with_capacity(m), Vec::with_capacity(m));
    for system in systems {
        let p = system.design.ncols();
        let rows = solution.coefficients.rows(first, p);
        parts.0.push(rows.column(0).into_owned());
        parts
            .1
            .push(spread.view((first, first), (p, p)).into_owned());
        first += p;
    }
    Some(parts)
}
