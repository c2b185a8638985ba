//! Two faults at once.

use alloc::vec::Vec;

use super::core::{Core, DriveSums, HypothesisKind};
use super::diagnosis::{Mixture, PRIOR_SPREAD, Pair};
use super::profile::Profile;
use super::score::{Score, level, score, size};

/// Of the edges every fourth may be the onset of one of two faults, every eighth an end of growth.
const PAIR_ONSETS: usize = 4;
const PAIR_ENDS: usize = 8;
/// Correlation beyond which two faults cannot be told apart.
const MOST_ALIKE: f64 = 0.95;

impl Core {
    /// For every pair of hypotheses the logarithm of its likelihood ratio: each fault at its best
    /// profile beside the other's, found in turns.
    pub(super) fn pairs(&self, mixtures: &[Mixture]) -> Vec<(f64, Pair)> {
        let count = self.parts.hypotheses.len();
        let mut pairs = Vec::new();
        for first in 0..count {
            for second in first + 1..count {
                let starts = (
                    mixtures.get(first).and_then(|own| own.best),
                    mixtures.get(second).and_then(|own| own.best),
                );
                let (Some(one), Some(two)) = starts else {
                    continue;
                };
                // From the likelier of the two.
                let weight = |place: usize| mixtures.get(place).map_or(0.0, |own| own.largest);
                let (mut fixed, mut free) = if weight(first) >= weight(second) {
                    ((first, one), (second, two))
                } else {
                    ((second, two), (first, one))
                };
                for _ in 0..3 {
                    let mut found: Option<(f64, Profile)> = None;
                    for (profile, prior) in self.profiles(PAIR_ONSETS, PAIR_ENDS) {
                        let joint = self.joint(fixed, (free.0, profile));
                        let value = 0.5 * joint.squared + libm::log(prior);
                        if found.is_none_or(|(largest, _)| value > largest) {
                            found = Some((value, profile));
                        }
                    }
                    let Some((_, profile)) = found else {
                        break;
                    };
                    free.1 = profile;
                    core::mem::swap(&mut fixed, &mut free);
                }
                // After three turns the two have changed places three times.
                let (last, other) = (fixed, free);
                let sorted = if last.0 == first {
                    (last, other)
                } else {
                    (other, last)
                };
                let joint = self.joint(sorted.0, sorted.1);
                pairs.push((
                    self.pair_evidence(first, second, joint.squared, mixtures),
                    Pair {
                        faults: [first, second],
                        probability: 0.0,
                        magnitudes: joint.magnitudes,
                        ages: [
                            self.sums.age(sorted.0.1.onset),
                            self.sums.age(sorted.1.1.onset),
                        ],
                    },
                ));
            }
        }
        pairs
    }

    fn pair_evidence(&self, one: usize, two: usize, squared: f64, mixtures: &[Mixture]) -> f64 {
        let shrink = 0.5 * PRIOR_SPREAD / (1.0 + PRIOR_SPREAD);
        let cost = 0.5 * libm::log(1.0 + PRIOR_SPREAD);
        // How much of the prior explains as much as the best profile does: as each alone.
        let room = |place: usize| {
            mixtures
                .get(place)
                .map_or(0.0, |own| own.logarithm() - own.highest)
        };
        // Nothing for what is left, but the same cost, so that pairs are not favoured.
        let tolerance = self.off_direction(2.0, squared, 0.0);
        shrink * squared - 2.0 * cost + room(one) + room(two) + tolerance
    }

    /// Two faults at once, fitted together.
    fn joint(&self, one: (usize, Profile), two: (usize, Profile)) -> Joint {
        let alone = |(place, profile): (usize, Profile)| {
            let level = level(&self.parts, &self.sums, profile.onset);
            score(&self.parts, &self.sums, place, &profile, level)
        };
        let (a, b) = (alone(one), alone(two));
        if a.variance <= 0.0 || b.variance <= 0.0 {
            return Joint::default();
        }
        // In units of each one's own standard deviation.
        let (za, zb) = (a.normalised, b.normalised);
        let correlation = self.cross(one, two) / (a.deviation * b.deviation);
        if correlation.abs() > MOST_ALIKE {
            return Joint::default();
        }
        let determinant = 1.0 - correlation * correlation;
        let (xa, xb) = (
            (za - correlation * zb) / determinant,
            (zb - correlation * za) / determinant,
        );
        let allowed = |place: usize, growth: f64| {
            let hypothesis = self.parts.hypotheses.get(place);
            growth >= 0.0 || hypothesis.is_some_and(|own| own.both_signs)
        };
        if !allowed(one.0, xa) || !allowed(two.0, xb) {
            return Joint::default();
        }
        // What a direction that is a little off explains beside one fault is no second one, however
        // large both are.
        let single = (za * za).max(zb * zb);
        let tolerance = self.parts.options.direction_tolerance;
        let second = za * xa + zb * xb - single - tolerance * tolerance * single;
        Joint {
            squared: single + second.max(0.0),
            magnitudes: [self.size_of(one, &a, xa), self.size_of(two, &b, xb)],
        }
    }

    /// The size now of a fault that beside another is so many of its standard deviations: shared
    /// between the two as the evidence is.
    fn size_of(&self, (place, profile): (usize, Profile), own: &Score, normalised: f64) -> f64 {
        let (alone, _) = size(&self.parts, &self.sums, place, &profile, own);
        let share = normalised / own.normalised;
        if share.is_finite() {
            alone * share
        } else {
            0.0
        }
    }

    /// How alike two faults are to the residuals: `sum f g psi_one' psi_two`.
    fn cross(&self, one: (usize, Profile), two: (usize, Profile)) -> f64 {
        let size = self.size();
        let kinds = (
            self.parts.hypotheses.get(one.0).map(|own| &own.kind),
            self.parts.hypotheses.get(two.0).map(|own| &own.kind),
        );
        match kinds {
            (Some(HypothesisKind::Direction(left)), Some(HypothesisKind::Direction(right))) => {
                let onset = one.1.onset.max(two.1.onset);
                let projected = level(&self.parts, &self.sums, onset)
                    .and_then(|level| level.projected.get(two.0))
                    .map_or(&right[..], |own| &own[..]);
                let product: f64 = left.iter().zip(projected).map(|(l, r)| l * r).sum();
                product * one.1.cross(&two.1, &self.sums, None)
            }
            (Some(HypothesisKind::Direction(direction)), Some(HypothesisKind::Driven(drive)))
            | (Some(HypothesisKind::Driven(drive)), Some(HypothesisKind::Direction(direction))) => {
                let first = DriveSums::of(size, *drive).changes;
                let terms = direction.iter().enumerate();
                terms
                    .map(|(i, g)| g * one.1.cross(&two.1, &self.sums, Some(first + i)))
                    .sum()
            }
            // Two inputs that move apart.
            _ => 0.0,
        }
    }
}

/// What two faults explain together.
#[derive(Debug, Clone, Copy, Default)]
struct Joint {
    squared: f64,
    magnitudes: [f64; 2],
}
