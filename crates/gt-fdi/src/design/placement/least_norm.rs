//! The feedback that places one eigenvalue or two with the least effort.

use nalgebra::{Complex, DMatrix, Matrix2};

/// Rotations that make two rows orthogonal to working accuracy.
const ROTATIONS: usize = 3;
/// Roundings that a shorter singular value is from nothing.
const RANK_ROUNDINGS: f64 = 8.0;
/// Steps of a bisection that divides what is left by 1024 at first: far more than it takes.
const BISECTIONS: usize = 400;
/// Newton steps that restore the determinant after rounding.
const CORRECTIONS: usize = 3;

/// `F (m x 1)` of least norm with `a + g F = pole`, for `g (1 x m)` that is not zero.
pub(super) fn one(a: f64, g: &DMatrix<f64>, pole: f64) -> DMatrix<f64> {
    g.transpose() * ((pole - a) / g.norm_squared())
}

/// `F (m x 2)` such that `A + G F (2 x 2)` has the trace `sum` and the determinant `product`, for
/// `G (2 x m)`; `None` when G has rank one to working accuracy and does not reach both eigenvalues
/// by more than `limit`.
///
/// With the singular values `b1 >= b2` of G and its singular vectors as coordinates, an entry
/// `x_ij` of the result costs `((x_ij - a_ij) / b_i)^2`. First the least `F` that gives the trace
/// settles `x11` and `x22`, then the least `x12` and `x21` give the determinant. To choose all at
/// once would cost a little less; the two steps are those of SLICOT's SB01BD.
pub(super) fn two(
    a: &Matrix2<f64>,
    g: &DMatrix<f64>,
    sum: f64,
    product: f64,
    limit: f64,
) -> Option<DMatrix<f64>> {
    let (u, rows) = orthogonal_rows(g);
    let (b1, b2) = (rows.row(0).norm(), rows.row(1).norm());
    let a = u.transpose() * a * u;
    let mut feedback = DMatrix::zeros(2, 2);
    if b2 <= RANK_ROUNDINGS * f64::EPSILON * b1 {
        // The second row stays; trace and determinant are linear in the first.
        if a[(1, 0)].abs() <= limit {
            return None;
        }
        let x11 = sum - a[(1, 1)];
        let x12 = (x11 * a[(1, 1)] - product) / a[(1, 0)];
        feedback[(0, 0)] = (x11 - a[(0, 0)]) / b1;
        feedback[(0, 1)] = (x12 - a[(0, 1)]) / b1;
    } else {
        let missing = (sum - a.trace()) / (b1 * b1 + b2 * b2);
        feedback[(0, 0)] = b1 * missing;
        feedback[(1, 1)] = b2 * missing;
        let x11 = a[(0, 0)] + b1 * feedback[(0, 0)];
        let [x12, x21] = nearest(a[(0, 1)], a[(1, 0)], b2 / b1, x11 * (sum - x11) - product);
        feedback[(0, 1)] = (x12 - a[(0, 1)]) / b1;
        feedback[(1, 0)] = (x21 - a[(1, 0)]) / b2;
    }
    // The right singular vectors are the rows over their norms.
    let right = DMatrix::from_columns(&[
        rows.row(0).transpose() / b1,
        rows.row(1).transpose().map(|value| quotient(value, b2)),
    ]);
    Some(right * feedback * DMatrix::from_column_slice(2, 2, u.transpose().as_slice()))
}

/// `U' G` with an orthogonal U that makes its rows orthogonal, the longer first: one rotation of
/// Jacobi's, and more of them against its rounding.
fn orthogonal_rows(g: &DMatrix<f64>) -> (Matrix2<f64>, DMatrix<f64>) {
    let (mut u, mut rows) = (Matrix2::identity(), g.clone());
    for _ in 0..ROTATIONS {
        let cross = rows.row(0).dot(&rows.row(1));
        if cross == 0.0 {
            break;
        }
        let zeta = (rows.row(1).norm_squared() - rows.row(0).norm_squared()) / (2.0 * cross);
        let tangent = 1.0_f64.copysign(zeta) / (zeta.abs() + zeta.hypot(1.0));
        let cosine = 1.0 / tangent.hypot(1.0);
        let sine = cosine * tangent;
        let rotation = Matrix2::new(cosine, sine, -sine, cosine);
        u *= rotation;
        rows = DMatrix::from_column_slice(2, 2, rotation.transpose().as_slice()) * rows;
    }
    if rows.row(1).norm() > rows.row(0).norm() {
        u.swap_columns(0, 1);
        rows.swap_rows(0, 1);
    }
    (u, rows)
}

/// The `[x12, x21]` with the product `level` nearest to `[a12, a21]`, the distance in `x21` divided
/// by `ratio`, which is at most 1.
///
/// In sum and difference `e`, `d` of the weighted pair, over the root of 2, it is the point of
/// `(e^2 - d^2) / 2 = level` nearest to `(e0, d0)`: `e = e0 / (1 + mu)`, `d = d0 / (1 - mu)` with
/// the one multiplier in `[-1, 1]` that keeps the Lagrangian convex (J. J. More, Optimization
/// Methods and Software 2, 1993). Where two points are equally near, `e` or `d` is the positive one.
fn nearest(a12: f64, a21: f64, ratio: f64, level: f64) -> [f64; 2] {
    let scale = ratio.sqrt();
    let root = core::f64::consts::FRAC_1_SQRT_2;
    let (y12, y21) = (scale * a12, a21 / scale);
    let (e, d) = on_hyperbola((y12 + y21) * root, (y12 - y21) * root, level);
    let (mut y12, mut y21) = ((e + d) * root, (e - d) * root);
    for _ in 0..CORRECTIONS {
        let slope = y12 * y12 + y21 * y21;
        let step = quotient(y12 * y21 - level, slope);
        (y12, y21) = (y12 - step * y21, y21 - step * y12);
    }
    [y12 / scale, y21 * scale]
}

/// The point of `(e^2 - d^2) / 2 = level` that is nearest to `(e0, d0)`.
fn on_hyperbola(e0: f64, d0: f64, level: f64) -> (f64, f64) {
    let excess = |(e, d): (f64, f64)| (e * e - d * d) / 2.0 - level;
    // Too large a value asks for a multiplier above 0, which falls short of 1 by `distance`; the
    // value falls with the multiplier.
    let positive = excess((e0, d0)) > 0.0;
    let point = |distance: f64| {
        if positive {
            (e0 / (2.0 - distance), quotient(d0, distance))
        } else {
            (quotient(e0, distance), d0 / (2.0 - distance))
        }
    };
    let nearer = |distance: f64| (excess(point(distance)) > 0.0) == positive;
    let (e, d) = point(0.0);
    if e.is_finite() && d.is_finite() && nearer(0.0) {
        let missing = (2.0 * excess((e, d)).abs()).sqrt();
        return if positive { (e, missing) } else { (missing, d) };
    }
    let (mut low, mut high) = (0.0, 1.0_f64);
    for _ in 0..BISECTIONS {
        let middle = if low == 0.0 {
            high / 1024.0
        } else {
            (low * high).sqrt()
        };
        if nearer(middle) {
            high = middle;
        } else {
            low = middle;
        }
        if high - low <= f64::EPSILON * high || high < f64::MIN_POSITIVE {
            break;
        }
    }
    point(high)
}

/// The quotient, 0 when there is nothing to divide.
fn quotient(value: f64, by: f64) -> f64 {
    if value == 0.0 { 0.0 } else { value / by }
}

/// Trace and determinant of a matrix with these two eigenvalues.
pub(super) fn sum_and_product(poles: [Complex<f64>; 2]) -> (f64, f64) {
    ((poles[0] + poles[1]).re, (poles[0] * poles[1]).re)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A linear congruential generator (Knuth's MMIX): enough to scatter cases over (-1, 1).
    fn draws() -> impl FnMut() -> f64 {
        let mut state = 1_u64;
        move || {
            state = state
                .wrapping_mul(6364136223846793005)
                .wrapping_add(1442695040888963407);
            (state >> 11) as f64 / (1_u64 << 52) as f64 - 1.0
        }
    }

    #[test]
    fn trace_and_determinant_are_those_asked_for() {
        let mut draw = draws();
        for case in 0..300 {
            let a = Matrix2::new(draw(), draw(), draw(), draw());
            // Among them diagonal ones, whose nearest point is not alone.
            let a = if case % 5 == 0 {
                Matrix2::from_diagonal(&a.diagonal())
            } else {
                a
            };
            let small = [1.0, 1e-3, 1e-7][case % 3];
            let g = [draw(), draw(), small * draw(), small * draw()];
            let g = DMatrix::from_row_slice(2, 2, &g);
            let (sum, product) = (2.0 * draw(), draw());
            let f = two(&a, &g, sum, product, 0.0).expect("two inputs");
            let closed = DMatrix::from_column_slice(2, 2, a.as_slice()) + &g * &f;
            // Rounding of the product with the feedback, whose entries are up to 1e7.
            let scale = 1.0 + (g.norm() * f.norm()).powi(2);
            let trace = (closed.trace() - sum).abs();
            let determinant = (closed.determinant() - product).abs();
            assert!(trace < 1e-13 * scale, "case {case}: {trace:e}");
            assert!(determinant < 1e-12 * scale, "case {case}: {determinant:e}");
        }
    }

    /// Against the hyperbola scanned on both branches in steps of a hundredth.
    #[test]
    fn no_other_pair_with_the_same_product_is_nearer() {
        let mut draw = draws();
        for case in 0..300 {
            let (a12, a21) = match case % 4 {
                0 => (0.0, 0.0),
                1 => (0.5, -0.5),
                _ => (draw(), draw()),
            };
            let (ratio, level) = ([1.0, 0.1, 1e-4][case % 3], draw());
            let cost = |[x12, x21]: [f64; 2]| (x12 - a12).hypot((x21 - a21) / ratio);
            let found = nearest(a12, a21, ratio, level);
            let product = found[0] * found[1];
            assert!(
                (product - level).abs() < 1e-14,
                "case {case}: {product} {level}"
            );
            let mut best = f64::INFINITY;
            for step in -1200..1200 {
                let x12 = (f64::from(step) / 100.0).exp();
                let others = [[x12, level / x12], [-x12, -level / x12]].map(cost);
                best = best.min(others[0]).min(others[1]);
            }
            let least = cost(found);
            assert!(least <= best * (1.0 + 1e-12), "case {case}: {least} {best}");
            // The scan is close enough to notice, but for the steepest weights.
            let coarse = ratio < 0.1;
            assert!(
                coarse || best <= least * 1.1 + 1e-3,
                "case {case}: {least} {best}"
            );
        }
    }
}
