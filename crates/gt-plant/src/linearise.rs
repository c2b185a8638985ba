//! Jacobians by central differences.

use nalgebra::SMatrix;

/// Relative step: the cube root of the rounding unit balances truncation against rounding.
const RELATIVE_STEP: f64 = 6e-6;

/// The Jacobian (N x N) of `function` at `x`; `scale` is the size of each unknown.
pub fn jacobian<const N: usize>(
    function: impl Fn(&[f64; N]) -> [f64; N],
    x: &[f64; N],
    scale: &[f64; N],
) -> SMatrix<f64, N, N> {
    let mut matrix = SMatrix::zeros();
    for column in 0..N {
        let step = RELATIVE_STEP * scale[column];
        let (mut up, mut down) = (*x, *x);
        up[column] += step;
        down[column] -= step;
        let (high, low) = (function(&up), function(&down));
        for row in 0..N {
            matrix[(row, column)] = (high[row] - low[row]) / (2.0 * step);
        }
    }
    matrix
}
