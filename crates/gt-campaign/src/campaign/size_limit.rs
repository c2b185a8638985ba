//! The size from which a fault is found: a curve through hits and misses.

use serde::Serialize;

/// The normal deviate with 2.5 % above it.
const DEVIATE: f64 = 1.959_963_984_540_054;
/// Fewest runs that a curve goes through.
const FEWEST: usize = 20;
/// Steps of the search for the curve at most, and its end: the largest step of a parameter, of
/// standardised sizes.
const STEPS: usize = 100;
const CLOSE: f64 = 1e-10;
/// The longest step of a parameter.
const LONGEST: f64 = 2.0;

/// The size that is detected with a probability.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct SizeLimit {
    /// The size; `None` where it is none of those drawn, or no curve rises with the size.
    pub size: Option<f64>,
    /// Lower end of its 95 % interval.
    pub low: Option<f64>,
    /// Upper end.
    pub high: Option<f64>,
}

/// A logistic curve of the probability of detection over the logarithm of the size, by Firth's
/// penalised likelihood (*Biometrika* 80, 1993), which has a finite answer also where all runs below
/// some size were missed and all above found.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct DetectionCurve {
    /// Intercept and slope over the standardised logarithm.
    parameters: [f64; 2],
    /// Their covariance: of the intercept, of both, of the slope.
    covariance: [f64; 3],
    /// Mean and deviation of the logarithms of all sizes, and the ends of these.
    mean: f64,
    deviation: f64,
    ends: [f64; 2],
}

impl DetectionCurve {
    /// The curve through runs with a size each and whether it was found; `None` of fewer than
    /// [`FEWEST`] runs, of a single size, and where detection does not rise with the size.
    pub(super) fn fit(runs: &[(f64, bool)]) -> Option<Self> {
        if runs.len() < FEWEST {
            return None;
        }
        let count = runs.len() as f64;
        let logarithms = runs.iter().map(|(size, _)| size.ln());
        let mean = logarithms.clone().sum::<f64>() / count;
        let squares = logarithms.clone().map(|value| (value - mean).powi(2));
        let deviation = (squares.sum::<f64>() / count).sqrt();
        let low = logarithms.clone().fold(f64::INFINITY, f64::min);
        let high = logarithms.clone().fold(f64::NEG_INFINITY, f64::max);
        if deviation.is_nan() || deviation <= 1e-9 {
            return None;
        }
        let points: Vec<(f64, f64)> = logarithms
            .zip(runs)
            .map(|(value, (_, found))| ((value - mean) / deviation, f64::from(u8::from(*found))))
            .collect();
        let mut parameters = [0.0; 2];
        for _ in 0..STEPS {
            let (step, _) = Self::step(&points, parameters)?;
            let longest = step[0].abs().max(step[1].abs());
            let share = (LONGEST / longest).min(1.0);
            parameters = [0, 1].map(|place| parameters[place] + share * step[place]);
            if longest < CLOSE {
                let (_, covariance) = Self::step(&points, parameters)?;
                return (parameters[1] > 0.0).then_some(Self {
                    parameters,
                    covariance,
                    mean,
                    deviation,
                    ends: [low, high],
                });
            }
        }
        None
    }

    /// The scoring step from some parameters, and their covariance.
    fn step(points: &[(f64, f64)], [a, b]: [f64; 2]) -> Option<([f64; 2], [f64; 3])> {
        let probability = |x: f64| 1.0 / (1.0 + (-(a + b * x)).exp());
        let mut information = [0.0; 3];
        for (x, _) in points {
            let p = probability(*x);
            let weight = p * (1.0 - p);
            information[0] += weight;
            information[1] += weight * x;
            information[2] += weight * x * x;
        }
        let determinant = information[0] * information[2] - information[1] * information[1];
        if determinant.is_nan() || determinant <= 0.0 {
            return None;
        }
        let covariance = [
            information[2] / determinant,
            -information[1] / determinant,
            information[0] / determinant,
        ];
        let mut score = [0.0; 2];
        for (x, found) in points {
            let p = probability(*x);
            let leverage =
                p * (1.0 - p) * (covariance[0] + 2.0 * covariance[1] * x + covariance[2] * x * x);
            let own = found - p + leverage * (0.5 - p);
            score[0] += own;
            score[1] += own * x;
        }
        let step = [
            covariance[0] * score[0] + covariance[1] * score[1],
            covariance[1] * score[0] + covariance[2] * score[1],
        ];
        step.iter()
            .all(|own| own.is_finite())
            .then_some((step, covariance))
    }

    /// The probability of detection of a size; `None` outside those drawn.
    pub(super) fn at(&self, size: f64) -> Option<f64> {
        let [a, b] = self.parameters;
        let [low, high] = self.ends;
        let logarithm = size.ln();
        // The ends themselves come back from exponentials.
        let inside = logarithm >= low - 1e-9 && logarithm <= high + 1e-9;
        let x = (logarithm - self.mean) / self.deviation;
        inside.then(|| 1.0 / (1.0 + (-(a + b * x)).exp()))
    }

    /// The size that is detected with a probability, with its interval by propagated errors.
    pub(super) fn limit(&self, probability: f64) -> SizeLimit {
        let [a, b] = self.parameters;
        let [intercept, both, slope] = self.covariance;
        let at = ((probability / (1.0 - probability)).ln() - a) / b;
        let error = ((intercept + 2.0 * at * both + at * at * slope).max(0.0)).sqrt() / b;
        let logarithm = |x: f64| self.mean + self.deviation * x;
        let [least, largest] = self.ends;
        let size = logarithm(at);
        let inside = (least..=largest).contains(&size);
        let end = |x: f64| inside.then(|| logarithm(x).exp());
        SizeLimit {
            size: end(at),
            low: end(at - DEVIATE * error),
            high: end(at + DEVIATE * error),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use rand::{RngExt as _, SeedableRng as _};
    use rand_chacha::ChaCha12Rng;

    /// Runs of sizes between .1 and 10, even in the logarithm, found by a logistic curve whose half
    /// is at 1.
    fn runs(random: &mut ChaCha12Rng, count: usize, slope: f64) -> Vec<(f64, bool)> {
        let mut one = || {
            let size: f64 = 10_f64.powf(random.random_range(-1.0..1.0));
            let p = 1.0 / (1.0 + (-slope * size.ln()).exp());
            (size, random.random_bool(p))
        };
        (0..count).map(|_| one()).collect()
    }

    /// The true size lies in 95 % of the intervals, within four deviations of 600 counts.
    #[test]
    fn intervals_hold_the_size_as_often_as_they_say() {
        let mut random = ChaCha12Rng::seed_from_u64(3);
        let slope = 3.0;
        let truth = (19_f64.ln() / slope).exp();
        let (mut inside, all) = (0, 600);
        for _ in 0..all {
            let curve = DetectionCurve::fit(&runs(&mut random, 300, slope)).expect("a curve");
            let limit = curve.limit(0.95);
            if let (Some(low), Some(high)) = (limit.low, limit.high) {
                inside += i32::from(low <= truth && truth <= high);
            }
        }
        let share = f64::from(inside) / f64::from(all);
        let spread = (0.95 * 0.05 / f64::from(all)).sqrt();
        assert!((share - 0.95).abs() < 4.0 * spread, "{share}");
    }

    /// All below 1 missed and all above found: no maximum of the likelihood, but one of Firth's.
    #[test]
    fn separated_runs_have_a_limit_between_them() {
        let separated: Vec<(f64, bool)> = (1..=200)
            .map(|k| f64::from(k) / 100.0)
            .map(|size| (size, size > 1.0))
            .collect();
        let limit = DetectionCurve::fit(&separated).expect("a curve").limit(0.5);
        let size = limit.size.expect("a size");
        assert!((size - 1.0).abs() < 0.02, "{limit:?}");
    }

    #[test]
    fn no_limit_is_said_that_was_not_seen() {
        let same = |size: f64, found: bool| vec![(size, found); 50];
        assert_eq!(DetectionCurve::fit(&same(1.0, true)), None);
        // Fewer with size, too few at all.
        let falls: Vec<(f64, bool)> = (1..=200).map(|k| (f64::from(k), k < 100)).collect();
        assert_eq!(DetectionCurve::fit(&falls), None);
        assert_eq!(DetectionCurve::fit(&falls[..FEWEST - 1]), None);
        // Half of the largest are missed.
        let mut random = ChaCha12Rng::seed_from_u64(4);
        let small: Vec<_> = runs(&mut random, 400, 3.0)
            .into_iter()
            .filter(|(size, _)| *size < 1.0)
            .collect();
        let limit = DetectionCurve::fit(&small).expect("a curve").limit(0.95);
        assert_eq!((limit.size, limit.low, limit.high), (None, None, None));
    }
}
