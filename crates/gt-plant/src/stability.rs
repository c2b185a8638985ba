//! Where the classical Runge-Kutta method of fourth order, [`crate::rk4`], is stable.

use nalgebra::Complex;

/// Beyond this modulus of `h lambda` the method is unstable on every ray: the 8th power rules.
const BEYOND: f64 = 4.0;

/// The factor by which one step multiplies a mode, `|R(z)|` with
/// `R(z) = 1 + z + z^2/2 + z^3/6 + z^4/24`, where z is the step times the pole (Hairer and Wanner,
/// Solving Ordinary Differential Equations II, section IV.2).
pub fn amplification(z: Complex<f64>) -> f64 {
    ((((z / 4.0 + 1.0) * z / 3.0 + 1.0) * z / 2.0 + 1.0) * z + 1.0).norm()
}

/// The longest step h, in seconds, such that no step in (0, h] amplifies a mode that decays.
///
/// Poles with a real part of zero or more are the plant's own matter and left out: without others
/// the step is infinite. A NaN among the poles gives NaN.
///
/// A mode of damping `c = Re/|lambda|` in [-1, 0) is amplified from `|h lambda| = 2.785` (no
/// oscillation) over 2.616 to 2.961 up to `2 sqrt(2)` (no damping) on. Each ray into the left half
/// plane leaves the stability region once, so that all shorter steps are stable too.
pub fn longest_stable_step_s(poles_per_s: &[Complex<f64>]) -> f64 {
    let mut longest_s = f64::INFINITY;
    for pole in poles_per_s {
        if pole.re.is_nan() || pole.im.is_nan() {
            return f64::NAN;
        }
        if pole.re < 0.0 {
            let modulus_per_s = pole.norm();
            longest_s = longest_s.min(boundary(pole.re / modulus_per_s) / modulus_per_s);
        }
    }
    longest_s
}

/// The modulus r > 0 at which `z = r e^(j phi)` with `c = cos(phi)` in [-1, 0) leaves the stability
/// region, from below.
fn boundary(c: f64) -> f64 {
    let (mut stable, mut unstable) = (0.0, BEYOND);
    loop {
        let middle = 0.5 * (stable + unstable);
        if middle <= stable || middle >= unstable {
            return stable;
        }
        if excess(c, middle) <= 0.0 {
            stable = middle;
        } else {
            unstable = middle;
        }
    }
}

/// `(|R(r e^(j phi))|^2 - 1) / r` as a polynomial: the difference itself would drown in rounding
/// for weak damping. Up to `r^3` the coefficients are those of `exp(2 c r)`.
fn excess(c: f64, r: f64) -> f64 {
    let square = c * c;
    let coefficients = [
        2.0 * c,
        2.0 * square,
        4.0 / 3.0 * square * c,
        2.0 / 3.0 * square * square,
        (4.0 * square - 1.0) * c / 12.0,
        square / 12.0 - 1.0 / 72.0,
        c / 72.0,
        1.0 / 576.0,
    ];
    coefficients
        .iter()
        .rev()
        .fold(0.0, |sum, coefficient| sum * r + coefficient)
}

#[cfg(test)]
#[allow(clippy::float_cmp, reason = "limits and equal computations are exact")]
mod tests {
    use super::*;
    use crate::rk4;

    /// Damping ratios c = Re/|lambda| from none to full.
    fn dampings() -> impl Iterator<Item = f64> {
        let weak = (0..12).map(|power| -(10.0f64.powi(power - 12)));
        weak.chain((1..=500).map(|k| -f64::from(k) / 500.0))
    }

    fn pole(c: f64, modulus: f64) -> Complex<f64> {
        Complex::new(c, (1.0 - c * c).max(0.0).sqrt()) * modulus
    }

    #[test]
    fn published_ends_of_the_stability_region() {
        // Real end: the root of z^3 + 4 z^2 + 12 z + 24; imaginary end: 2 sqrt(2).
        let real = longest_stable_step_s(&[Complex::new(-1.0, 0.0)]);
        assert!((real - 2.785293563405282).abs() < 1e-14, "{real}");
        for sign in [1.0, -1.0] {
            let imaginary = longest_stable_step_s(&[Complex::new(-1e-12, sign)]);
            assert!((imaginary - 8.0f64.sqrt()).abs() < 1e-11, "{imaginary}");
        }
    }

    #[test]
    fn modes_that_do_not_decay_are_left_out() {
        let others = [
            Complex::new(0.0, 0.0),
            Complex::new(0.0, 9.0),
            Complex::new(5.0, -9.0),
        ];
        assert_eq!(longest_stable_step_s(&others), f64::INFINITY);
        assert_eq!(longest_stable_step_s(&[]), f64::INFINITY);
        let [first, ..] = others;
        let both = longest_stable_step_s(&[first, Complex::new(-2.0, 0.0)]);
        assert_eq!(both, longest_stable_step_s(&[Complex::new(-2.0, 0.0)]));
    }

    #[test]
    fn poles_that_are_no_numbers_give_no_step() {
        let nan = Complex::new(f64::NAN, 0.0);
        let decaying = Complex::new(-1.0, 0.0);
        assert!(longest_stable_step_s(&[nan, decaying]).is_nan());
        assert!(longest_stable_step_s(&[decaying, nan]).is_nan());
        let infinite = Complex::new(f64::NEG_INFINITY, 1.0);
        assert_eq!(longest_stable_step_s(&[infinite, decaying]), 0.0);
    }

    #[test]
    fn the_fastest_pair_decides() {
        // The plant's own, of 761.5 1/s with c = -0.406: |h lambda| = 2.66.
        let slow = Complex::new(-0.2, 0.0);
        let fast = [
            Complex::new(-309.0, 696.0),
            Complex::new(-309.0, -696.0),
            slow,
        ];
        let found = longest_stable_step_s(&fast);
        assert!((found - 3.5e-3).abs() < 5e-5, "{found}");
    }

    #[test]
    fn prop_the_polynomial_is_the_amplification() {
        for c in dampings() {
            for k in 1..=40 {
                let r = 0.1 * f64::from(k);
                let square = amplification(pole(c, r)).powi(2);
                let error = (excess(c, r) * r + 1.0 - square).abs();
                assert!(error < 1e-13 * square.max(1.0), "{c} {r} {error}");
            }
        }
    }

    #[test]
    fn prop_a_ray_leaves_the_region_once() {
        for c in dampings() {
            let end = boundary(c);
            assert!(end > 2.61 && end < 2.97, "{c} {end}");
            for k in 1..=4000 {
                let r = 1e-3 * f64::from(k);
                assert_eq!(excess(c, r) > 0.0, r > end, "{c} {r} {end}");
            }
        }
    }

    /// `x' = J x` with the poles `lambda` and its conjugate; J is normal, so that each step
    /// multiplies the length of x by the amplification.
    fn length_after(lambda: Complex<f64>, step_s: f64, steps: u32) -> f64 {
        let rates = |_: f64, x: &[f64; 2]| {
            [
                lambda.re * x[0] - lambda.im * x[1],
                lambda.im * x[0] + lambda.re * x[1],
            ]
        };
        let mut x = [1.0, 0.0];
        for k in 0..steps {
            x = rk4::step(rates, f64::from(k) * step_s, &x, step_s);
        }
        x[0].hypot(x[1])
    }

    #[test]
    fn prop_simulation_decays_inside_and_grows_outside() {
        // Modes of 10^-3 to 10^4 1/s; a step 1 % off changes |R| by 0.2 % at the least.
        for (k, c) in (0u8..).zip([-1e-3, -0.1, -0.406, -0.7, -0.9, -1.0]) {
            let lambda = pole(c, 10.0f64.powf(1.4 * f64::from(k) - 3.0));
            let limit_s = longest_stable_step_s(&[lambda]);
            assert!(length_after(lambda, 0.99 * limit_s, 2000) < 0.02, "{c}");
            assert!(length_after(lambda, 1.01 * limit_s, 2000) > 50.0, "{c}");
            let once = length_after(lambda, limit_s, 1);
            let expected = amplification(lambda * limit_s);
            assert!((once - expected).abs() < 1e-14 && (once - 1.0).abs() < 1e-13);
        }
    }
}
