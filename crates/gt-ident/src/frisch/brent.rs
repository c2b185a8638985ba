//! The minimum of a function of one variable.

/// The golden section, `(3 - sqrt 5) / 2`.
const GOLDEN: f64 = 0.381_966_011_250_105_1;

/// The place and value of a minimum.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Minimum {
    pub at: f64,
    pub value: f64,
}

/// The minimum of `f` between `low` and `high` to within `tolerance`, by parabolic interpolation
/// with golden sections (Brent 1973, "Algorithms for Minimization without Derivatives", ch. 5).
///
/// The ends themselves are never evaluated. Infinite values are allowed.
pub(crate) fn brent(
    f: impl Fn(f64) -> f64,
    (mut low, mut high): (f64, f64),
    tolerance: f64,
    max_evaluations: usize,
) -> Minimum {
    let evaluate = |at: f64| Minimum { at, value: f(at) };
    let mut best = evaluate(low + GOLDEN * (high - low));
    let (mut second, mut third) = (best, best);
    let (mut step, mut before): (f64, f64) = (0.0, 0.0);
    for _ in 1..max_evaluations {
        let middle = 0.5 * (low + high);
        let close = tolerance + f64::EPSILON.sqrt() * best.at.abs() * 1e-3;
        if (best.at - middle).abs() <= 2.0 * close - 0.5 * (high - low) {
            break;
        }
        let parabola = parabola_step(best, second, third).filter(|&found| {
            let at = best.at + found;
            before.abs() > close && found.abs() < 0.5 * before.abs() && at > low && at < high
        });
        before = step;
        step = if let Some(found) = parabola {
            let at = best.at + found;
            if at - low < 2.0 * close || high - at < 2.0 * close {
                close.copysign(middle - best.at)
            } else {
                found
            }
        } else {
            before = if best.at >= middle {
                low - best.at
            } else {
                high - best.at
            };
            GOLDEN * before
        };
        let moved = if step.abs() >= close {
            step
        } else {
            close.copysign(step)
        };
        let next = evaluate(best.at + moved);
        if next.value <= best.value {
            if next.at >= best.at {
                low = best.at;
            } else {
                high = best.at;
            }
            (third, second, best) = (second, best, next);
        } else {
            if next.at < best.at {
                low = next.at;
            } else {
                high = next.at;
            }
            if next.value <= second.value || second.at.total_cmp(&best.at).is_eq() {
                (third, second) = (second, next);
            } else if next.value <= third.value
                || third.at.total_cmp(&best.at).is_eq()
                || third.at.total_cmp(&second.at).is_eq()
            {
                third = next;
            }
        }
    }
    best
}

/// From the best of three points to the vertex of their parabola.
fn parabola_step(best: Minimum, second: Minimum, third: Minimum) -> Option<f64> {
    let r = (best.at - second.at) * (best.value - third.value);
    let q = (best.at - third.at) * (best.value - second.value);
    let p = (best.at - third.at) * q - (best.at - second.at) * r;
    let step = -p / (2.0 * (q - r));
    step.is_finite().then_some(step)
}

#[cfg(test)]
mod tests {
    use super::brent;

    /// The vertex of a parabola is found in a few evaluations; so is a minimum without curvature.
    #[test]
    fn known_minima_are_found() {
        let parabola = brent(|x| (x - 0.3).powi(2) + 2.0, (-1.0, 4.0), 1e-9, 60);
        assert!((parabola.at - 0.3).abs() < 1e-7, "{parabola:?}");
        assert!((parabola.value - 2.0).abs() < 1e-14);
        let quartic = brent(|x| (x - 0.7).powi(4), (0.0, 1.0), 1e-9, 200);
        assert!((quartic.at - 0.7).abs() < 1e-4, "{quartic:?}");
        let kink = brent(|x| (x - 0.2).abs(), (0.0, 1.0), 1e-10, 200);
        assert!((kink.at - 0.2).abs() < 1e-8, "{kink:?}");
    }

    /// `x^3 - 2 x - 5` has its minimum at `sqrt(2 / 3)`.
    #[test]
    fn published_cubic() {
        let found = brent(|x| x * (x * x - 2.0) - 5.0, (0.0, 1.0), 1e-10, 60);
        // Rounding of the value hides the last half of the digits of the place.
        assert!((found.at - (2.0_f64 / 3.0).sqrt()).abs() < 1e-7);
    }

    /// Towards an end the search closes in on it; infinite values only push it away.
    #[test]
    fn minima_at_the_border_are_approached() {
        let rising = brent(|x| x, (0.0, 1.0), 1e-8, 200);
        assert!(rising.at < 1e-7 && rising.at > 0.0, "{rising:?}");
        let wall = |x: f64| if x < 0.5 { f64::INFINITY } else { x };
        let found = brent(wall, (0.0, 1.0), 1e-8, 200);
        assert!((found.at - 0.5).abs() < 1e-6, "{found:?}");
        let nowhere = brent(|_| f64::INFINITY, (0.0, 1.0), 1e-8, 200);
        assert!(nowhere.at > 0.0 && nowhere.at < 1.0);
    }
}
