//! The descent from starting points to the profile Whittle maximum likelihood estimate.

use gt_core::Stop;
use nalgebra::DMatrix;

use super::coordinates::Coordinates;
use super::layout::Layout;
use super::lbfgs::Lbfgs;
use super::likelihood::Likelihood;
use super::row::EivLags;
use super::spectrum::Spectrum;
use crate::IdentError;

/// Starting points that are followed to the end, the best by `f`.
const FOLLOWED: usize = 4;
/// The metric is renewed after so many iterations, and so often.
const ITERATIONS: usize = 25;
const ROUNDS: usize = 8;
/// Added to the metric of a logarithm of a variance: one that the record says nothing about stays.
const VARIANCE_RIDGE: f64 = 1e-4;
/// Added to the metric of the rest, relative to it.
const RIDGE: f64 = 1e-6;
const STEP: Lbfgs = Lbfgs {
    memory: 12,
    iterations: ITERATIONS,
    tolerance: 1e-12,
    longest_step: 1.5,
};

/// The end of the best descent.
#[derive(Debug, Clone)]
pub(super) struct Refined {
    /// Coefficients and variances.
    pub point: Vec<f64>,
    /// Which variances stand at their bounds: lower, upper.
    pub at_bounds: Vec<(bool, bool)>,
    /// `f` of the likelihood.
    pub value: f64,
    /// `f` and the prior, which was minimised.
    objective: f64,
    pub converged: bool,
    pub evaluations: usize,
}

/// The likelihood of some outputs with the coordinates it is minimised in.
pub(super) struct Problem<'a> {
    likelihood: Likelihood<'a>,
    coordinates: Coordinates,
    /// The weight of the prior on the poles over the number of samples.
    prior: f64,
    stop: &'a dyn Stop,
}

impl<'a> Problem<'a> {
    /// `largest` are the variances that the covariances admit (outputs, inputs).
    pub fn new(
        lags: &[EivLags],
        spectrum: &'a Spectrum,
        largest: &[f64],
        prior: f64,
        stop: &'a dyn Stop,
    ) -> Result<Self, IdentError> {
        Ok(Self {
            likelihood: Likelihood::new(lags, spectrum)?,
            coordinates: Coordinates::new(Layout::new(lags)?, largest),
            prior,
            stop,
        })
    }

    /// The lowest end of the descents from the best of the points; `None` without any usable. Where
    /// the work is to end, what it gives means nothing.
    pub fn solve(&mut self, points: &[Vec<f64>], always: usize) -> Option<Refined> {
        let mut scratch = vec![0.0; self.likelihood.parameters()];
        let mut gradient = scratch.clone();
        let reflections = self.coordinates.reflections();
        let stop = self.stop;
        let mut ranked: Vec<(f64, Vec<f64>)> = points
            .iter()
            .enumerate()
            .take_while(|_| !stop.is_stopped())
            .map(|(index, point)| {
                let x = self.coordinates.start(point);
                self.coordinates.point(&x, &mut scratch, None);
                let value = self.likelihood.evaluate(&scratch, &mut gradient);
                let prior: f64 = reflections.iter().map(|&k| pole_prior(x[k]).0).sum();
                let value = value + self.prior * prior;
                // The first points are followed whatever their value.
                let rank = if index < always {
                    f64::NEG_INFINITY
                } else {
                    value
                };
                (
                    if value.is_finite() {
                        rank
                    } else {
                        f64::INFINITY
                    },
                    x,
                )
            })
            .filter(|(value, _)| *value < f64::INFINITY)
            .collect();
        ranked.sort_by(|a, b| a.0.total_cmp(&b.0));
        let followed = ranked.into_iter().take(FOLLOWED.max(always + 2));
        let ends = followed.map(|(_, x)| self.descend(x));
        ends.min_by(|a, b| a.objective.total_cmp(&b.objective))
    }

    /// Descends from `x`; the metric is twice the information a sample, the Hessian of `f` to
    /// expect at the estimate.
    fn descend(&mut self, mut x: Vec<f64>) -> Refined {
        let Self {
            likelihood,
            coordinates,
            prior,
            stop,
        } = self;
        let count = x.len();
        let mut point = vec![0.0; count];
        let mut inner = point.clone();
        let mut jacobian = DMatrix::identity(count, count);
        let reflections = coordinates.reflections();
        let (mut objective, mut converged, mut evaluations) = (f64::INFINITY, false, 0);
        for _ in 0..ROUNDS {
            if stop.is_stopped() {
                break;
            }
            coordinates.point(&x, &mut point, Some(&mut jacobian));
            let metric = likelihood.information(&point).ok().map(|information| {
                let mut metric = jacobian.tr_mul(&(information * &jacobian)) * 2.0;
                for index in 0..count {
                    metric[(index, index)] *= 1.0 + RIDGE;
                    if index >= coordinates.layout.coefficients() {
                        metric[(index, index)] += VARIANCE_RIDGE;
                    }
                }
                for &index in &reflections {
                    metric[(index, index)] += *prior * pole_prior_curvature(x[index]);
                }
                metric
            });
            let (lower, upper) = (coordinates.lower.clone(), coordinates.upper.clone());
            let end = STEP.minimise(&x, &lower, &upper, metric.as_ref(), |x, gradient| {
                if stop.is_stopped() {
                    // No step is taken there, so the descent ends.
                    return f64::INFINITY;
                }
                coordinates.point(x, &mut point, Some(&mut jacobian));
                let value = likelihood.evaluate(&point, &mut inner);
                let full = DMatrix::from_column_slice(1, count, &inner) * &jacobian;
                gradient.copy_from_slice(full.as_slice());
                let mut objective = value;
                for &index in &reflections {
                    let (value, slope) = pole_prior(x[index]);
                    objective += *prior * value;
                    gradient[index] += *prior * slope;
                }
                objective
            });
            evaluations += end.evaluations;
            (x, objective, converged) = (end.x, end.value, end.converged);
            if converged {
                break;
            }
        }
        coordinates.point(&x, &mut point, None);
        let value = likelihood.evaluate(&point, &mut inner);
        let at_bounds = (coordinates.layout.coefficients()..count)
            .map(|index| {
                let (lower, upper) = (coordinates.lower[index], coordinates.upper[index]);
                // A thousandth of the variance: the descent may stop short of the bound.
                (x[index] < lower + 1e-3, x[index] > upper - 1e-3)
            })
            .collect();
        Refined {
            point,
            at_bounds,
            value,
            objective,
            converged,
            evaluations,
        }
    }
}

/// `-ln(1 - k^2)` of a reflection coefficient `k = tanh x`, and its derivative by `x`.
fn pole_prior(x: f64) -> (f64, f64) {
    // ln cosh without overflow.
    let size = x.abs();
    let log_cosh = size + (-2.0 * size).exp().ln_1p() - std::f64::consts::LN_2;
    (2.0 * log_cosh, 2.0 * x.tanh())
}

/// The curvature of the parabola that touches the prior at `x` and lies above it everywhere.
fn pole_prior_curvature(x: f64) -> f64 {
    if x.abs() < 1e-3 {
        2.0
    } else {
        2.0 * x.tanh() / x
    }
}
