//! The classical Runge-Kutta method of fourth order. It knows no turbine.

use crate::real::Real;

/// The state one step after `x`, for `x' = derivative(t, x)`.
///
/// The classical tableau (Hairer, Norsett and Wanner, Solving Ordinary Differential Equations I,
/// table II.1.2): four evaluations, local error of order `step^5`.
#[inline(always)]
pub fn step<R: Real, const N: usize>(
    derivative: impl Fn(f64, &[R; N]) -> [R; N],
    t: f64,
    x: &[R; N],
    step: f64,
) -> [R; N] {
    // A loop, so that a large derivative stands once in the program, not four times.
    let ahead = [0.0, 0.5 * step, 0.5 * step, step];
    let mut k = [*x; 4];
    let mut at = *x;
    for stage in 0..4 {
        if stage > 0 {
            at = advanced(x, &k[stage - 1], ahead[stage]);
        }
        k[stage] = derivative(t + ahead[stage], &at);
    }
    let [k1, k2, k3, k4] = &k;
    let mut next = *x;
    for i in 0..N {
        let slope = (k2[i] + k3[i]) * 2.0 + k1[i] + k4[i];
        next[i] = slope.mul_add(slope.like(step / 6.0), x[i]);
    }
    next
}

#[inline(always)]
fn advanced<R: Real, const N: usize>(x: &[R; N], slope: &[R; N], step: f64) -> [R; N] {
    let mut next = *x;
    for i in 0..N {
        next[i] = slope[i].mul_add(slope[i].like(step), x[i]);
    }
    next
}

#[cfg(test)]
mod tests {
    use super::*;

    /// x' = -2 t x has the solution exp(-t^2).
    fn error_at_one(steps: u32) -> f64 {
        let h = 1.0 / f64::from(steps);
        let mut x = [1.0];
        for k in 0..steps {
            x = step(|t, x| [-2.0 * t * x[0]], f64::from(k) * h, &x, h);
        }
        (x[0] - (-1.0f64).exp()).abs()
    }

    #[test]
    fn halving_the_step_divides_the_error_by_sixteen() {
        let ratio = error_at_one(32) / error_at_one(64);
        // The next term of the error expansion is O(h): 5 % at 32 steps.
        assert!((ratio / 16.0 - 1.0).abs() < 0.05, "{ratio}");
    }

    #[test]
    fn cubic_in_time_is_exact() {
        let end = step(|t, _| [4.0 * t * t * t], 1.0, &[1.0], 0.5);
        assert!((end[0] - 1.5f64.powi(4)).abs() < 1e-14);
    }

    #[test]
    fn leaves_the_stability_interval_at_its_textbook_end() {
        // Real stability interval of RK4: (-2.785, 0).
        let gain = |z: f64| step(|_, x| [z * x[0]], 0.0, &[1.0], 1.0)[0].abs();
        assert!(gain(-2.78) < 1.0 && gain(-2.79) > 1.0);
    }
}
