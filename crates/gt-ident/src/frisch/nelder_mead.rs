//! The minimum of a function of several variables without derivatives.

use nalgebra::DVector;

/// When a search ends.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Limits {
    /// The edge of the first simplex.
    pub step: f64,
    /// The size of the simplex, in every coordinate, below which the search ends.
    pub tolerance: f64,
    /// Evaluations of the function.
    pub evaluations: usize,
}

type Vertex = (DVector<f64>, f64);

/// The minimum of `f` by the simplex method of Nelder and Mead (1965), with the
/// dimension-dependent coefficients of Gao and Han (2012) and one restart from the point found.
///
/// Infinite values are allowed. Returns the point and its value.
pub(crate) fn nelder_mead(
    f: impl Fn(&DVector<f64>) -> f64,
    start: &DVector<f64>,
    limits: Limits,
) -> Vertex {
    let first = search(&f, start, limits);
    // A simplex that has collapsed away from a minimum moves on from a fresh one.
    let second = search(&f, &first.0, limits);
    if second.1 < first.1 { second } else { first }
}

fn search(f: &impl Fn(&DVector<f64>) -> f64, start: &DVector<f64>, limits: Limits) -> Vertex {
    let n = start.len();
    let dimension = n.max(2) as f64;
    let (expand, contract, shrink) = (
        1.0 + 2.0 / dimension,
        0.75 - 0.5 / dimension,
        1.0 - 1.0 / dimension,
    );
    let mut used = 0;
    let mut evaluate = |x: DVector<f64>| {
        used += 1;
        let value = f(&x);
        let value = if value.is_nan() { f64::INFINITY } else { value };
        ((x, value), used)
    };
    let mut simplex = vec![evaluate(start.clone()).0];
    for axis in 0..n {
        let mut x = start.clone();
        x[axis] += limits.step;
        simplex.push(evaluate(x).0);
    }
    let mut spent = n + 1;
    while spent < limits.evaluations && n > 0 {
        simplex.sort_by(|a, b| a.1.total_cmp(&b.1));
        let size = simplex[1..]
            .iter()
            .map(|vertex| (&vertex.0 - &simplex[0].0).amax())
            .fold(0.0, f64::max);
        if size <= limits.tolerance {
            break;
        }
        let sum = simplex[..n]
            .iter()
            .fold(DVector::zeros(n), |sum, vertex| sum + &vertex.0);
        let centre = sum / n as f64;
        let away = &centre - &simplex[n].0;
        let mut try_at = |factor: f64| {
            let (vertex, count) = evaluate(&centre + &away * factor);
            spent = count;
            vertex
        };
        let reflected = try_at(1.0);
        let replacement = if reflected.1 < simplex[0].1 {
            let expanded = try_at(expand);
            Some(if expanded.1 < reflected.1 {
                expanded
            } else {
                reflected
            })
        } else if reflected.1 < simplex[n - 1].1 {
            Some(reflected)
        } else {
            let outside = reflected.1 < simplex[n].1;
            let contracted = try_at(if outside { contract } else { -contract });
            (contracted.1 < reflected.1.min(simplex[n].1)).then_some(contracted)
        };
        if let Some(vertex) = replacement {
            simplex[n] = vertex;
            continue;
        }
        let best = simplex[0].0.clone();
        for vertex in &mut simplex[1..] {
            let (moved, count) = evaluate(&best + (&vertex.0 - &best) * shrink);
            *vertex = moved;
            spent = count;
        }
    }
    simplex.sort_by(|a, b| a.1.total_cmp(&b.1));
    simplex.swap_remove(0)
}

#[cfg(test)]
mod tests {
    use super::{Limits, nelder_mead};
    use nalgebra::DVector;

    const LIMITS: Limits = Limits {
        step: 0.5,
        tolerance: 1e-10,
        evaluations: 5000,
    };

    /// Rosenbrock's valley from his own start, (-1.2, 1), ends at (1, 1).
    #[test]
    fn published_rosenbrock() {
        let valley = |x: &DVector<f64>| 100.0 * (x[1] - x[0] * x[0]).powi(2) + (1.0 - x[0]).powi(2);
        let (x, value) = nelder_mead(valley, &DVector::from_row_slice(&[-1.2, 1.0]), LIMITS);
        assert!((x - DVector::from_row_slice(&[1.0, 1.0])).amax() < 1e-6);
        assert!(value < 1e-12);
    }

    /// A tilted quadratic of 1 to 6 variables.
    #[test]
    fn quadratics_of_several_dimensions() {
        for n in 1..=6 {
            let target = DVector::from_fn(n, |k, _| 0.3 * k as f64 - 0.4);
            let bowl = |x: &DVector<f64>| {
                let d = x - &target;
                d.iter()
                    .enumerate()
                    .map(|(k, v)| (1.0 + k as f64) * v * v)
                    .sum::<f64>()
                    + 0.5 * d.sum().powi(2)
            };
            let (x, _) = nelder_mead(bowl, &DVector::zeros(n), LIMITS);
            assert!((&x - &target).amax() < 1e-5, "{n}: {x}");
        }
    }

    /// Walls of infinity and not-a-number are stayed away from; no variable means no search.
    #[test]
    fn walls_and_nothing_to_search() {
        let wall = |x: &DVector<f64>| {
            if x[0] < 0.2 {
                f64::INFINITY
            } else if x[1] < -1.0 {
                f64::NAN
            } else {
                x.norm_squared()
            }
        };
        let (x, _) = nelder_mead(wall, &DVector::from_row_slice(&[1.0, 1.0]), LIMITS);
        assert!((x - DVector::from_row_slice(&[0.2, 0.0])).amax() < 1e-4);
        let (none, value) = nelder_mead(|_| 3.0, &DVector::zeros(0), LIMITS);
        assert!(none.is_empty() && (value - 3.0).abs() < 1e-15);
    }
}
