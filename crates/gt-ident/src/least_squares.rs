//! Plain least squares by Householder QR.

use faer::Mat;
use gt_core::la::as_faer;
use nalgebra::DMatrix;

/// The largest condition of a column-scaled regressor matrix that is taken as full rank. Beyond
/// it fewer than four digits of a coefficient are right even with exact data.
pub const CONDITION_LIMIT: f64 = 1e12;

/// The solution of `min |design x - targets|`, column by column.
pub(crate) struct LeastSquares {
    /// `p x k`.
    pub coefficients: DMatrix<f64>,
    /// The residuals in rotated coordinates (`k` columns): an orthogonal map of the true ones, so
    /// that their inner products are those of the residuals.
    pub residuals: DMatrix<f64>,
    /// Condition of the column-scaled design matrix; infinite where a column is zero.
    pub condition: f64,
    /// The column that a rank decision blames: the first that its predecessors explain.
    pub weakest: usize,
}

impl LeastSquares {
    /// Solves for `design (T x p)`, `targets (T x k)` with `T > p`.
    ///
    /// The triangular factor of `[design | targets]` holds everything; the normal equations, which
    /// square the condition, are never formed.
    pub fn new(design: &DMatrix<f64>, targets: &DMatrix<f64>) -> Self {
        let (p, k) = (design.ncols(), targets.ncols());
        let mut stacked = DMatrix::zeros(design.nrows(), p + k);
        let mut scales = Vec::with_capacity(p);
        for (mut column, source) in stacked.column_iter_mut().zip(design.column_iter()) {
            let norm = scaled_norm(source.iter().copied());
            let scale = if norm > 0.0 && norm.is_finite() {
                norm
            } else {
                1.0
            };
            column.zip_apply(&source, |out, value| *out = value / scale);
            scales.push(scale);
        }
        stacked.columns_mut(p, k).copy_from(targets);
        let factor = triangular_factor(&stacked);
        let square = factor.view((0, 0), (p, p)).into_owned();
        let condition = condition(&square);
        let mut coefficients = factor.view((0, p), (p, k)).into_owned();
        if !square.solve_upper_triangular_mut(&mut coefficients) {
            coefficients.fill(f64::NAN);
        }
        for (mut row, scale) in coefficients.row_iter_mut().zip(&scales) {
            row /= *scale;
        }
        let residuals = factor.view((p, p), (factor.nrows() - p, k)).into_owned();
        Self {
            coefficients,
            residuals,
            condition,
            weakest: weakest(&square),
        }
    }

    /// Whether the coefficients may be used.
    pub fn full_rank(&self) -> bool {
        self.condition <= CONDITION_LIMIT
    }
}

/// `R` of a QR factorisation (`min(rows, columns) x columns`).
pub(crate) fn triangular_factor(matrix: &DMatrix<f64>) -> DMatrix<f64> {
    let qr = as_faer(matrix).qr();
    gt_core::la::to_nalgebra(qr.thin_R())
}

/// The Euclidean norm without overflow.
pub(crate) fn scaled_norm(values: impl Iterator<Item = f64> + Clone) -> f64 {
    let largest = values
        .clone()
        .fold(0.0, |most: f64, value| most.max(value.abs()));
    if largest == 0.0 || !largest.is_finite() {
        return largest;
    }
    largest
        * values
            .map(|value| (value / largest).powi(2))
            .sum::<f64>()
            .sqrt()
}

fn condition(square: &DMatrix<f64>) -> f64 {
    if !square.iter().all(|value| value.is_finite()) {
        return f64::INFINITY;
    }
    if square.is_empty() {
        return 1.0;
    }
    let owned: Mat<f64> = as_faer(square).to_owned();
    match owned.singular_values() {
        Ok(values) => {
            let largest = values.iter().copied().fold(0.0, f64::max);
            let smallest = values.iter().copied().fold(f64::INFINITY, f64::min);
            if smallest > 0.0 {
                largest / smallest
            } else {
                f64::INFINITY
            }
        }
        Err(_) => f64::INFINITY,
    }
}

/// The columns have unit norm, so `|R_kk|` is the part of column `k` that the columns before it
/// leave unexplained.
fn weakest(square: &DMatrix<f64>) -> usize {
    let diagonal = square.diagonal();
    if let Some(first) = diagonal
        .iter()
        .position(|value| value.abs() <= 10.0 / CONDITION_LIMIT)
    {
        return first;
    }
    let pairs = diagonal.iter().enumerate();
    pairs
        .min_by(|a, b| a.1.abs().total_cmp(&b.1.abs()))
        .map_or(0, |(index, _)| index)
}
