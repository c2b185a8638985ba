//! The constrained fit of one row.

use gt_core::ModelError;
use gt_core::qp::QpError;
use nalgebra::DVector;

use super::cost::RowCost;
use super::dc_gain::RowGain;
use super::fit::ActiveConstraint;
use super::nearest::{Constraint, Nearest, nearest};
use super::stability::{InnerSet, reflected};
use crate::denominator::Denominator;

/// Most centres tried.
const CENTRES: usize = 25;
/// Most rounds of cuts for one centre.
const CUTS: usize = 8;
/// The centres stop where one gains less than this part of the cost.
const GAIN: f64 = 1e-6;
/// Most halvings on the way back to the last stable coefficients.
const HALVINGS: usize = 40;

/// The solution for one row.
pub(crate) struct RowSolution {
    pub theta: DVector<f64>,
    pub active: Vec<ActiveConstraint>,
    /// Centres tried.
    pub centres: usize,
    /// Excess cost of the first centre with the inputs' coefficients refitted.
    pub reflected_excess: Option<f64>,
}

/// A row that cannot be solved.
pub(crate) enum RowFailure {
    Poles(ModelError),
    Programme(QpError),
}

impl From<ModelError> for RowFailure {
    fn from(error: ModelError) -> Self {
        Self::Poles(error)
    }
}

impl From<QpError> for RowFailure {
    fn from(error: QpError) -> Self {
        Self::Programme(error)
    }
}

/// The denominator in the first `na` coefficients.
pub(crate) fn denominator(theta: &DVector<f64>, na: usize) -> Denominator {
    Denominator::from_own_lags(&theta.as_slice()[..na])
}

/// The cheapest coefficients with poles inside `radius` and the gains in their ranges.
pub(crate) fn fit_row(
    cost: &RowCost,
    na: usize,
    gains: &[RowGain],
    radius: f64,
) -> Result<RowSolution, RowFailure> {
    let p = cost.least_squares.len();
    let gain_rows: Vec<Constraint> = gains
        .iter()
        .flat_map(|gain| gain.constraints(na, p))
        .collect();
    let free = denominator(&cost.least_squares, na);
    let stable = free.radius()? <= radius;
    let met = gain_rows
        .iter()
        .all(|row| row.defect(&cost.least_squares) == 0.0);
    if stable && met {
        return Ok(RowSolution {
            theta: cost.least_squares.clone(),
            active: Vec::new(),
            centres: 0,
            reflected_excess: None,
        });
    }
    if na == 0 {
        let found = settled(nearest(cost, &gain_rows)?, &gain_rows, gains);
        return Ok(RowSolution {
            theta: found.theta,
            active: found.active,
            centres: 1,
            reflected_excess: None,
        });
    }
    // The first centre with the inputs' coefficients refitted satisfies every constraint, whatever
    // happens later; fixing the poles leaves each gain free through its input's coefficients.
    let mut centre = reflected(&free, radius)?;
    let mut fixed = gain_rows.clone();
    fixed.extend(centre.own_lags().enumerate().map(|(term, value)| {
        let mut gradient = DVector::zeros(p);
        gradient[term] = 1.0;
        Constraint {
            gradient,
            lower: value,
            upper: value,
            exact: true,
            origin: ActiveConstraint::Stability { angle_rad: 0.0 },
        }
    }));
    let mut best = settled(nearest(cost, &fixed)?, &gain_rows, gains);
    best.active.clear();
    let mut excess = cost.excess(&best.theta);
    let reflected_excess = (!stable).then_some(excess);
    let mut centres = 0;
    while centres < CENTRES {
        let set = InnerSet::new(&centre, radius, na);
        let Ok(found) = cut(cost, &set, na, &gain_rows) else {
            // The last coefficients still satisfy everything.
            break;
        };
        let found = settled(found, &gain_rows, gains);
        let Some(theta) = inside(&best.theta, &found.theta, na, radius)? else {
            break;
        };
        let next = cost.excess(&theta);
        if next.is_nan() || next >= excess {
            break;
        }
        centres += 1;
        let gained = excess - next;
        excess = next;
        best = Nearest { theta, ..found };
        centre = denominator(&best.theta, na);
        if gained <= GAIN * (cost.rss + excess) {
            break;
        }
    }
    Ok(RowSolution {
        theta: best.theta,
        active: best.active,
        centres,
        reflected_excess,
    })
}

/// The minimiser over the set, with cuts where the grid lets it through.
fn cut(
    cost: &RowCost,
    set: &InnerSet,
    na: usize,
    gain_rows: &[Constraint],
) -> Result<Nearest, RowFailure> {
    let p = cost.least_squares.len();
    let mut rows = gain_rows.to_vec();
    rows.extend(
        set.angles()?
            .into_iter()
            .map(|omega| set.constraint(omega, p)),
    );
    let mut found = nearest(cost, &rows)?;
    for _ in 0..CUTS {
        let violated = set.violations(&denominator(&found.theta, na))?;
        if violated.is_empty() {
            break;
        }
        rows.extend(violated.into_iter().map(|omega| set.constraint(omega, p)));
        found = nearest(cost, &rows)?;
    }
    Ok(found)
}

/// The same solution with the gains' last rounding spread over the inputs' coefficients.
fn settled(mut found: Nearest, gain_rows: &[Constraint], gains: &[RowGain]) -> Nearest {
    for row in gain_rows {
        let ActiveConstraint::DcGain { input } = &row.origin else {
            continue;
        };
        let defect = row.defect(&found.theta);
        for gain in gains.iter().filter(|gain| &gain.input == input).take(1) {
            for &term in &gain.terms {
                found.theta[term] += defect / gain.terms.len() as f64;
            }
        }
    }
    found
}

/// The point furthest on the way from `stable` to `target`, by halves, whose poles lie inside
/// `radius`: a grid of angles is only a grid. The other constraints hold on the whole way.
fn inside(
    stable: &DVector<f64>,
    target: &DVector<f64>,
    na: usize,
    radius: f64,
) -> Result<Option<DVector<f64>>, ModelError> {
    let mut way = 1.0;
    for _ in 0..HALVINGS {
        let theta = stable + (target - stable) * way;
        if denominator(&theta, na).radius()? <= radius {
            return Ok(Some(theta));
        }
        way *= 0.5;
    }
    Ok(None)
}
