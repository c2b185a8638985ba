//! Free coordinates of a stable errors-in-variables model.

use nalgebra::DMatrix;

use super::layout::Layout;
use super::reflection::{stabilised, step_down, step_up};

/// Reflection coefficients stay below `tanh(8) = 1 - 2.3e-7`.
const REFLECTION_LIMIT: f64 = 8.0;
/// Variances lie between these parts of the largest that the covariances admit.
pub(super) const VARIANCE_RANGE: (f64, f64) = (1e-4, 1.2);
/// The least variance of a starting point, in the same measure.
const START_VARIANCE: f64 = 2e-4;

/// The optimiser's coordinates `x` of a point (coefficients, variances): for each row
/// `atanh(reflection coefficient)`, then the input coefficients as they are; logarithms of the
/// variances. Every `x` within the bounds is a stable model.
#[derive(Debug, Clone)]
pub(super) struct Coordinates {
    pub layout: Layout,
    pub lower: Vec<f64>,
    pub upper: Vec<f64>,
}

impl Coordinates {
    /// Coordinates bounded by the largest admissible variances (outputs, then inputs).
    pub fn new(layout: Layout, largest: &[f64]) -> Self {
        let mut lower = Vec::with_capacity(layout.len());
        let mut upper = Vec::with_capacity(layout.len());
        for entry in &layout.entries {
            let limit = if entry.channel < layout.outputs {
                REFLECTION_LIMIT
            } else {
                f64::INFINITY
            };
            lower.push(-limit);
            upper.push(limit);
        }
        for largest in largest {
            lower.push((VARIANCE_RANGE.0 * largest).ln());
            upper.push((VARIANCE_RANGE.1 * largest).ln());
        }
        Self {
            layout,
            lower,
            upper,
        }
    }

    /// Where the reflection coefficients stand among the coordinates.
    pub fn reflections(&self) -> Vec<usize> {
        let rows = self.layout.lags.iter().zip(self.layout.row_starts());
        rows.flat_map(|(lags, start)| start..start + lags.order())
            .collect()
    }

    /// The point at `x`, and its Jacobian (square) where asked for.
    pub fn point(&self, x: &[f64], point: &mut [f64], mut jacobian: Option<&mut DMatrix<f64>>) {
        point.copy_from_slice(x);
        if let Some(jacobian) = jacobian.as_deref_mut() {
            jacobian.fill_with_identity();
        }
        for (lags, start) in self.layout.lags.iter().zip(self.layout.row_starts()) {
            let range = start..start + lags.order();
            let k: Vec<f64> = x[range.clone()].iter().map(|value| value.tanh()).collect();
            let (a, inner) = step_up(&k);
            point[range].copy_from_slice(&a);
            if let Some(jacobian) = jacobian.as_deref_mut() {
                let mut block = jacobian.view_mut((start, start), (k.len(), k.len()));
                block.copy_from(&inner);
                for (mut column, &x) in block.column_iter_mut().zip(&x[start..]) {
                    // 1 - tanh^2 without cancellation.
                    column *= x.cosh().powi(-2);
                }
            }
        }
        let first = self.layout.coefficients();
        for index in first..x.len() {
            point[index] = x[index].exp();
            if let Some(jacobian) = jacobian.as_deref_mut() {
                jacobian[(index, index)] = point[index];
            }
        }
    }

    /// Coordinates of a starting point: unstable rows are made stable, variances moved inside.
    pub fn start(&self, point: &[f64]) -> Vec<f64> {
        let mut x = point.to_vec();
        for (lags, start) in self.layout.lags.iter().zip(self.layout.row_starts()) {
            let a = &point[start..start + lags.order()];
            let stable = stabilised(a).unwrap_or_else(|| a.to_vec());
            let k = step_down(&stable).unwrap_or_else(|| vec![0.0; a.len()]);
            for (x, k) in x[start..].iter_mut().zip(k) {
                *x = k.atanh();
            }
        }
        for index in self.layout.coefficients()..x.len() {
            let least = self.lower[index] + (START_VARIANCE / VARIANCE_RANGE.0).ln();
            let value = point[index].ln();
            x[index] = if value.is_finite() {
                value.max(least)
            } else {
                least
            };
        }
        for ((x, lower), upper) in x.iter_mut().zip(&self.lower).zip(&self.upper) {
            *x = x.clamp(*lower, *upper);
        }
        x
    }
}
