//! Plain least squares from a triangular factor.

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
    /// Residual sums of squares, one a target.
    pub squares: Vec<f64>,
    /// Condition of the column-scaled design matrix; infinite where a column is zero.
    pub condition: f64,
    /// The targets in the coordinates of the factor (`p x k`), empty where nobody kept them.
    pub rotated: DMatrix<f64>,
    /// The triangular factor of the column-scaled design (`p x p`).
    pub factor: DMatrix<f64>,
    /// What the columns were divided by.
    pub scales: Vec<f64>,
}

impl LeastSquares {
    /// Solves for `design (T x p)`, `targets (T x k)` with `T > p`.
    ///
    /// The triangular factor of `[design | targets]` holds everything; the normal equations, which
    /// square the condition, are never formed.
    pub fn new(design: &DMatrix<f64>, targets: &DMatrix<f64>) -> Self {
        let (p, k) = (design.ncols(), targets.ncols());
        let mut stacked = DMatrix::zeros(design.nrows(), p + k);
        stacked.columns_mut(0, p).copy_from(design);
        stacked.columns_mut(p, k).copy_from(targets);
        Self::from_triangle(&triangular_factor(&stacked), p, 0.0)
    }

    /// Solves from the triangular factor of `[design | targets]`, whose first `p` columns are the
    /// design; `ridge` adds `ridge |column|^2 x^2` for each coefficient to what is minimised.
    pub fn from_triangle(triangle: &DMatrix<f64>, p: usize, ridge: f64) -> Self {
        let k = triangle.ncols() - p;
        let mut square = triangle.view((0, 0), (p, p)).into_owned();
        let scales: Vec<f64> = square
            .column_iter()
            .map(|column| column_scale(column.as_slice()))
            .collect();
        for (mut column, &scale) in square.column_iter_mut().zip(&scales) {
            column /= scale;
        }
        let targets = triangle.columns(p, k).into_owned();
        let (mut factor, mut coefficients) = (square.clone(), targets.rows(0, p).into_owned());
        if ridge > 0.0 {
            let mut stacked = DMatrix::zeros(2 * p, p + k);
            stacked.view_mut((0, 0), (p, p)).copy_from(&square);
            stacked.view_mut((0, p), (p, k)).copy_from(&coefficients);
            let root = ridge.sqrt();
            for index in 0..p {
                stacked[(p + index, index)] = root;
            }
            let joint = triangular_factor(&stacked);
            factor = joint.view((0, 0), (p, p)).into_owned();
            coefficients = joint.view((0, p), (p, k)).into_owned();
        }
        let rotated = coefficients.clone();
        if !factor.solve_upper_triangular_mut(&mut coefficients) {
            coefficients.fill(f64::NAN);
        }
        let mut rest = targets;
        if ridge > 0.0 {
            let explained = &square * &coefficients;
            let mut top = rest.rows_mut(0, p);
            top -= explained;
        } else {
            rest.rows_mut(0, p).fill(0.0);
        }
        let squares = rest.column_iter().map(|each| each.norm_squared()).collect();
        for (mut row, scale) in coefficients.row_iter_mut().zip(&scales) {
            row /= *scale;
        }
        Self {
            coefficients,
            squares,
            condition: condition(&factor),
            rotated,
            factor,
            scales,
        }
    }

    /// Whether the coefficients may be used.
    pub fn full_rank(&self) -> bool {
        self.condition <= CONDITION_LIMIT
    }

    /// The column that a rank decision blames: the first that its predecessors explain.
    pub fn weakest(&self) -> usize {
        weakest(&self.factor)
    }

    /// The columns that those before them explain.
    pub fn dependent(&self) -> Vec<usize> {
        let diagonal = self.factor.diagonal();
        let pairs = diagonal.iter().enumerate();
        pairs
            .filter(|(_, value)| value.abs() <= 10.0 / CONDITION_LIMIT)
            .map(|(index, _)| index)
            .collect()
    }

    /// `(design' design)^-1`; with a ridge the covariance of its coefficients at unit variance,
    /// `(D + S)^-1 D (D + S)^-1` with `D = design' design` and `S` the ridge.
    pub fn unit_covariance(&self, ridge: f64) -> DMatrix<f64> {
        let p = self.factor.ncols();
        let mut inverse = DMatrix::identity(p, p);
        if !self.factor.solve_upper_triangular_mut(&mut inverse) {
            inverse.fill(f64::NAN);
        }
        let full = &inverse * inverse.transpose();
        let mut covariance = if ridge > 0.0 {
            &full - &full * ridge * &full
        } else {
            full
        };
        for (index, scale) in self.scales.iter().enumerate() {
            covariance.row_mut(index).unscale_mut(*scale);
            covariance.column_mut(index).unscale_mut(*scale);
        }
        covariance
    }
}

/// `R` of a QR factorisation (`min(rows, columns) x columns`).
pub(crate) fn triangular_factor(matrix: &DMatrix<f64>) -> DMatrix<f64> {
    let qr = as_faer(matrix).qr();
    gt_core::la::to_nalgebra(qr.thin_R())
}

fn column_scale(column: &[f64]) -> f64 {
    let norm = scaled_norm(column.iter().copied());
    if norm > 0.0 && norm.is_finite() {
        norm
    } else {
        1.0
    }
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

/// The ratio of the extreme singular values.
pub(crate) fn condition(square: &DMatrix<f64>) -> f64 {
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
