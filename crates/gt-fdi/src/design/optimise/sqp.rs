//! Descent by sequential quadratic programming.

use gt_core::qp::QuadraticProgram;
use nalgebra::{DMatrix, DVector};

use super::energy_ratio::EnergyRatio;
use super::sections::{Sections, polytope};

/// Steps after which a descent ends.
const ITERATIONS: usize = 200;
/// The share of the predicted decrease that a step has to make (Armijo).
const SUFFICIENT: f64 = 1e-4;
/// Halvings of a step before the descent ends.
const HALVINGS: usize = 40;
/// Predicted decrease of the logarithm at which a descent ends.
const STATIONARY: f64 = 1e-13;
/// The share of the model's curvature that Powell's damping leaves.
const DAMPING: f64 = 0.2;

/// Where a descent ended.
pub(super) struct Local {
    pub(super) sections: Sections,
    pub(super) value: f64,
    pub(super) evaluations: usize,
}

/// The logarithm of the ratio with its gradient: V spans decades, and the same poles minimise it.
struct Point {
    sections: Sections,
    value: f64,
    gradient: DVector<f64>,
}

impl Point {
    fn at(ratio: &EnergyRatio, sections: Sections) -> Self {
        let (value, gradient) = ratio.value_and_gradient(&sections);
        Self {
            sections,
            gradient: gradient / value,
            value: value.ln(),
        }
    }

    fn is_finite(&self) -> bool {
        self.value.is_finite() && self.gradient.iter().all(|value| value.is_finite())
    }
}

/// Goes down from `start` inside the polytope of the radius: steps from quadratic programmes with
/// a BFGS Hessian damped as Powell does (Lecture Notes in Mathematics 630, 1978), shortened until
/// they descend enough. The constraints are linear and the steps at most full, so every iterate has
/// its poles within the radius.
pub(super) fn descend(ratio: &EnergyRatio, radius: f64, start: Sections) -> Local {
    let order = ratio.order();
    let (g, h) = polytope(order, radius);
    let mut point = Point::at(ratio, start.clamped(radius));
    let mut evaluations = 1;
    let mut hessian = initial(&point.gradient);
    let mut updated = false;
    for _ in 0..ITERATIONS {
        if !point.is_finite() {
            break;
        }
        let Some(step) = programme(&hessian, &point, &g, &h) else {
            if updated {
                hessian = initial(&point.gradient);
                updated = false;
                continue;
            }
            break;
        };
        let slope = point.gradient.dot(&step);
        if slope >= -STATIONARY {
            break;
        }
        let (next, spent) = search(ratio, radius, &point, &step, slope);
        evaluations += spent;
        let Some(next) = next else {
            if updated {
                hessian = initial(&point.gradient);
                updated = false;
                continue;
            }
            break;
        };
        let moved = next.sections.coefficients() - point.sections.coefficients();
        let change = &next.gradient - &point.gradient;
        update(&mut hessian, &moved, change, updated);
        updated = true;
        point = next;
    }
    let value = ratio.value(&point.sections);
    Local {
        sections: point.sections,
        value: if value.is_nan() { f64::INFINITY } else { value },
        evaluations: evaluations + 1,
    }
}

/// A Hessian whose first step is about as long as one.
fn initial(gradient: &DVector<f64>) -> DMatrix<f64> {
    let size = gradient.norm().max(1e-6);
    DMatrix::identity(gradient.len(), gradient.len()) * size
}

/// The step of the quadratic programme; `None` when its solver gives up.
fn programme(
    hessian: &DMatrix<f64>,
    point: &Point,
    g: &DMatrix<f64>,
    h: &DVector<f64>,
) -> Option<DVector<f64>> {
    // Scaled so that the solver's tolerances see a Hessian of order 1.
    let size = hessian.amax();
    let room = h - g * point.sections.coefficients();
    let none = DVector::from_element(room.len(), f64::NEG_INFINITY);
    let room = room.map(|value| value.max(0.0));
    QuadraticProgram::new(hessian / size, &point.gradient / size)
        .and_then(|programme| programme.bounds(g.clone(), none, room))
        .and_then(|programme| programme.solve())
        .ok()
        .map(|solution| solution.x)
}

/// The longest of the halved steps that descends enough, with the evaluations spent.
fn search(
    ratio: &EnergyRatio,
    radius: f64,
    point: &Point,
    step: &DVector<f64>,
    slope: f64,
) -> (Option<Point>, usize) {
    let mut length = 1.0;
    for spent in 1..=HALVINGS {
        let to = Sections::new(point.sections.coefficients() + step * length);
        let next = Point::at(ratio, to.clamped(radius));
        let enough = next.value <= point.value + SUFFICIENT * length * slope;
        if enough && next.is_finite() {
            return (Some(next), spent);
        }
        length /= 2.0;
    }
    (None, HALVINGS)
}

/// The BFGS update with Powell's damping; the first one sets the scale.
fn update(hessian: &mut DMatrix<f64>, moved: &DVector<f64>, change: DVector<f64>, updated: bool) {
    let order = moved.len();
    let along = moved.dot(&change);
    if moved.norm() == 0.0 {
        return;
    }
    if !updated && along > 0.0 {
        *hessian = DMatrix::identity(order, order) * (change.norm_squared() / along);
    }
    let carried = &*hessian * moved;
    let curvature = moved.dot(&carried);
    let share = if along >= DAMPING * curvature {
        1.0
    } else {
        (1.0 - DAMPING) * curvature / (curvature - along)
    };
    let damped = change * share + &carried * (1.0 - share);
    let next = &*hessian - &carried * carried.transpose() / curvature
        + &damped * damped.transpose() / moved.dot(&damped);
    let next = 0.5 * (&next + next.transpose());
    if next.iter().all(|value| value.is_finite()) {
        *hessian = next;
    }
}
