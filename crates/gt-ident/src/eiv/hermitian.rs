//! Small Hermitian positive definite matrices on plain slices, row by row, without allocation: the
//! likelihood needs thousands of them, a few entries wide.

use nalgebra::Complex;

/// A complex number.
pub(crate) type C64 = Complex<f64>;

/// Zero.
pub(crate) const ZERO: C64 = Complex { re: 0.0, im: 0.0 };

/// `out (rows x columns) = left (rows x inner) right (inner x columns)`.
pub(crate) fn multiply(out: &mut [C64], left: &[C64], right: &[C64], inner: usize, columns: usize) {
    for (out, left) in out.chunks_exact_mut(columns).zip(left.chunks_exact(inner)) {
        out.fill(ZERO);
        for (&factor, right) in left.iter().zip(right.chunks_exact(columns)) {
            if factor != ZERO {
                for (out, &value) in out.iter_mut().zip(right) {
                    *out += factor * value;
                }
            }
        }
    }
}

/// `out (rows x columns) = left (rows x inner) right^H`, `right (columns x inner)`.
pub(crate) fn multiply_adjoint(
    out: &mut [C64],
    left: &[C64],
    right: &[C64],
    inner: usize,
    columns: usize,
) {
    for (out, left) in out.chunks_exact_mut(columns).zip(left.chunks_exact(inner)) {
        for (out, right) in out.iter_mut().zip(right.chunks_exact(inner)) {
            *out = left.iter().zip(right).map(|(a, b)| a * b.conj()).sum();
        }
    }
}

/// The inverse of a Hermitian positive definite matrix and the logarithm of its determinant, by
/// Cholesky's factorisation; `matrix (n x n)` is overwritten with the factor, and only its lower
/// triangle is read. `None` where it is not positive definite.
pub(crate) fn invert(matrix: &mut [C64], inverse: &mut [C64], n: usize) -> Option<f64> {
    if n == 1 {
        let value = matrix[0].re;
        if !(value > 0.0 && value.is_finite()) {
            return None;
        }
        inverse[0] = C64::new(1.0 / value, 0.0);
        return Some(value.ln());
    }
    let mut ln_det = 0.0;
    for j in 0..n {
        let row: f64 = matrix[j * n..j * n + j].iter().map(C64::norm_sqr).sum();
        let pivot = matrix[j * n + j].re - row;
        if !(pivot > 0.0 && pivot.is_finite()) {
            return None;
        }
        ln_det += pivot.ln();
        let root = pivot.sqrt();
        matrix[j * n + j] = C64::new(root, 0.0);
        for i in j + 1..n {
            let mut value = matrix[i * n + j];
            for k in 0..j {
                value -= matrix[i * n + k] * matrix[j * n + k].conj();
            }
            matrix[i * n + j] = value / root;
        }
    }
    // L^-1 in place of L, then L^-H L^-1.
    for j in 0..n {
        matrix[j * n + j].re = 1.0 / matrix[j * n + j].re;
        for i in j + 1..n {
            let mut value = ZERO;
            for k in j..i {
                value -= matrix[i * n + k] * matrix[k * n + j];
            }
            matrix[i * n + j] = value / matrix[i * n + i].re;
        }
    }
    for i in 0..n {
        for j in 0..=i {
            let value: C64 = (i..n)
                .map(|k| matrix[k * n + i].conj() * matrix[k * n + j])
                .sum();
            inverse[i * n + j] = value;
            inverse[j * n + i] = value.conj();
        }
    }
    Some(ln_det)
}
