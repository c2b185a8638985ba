//! The Levenberg-Marquardt search for one row.

use gt_core::ModelError;
use nalgebra::{DMatrix, DVector};

use super::run::RowRun;
use crate::denominator::Denominator;
use crate::least_squares::triangular_factor;

/// Damping of the first step, as a part of the squared column norms.
const FIRST_DAMPING: f64 = 1e-3;
/// Damping beyond which no step helps.
const LAST_DAMPING: f64 = 1e12;
/// The search stops where a step lowers the cost by less than this part.
const GAIN: f64 = 1e-10;

/// Where a search has ended.
pub(crate) struct Found {
    pub parameters: Vec<f64>,
    /// Accepted steps.
    pub iterations: usize,
}

/// Lowers the sum of squared free-run errors; a step is taken only when it lowers the cost and
/// keeps the poles inside `max_radius`, and is shortened by more damping otherwise (More, 1978).
pub(crate) fn search(
    run: &RowRun,
    start: Vec<f64>,
    max_radius: f64,
    max_iterations: usize,
) -> Result<Found, ModelError> {
    let mut parameters = start;
    let mut errors = run.errors(&parameters);
    let mut cost = square(&errors);
    let mut damping = FIRST_DAMPING;
    let mut iterations = 0;
    while iterations < max_iterations && cost > 0.0 && cost.is_finite() {
        let gradient = run.gradient(&parameters);
        let Some(local) = Linearised::new(&gradient, &errors) else {
            break;
        };
        let mut lowered = None;
        while lowered.is_none() && damping <= LAST_DAMPING {
            if let Some(step) = local.step(damping) {
                let trial: Vec<f64> = parameters.iter().zip(&step).map(|(a, b)| a + b).collect();
                lowered = better(run, trial, cost, max_radius)?;
            }
            damping *= if lowered.is_some() { 0.1 } else { 10.0 };
        }
        let Some((trial, next, after)) = lowered else {
            break;
        };
        damping = damping.max(1e-12);
        iterations += 1;
        let gained = cost - after;
        (parameters, errors, cost) = (trial, next, after);
        if gained <= GAIN * cost {
            break;
        }
    }
    Ok(Found {
        parameters,
        iterations,
    })
}

type Step = (Vec<f64>, Vec<f64>, f64);

fn better(
    run: &RowRun,
    trial: Vec<f64>,
    cost: f64,
    max_radius: f64,
) -> Result<Option<Step>, ModelError> {
    if !trial.iter().all(|value| value.is_finite()) {
        return Ok(None);
    }
    if Denominator::from_own_lags(run.own_lags(&trial)).radius()? > max_radius {
        return Ok(None);
    }
    let errors = run.errors(&trial);
    let after = square(&errors);
    Ok((after < cost).then_some((trial, errors, after)))
}

fn square(errors: &[f64]) -> f64 {
    errors.iter().map(|error| error * error).sum()
}

/// `min |J step - e|` by its triangular factor, columns scaled to unit length.
struct Linearised {
    factor: DMatrix<f64>,
    right: DVector<f64>,
    scales: Vec<f64>,
}

impl Linearised {
    fn new(gradient: &DMatrix<f64>, errors: &[f64]) -> Option<Self> {
        let p = gradient.ncols();
        let mut stacked = DMatrix::zeros(gradient.nrows(), p + 1);
        let mut scales = Vec::with_capacity(p);
        for (column, source) in gradient.column_iter().enumerate() {
            let norm = source.norm();
            if !norm.is_finite() {
                return None;
            }
            let scale = if norm > 0.0 { norm } else { 1.0 };
            stacked.set_column(column, &(source / scale));
            scales.push(scale);
        }
        stacked.column_mut(p).copy_from_slice(errors);
        let all = triangular_factor(&stacked);
        Some(Self {
            factor: all.view((0, 0), (p, p)).into_owned(),
            right: all.view((0, p), (p, 1)).column(0).into_owned(),
            scales,
        })
    }

    /// The step with `damping |scaled step|^2` added to the cost.
    fn step(&self, damping: f64) -> Option<Vec<f64>> {
        let p = self.scales.len();
        let mut stacked = DMatrix::zeros(2 * p, p + 1);
        stacked.view_mut((0, 0), (p, p)).copy_from(&self.factor);
        stacked.view_mut((0, p), (p, 1)).copy_from(&self.right);
        stacked
            .view_mut((p, 0), (p, p))
            .fill_diagonal(damping.sqrt());
        let all = triangular_factor(&stacked);
        let step = all
            .view((0, 0), (p, p))
            .solve_upper_triangular(&all.view((0, p), (p, 1)).column(0))?;
        Some(step.iter().zip(&self.scales).map(|(a, b)| a / b).collect())
    }
}
