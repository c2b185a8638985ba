//! The least-squares cost of one row as a distance.

use nalgebra::{DMatrix, DVector};

use crate::least_squares::{scaled_norm, triangular_factor};

/// `|design theta - target|^2 = rss + |w|^2` with `w = R S (theta - least_squares)`, where `S`
/// scales the columns and `R` is the triangular factor of the scaled design. In `w` the cost is
/// round, so that the condition of the regressors is never squared.
pub(crate) struct RowCost {
    factor: DMatrix<f64>,
    scales: DVector<f64>,
    /// The unconstrained minimiser `(p)`.
    pub least_squares: DVector<f64>,
    /// Its residual sum of squares.
    pub rss: f64,
}

impl RowCost {
    /// For `design (T x p)` of full rank with `T > p` and `target (T x 1)`. `None` where a number
    /// overflows or the factor is singular.
    pub fn new(design: &DMatrix<f64>, target: &DMatrix<f64>) -> Option<Self> {
        let p = design.ncols();
        let mut stacked = DMatrix::zeros(design.nrows(), p + 1);
        let scales = DVector::from_fn(p, |column, _| {
            scaled_norm(design.column(column).iter().copied())
        });
        for (column, scale) in scales.iter().enumerate() {
            stacked.set_column(column, &(design.column(column) / *scale));
        }
        stacked.set_column(p, &target.column(0));
        let all = triangular_factor(&stacked);
        let factor = all.view((0, 0), (p, p)).into_owned();
        let right = all.view((0, p), (p, 1)).into_owned().column(0).into_owned();
        let solution = factor.solve_upper_triangular(&right)?;
        let least_squares = solution.component_div(&scales);
        let rss = all.view((p, p), (all.nrows() - p, 1)).norm_squared();
        let finite = least_squares.iter().all(|value| value.is_finite()) && rss.is_finite();
        finite.then_some(Self {
            factor,
            scales,
            least_squares,
            rss,
        })
    }

    /// `|w|^2` at `theta`: what it costs beyond least squares.
    pub fn excess(&self, theta: &DVector<f64>) -> f64 {
        let moved = (theta - &self.least_squares).component_mul(&self.scales);
        (&self.factor * moved).norm_squared()
    }

    /// `c` with `gradient' (theta - least_squares) = c' w`.
    pub fn direction(&self, gradient: &DVector<f64>) -> Option<DVector<f64>> {
        self.factor
            .tr_solve_upper_triangular(&gradient.component_div(&self.scales))
    }

    /// `theta` at `w`.
    pub fn point(&self, w: &DVector<f64>) -> Option<DVector<f64>> {
        let moved = self.factor.solve_upper_triangular(w)?;
        Some(&self.least_squares + moved.component_div(&self.scales))
    }
}
