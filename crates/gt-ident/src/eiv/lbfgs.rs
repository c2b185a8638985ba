//! Limited-memory quasi-Newton minimisation within bounds.

use std::collections::VecDeque;

use nalgebra::{DMatrix, DVector};

/// Minimises a smooth function of few variables, some of them bounded.
///
/// Limited-memory BFGS (Nocedal and Wright, Numerical Optimization, 2006, algorithm 7.4) on the
/// variables that are free, projected on the bounds (Bertsekas 1982); the line search bisects
/// towards the weak Wolfe conditions (Lewis and Overton 2013). A metric, if given, takes the place
/// of the scaled identity as first guess of the Hessian.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Lbfgs {
    /// Pairs of steps kept.
    pub memory: usize,
    /// Most iterations.
    pub iterations: usize,
    /// Converged where the decrease predicted is below this, relative to `1 + |f|`.
    pub tolerance: f64,
    /// Largest change of one variable in a step.
    pub longest_step: f64,
}

impl Default for Lbfgs {
    fn default() -> Self {
        Self {
            memory: 12,
            iterations: 200,
            tolerance: 1e-13,
            longest_step: f64::INFINITY,
        }
    }
}

/// The end of a minimisation.
#[derive(Debug, Clone, PartialEq)]
pub struct Minimum {
    /// The variables.
    pub x: Vec<f64>,
    /// The value there; never above that of the start.
    pub value: f64,
    /// Iterations made.
    pub iterations: usize,
    /// Evaluations of the function and its gradient.
    pub evaluations: usize,
    /// Whether the tolerance was met (and not only the number of iterations used up).
    pub converged: bool,
}

/// Sufficient decrease and curvature of the line search.
const DECREASE: f64 = 1e-4;
const CURVATURE: f64 = 0.9;
const TRIALS: usize = 40;

struct Pair {
    step: DVector<f64>,
    change: DVector<f64>,
}

/// Value and gradient at a place.
#[derive(Clone)]
struct Place {
    x: DVector<f64>,
    value: f64,
    gradient: DVector<f64>,
}

impl Lbfgs {
    /// Minimises `function`, which writes its gradient and returns its value (infinite or not a
    /// number where it is not defined, but finite at the start), with `lower <= x <= upper`.
    /// The slices and the gradient have one length; the start is moved inside the bounds.
    pub fn minimise(
        &self,
        start: &[f64],
        lower: &[f64],
        upper: &[f64],
        metric: Option<&DMatrix<f64>>,
        mut function: impl FnMut(&[f64], &mut [f64]) -> f64,
    ) -> Minimum {
        let mut evaluations = 0;
        let mut evaluate = |x: DVector<f64>| {
            evaluations += 1;
            let mut gradient = DVector::zeros(x.len());
            let value = function(x.as_slice(), gradient.as_mut_slice());
            Place { x, value, gradient }
        };
        let inside = |mut x: DVector<f64>| {
            for ((x, low), high) in x.iter_mut().zip(lower).zip(upper) {
                *x = x.max(*low).min(*high);
            }
            x
        };
        let mut here = evaluate(inside(DVector::from_column_slice(start)));
        let mut pairs: VecDeque<Pair> = VecDeque::new();
        let (mut iterations, mut converged) = (0, false);
        while iterations < self.iterations && here.value.is_finite() {
            let free: Vec<bool> = (0..here.x.len())
                .map(|i| {
                    let slope = here.gradient[i];
                    !((here.x[i] <= lower[i] && slope > 0.0)
                        || (here.x[i] >= upper[i] && slope < 0.0))
                })
                .collect();
            let mut direction = direction(&here.gradient, &free, &pairs, metric);
            let mut slope = here.gradient.dot(&direction);
            let descends = slope < 0.0;
            if !descends && !pairs.is_empty() {
                pairs.clear();
                direction = self::direction(&here.gradient, &free, &pairs, metric);
                slope = here.gradient.dot(&direction);
            }
            let promising = -0.5 * slope > self.tolerance * (1.0 + here.value.abs());
            if !promising {
                converged = true;
                break;
            }
            let longest = direction.amax();
            let first = if pairs.is_empty() && metric.is_none() {
                (1.0 / longest).min(1.0)
            } else {
                1.0
            };
            let limit = self.longest_step / longest;
            iterations += 1;
            let lengths = (first.min(limit), limit);
            match search(&here, &direction, lengths, &inside, &mut evaluate) {
                Some(next) => {
                    let step = &next.x - &here.x;
                    let change = &next.gradient - &here.gradient;
                    if step.dot(&change) > 1e-12 * step.norm() * change.norm() {
                        pairs.push_back(Pair { step, change });
                        if pairs.len() > self.memory {
                            pairs.pop_front();
                        }
                    }
                    here = next;
                }
                None if pairs.is_empty() => {
                    // Not even the metric's own direction descends: rounding decides.
                    converged = true;
                    break;
                }
                None => pairs.clear(),
            }
        }
        Minimum {
            x: here.x.as_slice().to_vec(),
            value: here.value,
            iterations,
            evaluations,
            converged,
        }
    }
}

/// The two loops of the limited-memory recursion on the free variables.
fn direction(
    gradient: &DVector<f64>,
    free: &[bool],
    pairs: &VecDeque<Pair>,
    metric: Option<&DMatrix<f64>>,
) -> DVector<f64> {
    let masked = |source: &DVector<f64>| {
        DVector::from_fn(source.len(), |i, _| if free[i] { source[i] } else { 0.0 })
    };
    let mut d = -masked(gradient);
    let kept: Vec<(DVector<f64>, DVector<f64>, f64)> = pairs
        .iter()
        .map(|pair| (masked(&pair.step), masked(&pair.change)))
        .filter_map(|(step, change)| {
            let product = step.dot(&change);
            (product > 1e-12 * step.norm() * change.norm()).then_some((step, change, product))
        })
        .collect();
    let mut factors = Vec::with_capacity(kept.len());
    for (step, change, product) in kept.iter().rev() {
        let factor = step.dot(&d) / product;
        d.axpy(-factor, change, 1.0);
        factors.push(factor);
    }
    let solved = metric.and_then(|metric| {
        let size = metric.nrows();
        DMatrix::from_fn(size, size, |i, j| match (free[i] && free[j], i == j) {
            (true, _) => metric[(i, j)],
            (false, true) => 1.0,
            (false, false) => 0.0,
        })
        .cholesky()
        .map(|factor| factor.solve(&d))
    });
    if let Some(solved) = solved {
        d = solved;
    } else if let Some((_, change, product)) = kept.last() {
        d *= product / change.norm_squared();
    }
    for ((step, change, product), factor) in kept.iter().zip(factors.iter().rev()) {
        let back = change.dot(&d) / product;
        d.axpy(factor - back, step, 1.0);
    }
    d
}

/// The first place along the projected direction that meets the weak Wolfe conditions, or else
/// the last that decreases enough.
fn search(
    here: &Place,
    direction: &DVector<f64>,
    (first, limit): (f64, f64),
    inside: &impl Fn(DVector<f64>) -> DVector<f64>,
    evaluate: &mut impl FnMut(DVector<f64>) -> Place,
) -> Option<Place> {
    let slope = here.gradient.dot(direction);
    let (mut low, mut high, mut length) = (0.0, f64::INFINITY, first);
    let mut best: Option<Place> = None;
    for _ in 0..TRIALS {
        let aim = &here.x + direction * length;
        let next = inside(aim.clone());
        let projected = next != aim;
        let step = &next - &here.x;
        if step.amax() <= f64::EPSILON * here.x.amax() {
            break;
        }
        let place = evaluate(next);
        let fall = here.gradient.dot(&step).min(0.0);
        if place.value.is_finite() && place.value <= here.value + DECREASE * fall {
            let flat = place.gradient.dot(direction) >= CURVATURE * slope;
            let enough = flat || projected || length >= limit;
            if best.as_ref().is_none_or(|best| place.value <= best.value) {
                best = Some(place);
            }
            if enough {
                break;
            }
            low = length;
            length = if high.is_finite() {
                0.5 * (low + high)
            } else {
                (2.0 * length).min(limit)
            };
        } else {
            if best.is_some() && projected {
                break;
            }
            high = length;
            let excess = place.value - here.value - slope * length;
            let parabola = -0.5 * slope * length * length / excess;
            let width = high - low;
            length = if low == 0.0 && parabola.is_finite() {
                parabola.clamp(0.1 * high, 0.5 * high)
            } else {
                low + 0.5 * width
            };
        }
    }
    best
}
