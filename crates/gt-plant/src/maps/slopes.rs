//! Slopes of a cubic Hermite interpolant at its nodes.
//!
//! Both rules start from the parabola through a node and its two neighbours (at an end: the next
//! two), which is of second order on any spacing, and limit it.

/// Difference quotients `(y[i + 1] - y[i]) / (x[i + 1] - x[i])`.
fn quotients(x: &[f64], y: &[f64]) -> Vec<f64> {
    let steps = x.windows(2).zip(y.windows(2));
    steps.map(|(x, y)| (y[1] - y[0]) / (x[1] - x[0])).collect()
}

/// Second divided differences at each node; an end takes its neighbour's.
fn curvatures(x: &[f64], quotients: &[f64]) -> Vec<f64> {
    let last = x.len() - 1;
    (0..=last)
        .map(|node| {
            let middle = node.clamp(1, last - 1);
            (quotients[middle] - quotients[middle - 1]) / (x[middle + 1] - x[middle - 1])
        })
        .collect()
}

/// The one nearer to zero, or zero where the signs differ.
fn nearer_zero(a: f64, b: f64) -> f64 {
    if a * b > 0.0 {
        a.signum() * a.abs().min(b.abs())
    } else {
        0.0
    }
}

/// Slopes with which the interpolant of `y` at `x` (at least 2 nodes, rising) is monotone between
/// any two nodes: 0 to 2 times the smaller quotient. The box of Fritsch and Carlson (1980) goes to
/// 3; what is left of it is for the slopes over speed, see `order`.
pub(super) fn monotone(x: &[f64], y: &[f64]) -> Vec<f64> {
    let quotients = quotients(x, y);
    let last = quotients.len();
    if last == 1 {
        return vec![quotients[0]; 2];
    }
    let curvatures = curvatures(x, &quotients);
    (0..=last)
        .map(|node| {
            let right = quotients[node.min(last - 1)];
            let left = quotients[node.max(1) - 1];
            let parabola = if node == 0 {
                right - curvatures[0] * (x[1] - x[0])
            } else {
                left + curvatures[node] * (x[node] - x[node - 1])
            };
            nearer_zero(parabola, 2.0 * nearer_zero(left, right))
        })
        .collect()
}

/// Slopes for smooth data, of second order also at a maximum: Huynh's M3 (1993), on any spacing.
///
/// `room` is how far a value may move; the slopes are bounded by 3 times that over the spacing,
/// which keeps the interpolant from moving farther (its Bernstein coefficients do not).
pub(super) fn smooth(x: &[f64], y: &[f64], room: impl Fn(f64) -> f64) -> Vec<f64> {
    let quotients = quotients(x, y);
    let last = quotients.len();
    let limited = |node: usize, slope: f64| {
        let left = if node == 0 {
            0.0
        } else {
            x[node] - x[node - 1]
        };
        let right = if node == last {
            0.0
        } else {
            x[node + 1] - x[node]
        };
        // A value that was interpolated may stand a rounding beyond its limit.
        let bound = 3.0 * room(y[node]).max(0.0) / left.max(right);
        slope.max(-bound).min(bound)
    };
    if last == 1 {
        return (0..2).map(|node| limited(node, quotients[0])).collect();
    }
    let curvatures = curvatures(x, &quotients);
    // The slope at the left and at the right end of an interval, by its tamer parabola.
    let ends = |interval: usize| {
        let bow = nearer_zero(curvatures[interval], curvatures[interval + 1])
            * (x[interval + 1] - x[interval]);
        [quotients[interval] - bow, quotients[interval] + bow]
    };
    (0..=last)
        .map(|node| {
            let slope = if node == 0 {
                ends(0)[0]
            } else if node == last {
                ends(last - 1)[1]
            } else {
                let (left, right) = (quotients[node - 1], quotients[node]);
                let parabola = left + curvatures[node] * (x[node] - x[node - 1]);
                let tame = nearer_zero(ends(node - 1)[1], ends(node)[0]);
                let most = (3.0 * nearer_zero(left, right).abs()).max(1.5 * tame.abs());
                nearer_zero(parabola, most.copysign(tame))
            };
            limited(node, slope)
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    /// Nodes at random spacings, from zero.
    fn nodes() -> impl Strategy<Value = Vec<f64>> {
        proptest::collection::vec(0.1..1.0f64, 2..9).prop_map(|steps| {
            let mut x = 0.0;
            let rest = steps.into_iter().map(move |step| {
                x += step;
                x
            });
            std::iter::once(0.0).chain(rest).collect()
        })
    }

    proptest! {
        /// A parabola has the same second difference everywhere, so nothing is limited.
        #[test]
        fn prop_smooth_slopes_of_a_parabola_are_exact(
            x in nodes(), a in -1.0..1.0f64, b in -1.0..1.0f64,
        ) {
            let y: Vec<f64> = x.iter().map(|x| a * x + b * x * x).collect();
            for (slope, x) in smooth(&x, &y, |_| f64::INFINITY).iter().zip(&x) {
                // A slope below the rounding of the quotients may be set to zero.
                prop_assert!((slope - a - 2.0 * b * x).abs() < 1e-12);
            }
        }

        #[test]
        fn prop_monotone_slopes_lie_in_the_box(
            x in nodes(), rise in 0.0..9.0f64, bump in 0.0..5.0f64,
        ) {
            let y: Vec<f64> = x.iter().map(|x| rise * x + bump * (3.0 * x).sin()).collect();
            let slopes = monotone(&x, &y);
            for (i, quotient) in quotients(&x, &y).into_iter().enumerate() {
                for slope in &slopes[i..i + 2] {
                    prop_assert!(slope * quotient >= 0.0);
                    prop_assert!(slope.abs() <= 2.0 * quotient.abs());
                }
            }
        }
    }

    #[test]
    fn a_jag_makes_no_false_maximum() {
        let x = [0.0, 1.0, 2.0, 3.0, 4.0];
        let slopes = smooth(&x, &[0.60, 0.85, 0.86, 0.86, 0.85], |_| f64::INFINITY);
        // Three times the smaller quotient; the parabola alone says 0.13 and overshoots by 0.01.
        assert!((slopes[1] - 0.03).abs() < 1e-15, "{slopes:?}");
        assert!((slopes[2] - 0.005).abs() < 1e-15, "{slopes:?}");
    }
}
