//! The cheapest coefficients that satisfy linear constraints.

use gt_core::qp::{QpError, QuadraticProgram};
use nalgebra::{DMatrix, DVector};

use super::cost::RowCost;
use super::fit::ActiveConstraint;

/// A multiplier above this part of the largest one marks an active constraint.
const ACTIVE: f64 = 1e-5;

/// `lower <= gradient' theta <= upper`.
#[derive(Debug, Clone)]
pub(crate) struct Constraint {
    pub gradient: DVector<f64>,
    pub lower: f64,
    pub upper: f64,
    /// Whether rounding of the solver is removed afterwards.
    pub exact: bool,
    pub origin: ActiveConstraint,
}

impl Constraint {
    /// What has to be added to `gradient' theta` to satisfy the constraint.
    pub fn defect(&self, theta: &DVector<f64>) -> f64 {
        let value = self.gradient.dot(theta);
        value.clamp(self.lower, self.upper) - value
    }
}

/// The minimiser and the constraints that hold it away from least squares.
pub(crate) struct Nearest {
    pub theta: DVector<f64>,
    pub active: Vec<ActiveConstraint>,
}

/// One constraint as `lower <= unit' v <= upper` in the scaled coordinates.
struct Scaled {
    unit: DVector<f64>,
    lower: f64,
    upper: f64,
}

/// The minimiser of `cost` under `constraints`: a least-distance programme with the identity as
/// its quadratic form, every row of unit length and the largest violation equal to 1.
pub(crate) fn nearest(cost: &RowCost, constraints: &[Constraint]) -> Result<Nearest, QpError> {
    let singular = || QpError::NoConvergence {
        status: "a singular triangular factor".to_owned(),
        iterations: 0,
    };
    let mut scaled = Vec::with_capacity(constraints.len());
    let mut distance = 0.0_f64;
    for constraint in constraints {
        let direction = cost.direction(&constraint.gradient).ok_or_else(singular)?;
        let length = direction.norm();
        let value = constraint.gradient.dot(&cost.least_squares);
        let lower = (constraint.lower - value) / length;
        let upper = (constraint.upper - value) / length;
        distance = distance.max(lower).max(-upper);
        let unit = direction / length;
        scaled.push(Scaled { unit, lower, upper });
    }
    if distance <= 0.0 {
        return Ok(Nearest {
            theta: cost.least_squares.clone(),
            active: Vec::new(),
        });
    }
    for row in &mut scaled {
        row.lower /= distance;
        row.upper /= distance;
    }
    let p = cost.least_squares.len();
    let (equal, bounded): (Vec<usize>, Vec<usize>) =
        (0..scaled.len()).partition(|&index| constraints[index].lower >= constraints[index].upper);
    let stack = |list: &[usize]| {
        DMatrix::from_fn(list.len(), p, |row, column| scaled[list[row]].unit[column])
    };
    let column = |list: &[usize], value: fn(&Scaled) -> f64| {
        DVector::from_fn(list.len(), |row, _| value(&scaled[list[row]]))
    };
    let solution = QuadraticProgram::new(DMatrix::identity(p, p), DVector::zeros(p))?
        .equalities(stack(&equal), column(&equal, |row| row.lower))?
        .bounds(
            stack(&bounded),
            column(&bounded, |row| row.lower),
            column(&bounded, |row| row.upper),
        )?
        .solve()?;
    let exact: Vec<&Scaled> = (scaled.iter().zip(constraints))
        .filter(|(_, constraint)| constraint.exact)
        .map(|(row, _)| row)
        .collect();
    let v = exactly(solution.x, &exact);
    let largest = (solution.equality_multipliers.iter())
        .chain(&solution.bound_multipliers)
        .fold(0.0_f64, |most, value| most.max(value.abs()));
    let multipliers = (equal.iter().zip(solution.equality_multipliers.iter()))
        .chain(bounded.iter().zip(solution.bound_multipliers.iter()));
    let mut active: Vec<usize> = multipliers
        .filter(|(_, value)| value.abs() > ACTIVE * largest)
        .map(|(&index, _)| index)
        .collect();
    active.sort_unstable();
    Ok(Nearest {
        theta: cost.point(&(v * distance)).ok_or_else(singular)?,
        active: active
            .into_iter()
            .map(|index| constraints[index].origin.clone())
            .collect(),
    })
}

/// `v` moved by the shortest way onto the rows that it violates by the solver's rounding.
fn exactly(v: DVector<f64>, rows: &[&Scaled]) -> DVector<f64> {
    let defects: Vec<(&Scaled, f64)> = rows
        .iter()
        .map(|row| {
            let value = row.unit.dot(&v);
            (*row, value.clamp(row.lower, row.upper) - value)
        })
        .filter(|(_, defect)| *defect != 0.0)
        .collect();
    let k = defects.len();
    let violated = DMatrix::from_fn(k, v.len(), |row, column| defects[row].0.unit[column]);
    let right = DVector::from_fn(k, |row, _| defects[row].1);
    match (&violated * violated.transpose()).cholesky() {
        Some(gram) if k > 0 => v + violated.transpose() * gram.solve(&right),
        _ => v,
    }
}
