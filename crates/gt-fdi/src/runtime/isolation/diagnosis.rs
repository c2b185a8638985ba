//! Which fault, since when, how large: probabilities of the hypotheses.

use alloc::vec;
use alloc::vec::Vec;

use serde::{Deserialize, Serialize};

use super::core::{Core, DriveSums, HypothesisKind, LevelParts, SHORTEST};
use super::profile::Profile;
use super::score::{Score, level, score, size};

/// Share of the profiles, before any evidence, that still grow.
const STILL_GROWING: f64 = 0.5;
/// Prior variance of a fault's size over the variance of its estimate: wide, so that a fault with
/// more unknowns needs more evidence.
pub(super) const PRIOR_SPREAD: f64 = 400.0;
/// Standard normal quantile of 97.5 %.
const QUANTILE: f64 = 1.959_963_984_540_054;
/// Power of the likelihoods that onsets are weighed with: how a fault builds up in the residuals is
/// known less well than that it is there, and healthy wander between neighbouring onsets is not
/// independent.
const ONSET_POWER: f64 = 0.4;
/// Prior probability that it is none of the hypotheses, over that of one of them.
const NONE_OF_THESE: f64 = 0.05;
/// Weight of a profile, beside the largest so far, below which its size changes nothing.
const NEGLIGIBLE: f64 = 1e-9;
/// Probability below which the onsets of a hypothesis are not weighed.
const UNLIKELY: f64 = 1e-3;
/// Prior probability of two faults at once, all pairs together.
const TWO_AT_ONCE: f64 = 0.02;

/// How a name is given.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct DiagnosisOptions {
    /// The probability from which on a hypothesis is named.
    pub(crate) confidence: f64,
    /// How far a fault's direction may be off, as a share of its length.
    pub(crate) direction_tolerance: f64,
}

/// What is known of one hypothesis.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Hypothesis {
    /// Its probability, given that there is a fault.
    pub probability: f64,
    /// The fault's size now, in its unit, if it is this one.
    pub magnitude: f64,
    /// Lower end of the 95 % interval of `magnitude`.
    pub magnitude_low: f64,
    /// Upper end of it.
    pub magnitude_high: f64,
    /// Samples since the likeliest onset (the median), if it is this one.
    pub age: f64,
    /// Lower end of the 95 % interval of `age`.
    pub age_low: f64,
    /// Upper end of it.
    pub age_high: f64,
}

/// Two hypotheses together.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Pair {
    /// Positions of the two.
    pub faults: [usize; 2],
    /// The probability of this pair, given that there is a fault.
    pub probability: f64,
    /// Their sizes now, each in its unit.
    pub magnitudes: [f64; 2],
    /// Samples since their likeliest onsets.
    pub ages: [f64; 2],
}

/// What can be said.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Finding {
    /// No hypothesis is probable enough yet.
    Undecided,
    /// The hypothesis of this position.
    Named(usize),
    /// Two hypotheses at once, by position.
    Both(usize, usize),
    /// None of the hypotheses explains what is seen.
    NoneOfThese,
}

/// The probabilities of all hypotheses, given that there is a fault.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Diagnosis {
    /// What can be said.
    pub finding: Finding,
    /// In the order of the hypotheses.
    pub hypotheses: Vec<Hypothesis>,
    /// The probability that it is none of them.
    pub none_of_these: f64,
    /// The likeliest pair, where two faults are more likely than one part in a thousand.
    pub pair: Option<Pair>,
}

/// A sum of exponentials with moments, whatever their size.
#[derive(Debug, Clone)]
pub(super) struct Mixture {
    pub(super) largest: f64,
    total: f64,
    /// What of `total` is in `mean` and `square`.
    sized: f64,
    mean: f64,
    square: f64,
    /// The largest likelihood ratio's logarithm, whatever the prior, with its profile.
    pub(super) highest: f64,
    pub(super) best: Option<Profile>,
}

impl Mixture {
    fn new() -> Self {
        Self {
            largest: f64::NEG_INFINITY,
            total: 0.0,
            sized: 0.0,
            mean: 0.0,
            square: 0.0,
            highest: f64::NEG_INFINITY,
            best: None,
        }
    }

    fn add(
        &mut self,
        (evidence, prior): (f64, f64),
        profile: &Profile,
        size: impl FnOnce() -> (f64, f64),
    ) {
        if evidence > self.highest {
            self.highest = evidence;
            self.best = Some(*profile);
        }
        let logarithm = evidence + libm::log(prior);
        if logarithm > self.largest {
            let shrink = libm::exp(self.largest - logarithm);
            self.total *= shrink;
            self.sized *= shrink;
            self.mean *= shrink;
            self.square *= shrink;
            self.largest = logarithm;
        }
        let weight = libm::exp(logarithm - self.largest);
        self.total += weight;
        if weight > NEGLIGIBLE {
            let (magnitude, variance) = size();
            self.sized += weight;
            self.mean += weight * magnitude;
            self.square += weight * (magnitude * magnitude + variance);
        }
    }

    pub(super) fn logarithm(&self) -> f64 {
        self.largest + libm::log(self.total)
    }
}

/// How likely each onset is, if it is one fault.
#[derive(Debug, Clone)]
struct Onsets {
    largest: f64,
    weights: Vec<f64>,
}

impl Onsets {
    fn new(edges: usize) -> Self {
        Self {
            largest: f64::NEG_INFINITY,
            weights: vec![0.0; edges],
        }
    }

    fn add(&mut self, evidence: f64, prior: f64, onset: usize) {
        let tempered = ONSET_POWER * evidence;
        if tempered > self.largest {
            let shrink = libm::exp(self.largest - tempered);
            for weight in &mut self.weights {
                *weight *= shrink;
            }
            self.largest = tempered;
        }
        if let Some(weight) = self.weights.get_mut(onset) {
            *weight += prior * libm::exp(tempered - self.largest);
        }
    }
}

impl Core {
    /// Weighs all hypotheses by all that the memory holds: for each the likelihood of every onset
    /// and end of growth, with a prior over them and over sizes.
    pub(crate) fn diagnose(&mut self) -> Diagnosis {
        self.refresh();
        let count = self.parts.hypotheses.len();
        let mut mixtures = vec![Mixture::new(); count + 1];
        for (profile, prior) in self.profiles(1, 1) {
            for (place, mixture) in mixtures.iter_mut().enumerate() {
                let level = level(&self.parts, &self.sums, profile.onset);
                let found = score(&self.parts, &self.sums, place, &profile, level);
                let evidence = self.evidence(place, &profile, &found, level);
                mixture.add((evidence, prior), &profile, || {
                    size(&self.parts, &self.sums, place, &profile, &found)
                });
            }
        }
        let singles: Vec<f64> = mixtures.iter().map(Mixture::logarithm).collect();
        let pairs = self.pairs(&mixtures);
        let prior_of_pair = TWO_AT_ONCE / pairs.len().max(1) as f64;
        let pair_logarithms = pairs
            .iter()
            .map(|(logarithm, _)| logarithm + libm::log(prior_of_pair * (count + 1) as f64));
        let all = singles.iter().copied().chain(pair_logarithms.clone());
        let largest = all.clone().fold(f64::NEG_INFINITY, f64::max);
        let total: f64 = all.map(|logarithm| libm::exp(logarithm - largest)).sum();
        let probability = |logarithm: f64| {
            let share = libm::exp(logarithm - largest) / total;
            if share.is_finite() { share } else { 0.0 }
        };
        let hypotheses: Vec<Hypothesis> = mixtures
            .iter()
            .take(count)
            .zip(&singles)
            .enumerate()
            .map(|(place, (mixture, logarithm))| {
                self.describe(place, mixture, probability(*logarithm))
            })
            .collect();
        let none_of_these = singles.last().map_or(0.0, |own| probability(*own));
        let mut likeliest: Option<Pair> = None;
        for ((_, pair), logarithm) in pairs.iter().zip(pair_logarithms) {
            let pair = Pair {
                probability: probability(logarithm),
                ..*pair
            };
            if pair.probability > likeliest.map_or(1e-3, |best| best.probability) {
                likeliest = Some(pair);
            }
        }
        let confidence = self.parts.options.confidence;
        let named = hypotheses
            .iter()
            .position(|hypothesis| hypothesis.probability >= confidence);
        let finding = match (named, likeliest) {
            (Some(place), _) => Finding::Named(place),
            (None, Some(pair)) if pair.probability >= confidence => {
                Finding::Both(pair.faults[0], pair.faults[1])
            }
            _ if none_of_these >= confidence => Finding::NoneOfThese,
            _ => Finding::Undecided,
        };
        let since = match finding {
            Finding::Undecided => f64::INFINITY,
            Finding::Named(place) => hypotheses[place].age,
            Finding::Both(..) => likeliest.map_or(0.0, |pair| pair.ages[0].min(pair.ages[1])),
            Finding::NoneOfThese => {
                let best = mixtures.last().and_then(|own| own.best);
                best.map_or(0.0, |profile| self.sums.age(profile.onset))
            }
        };
        // What residuals do while they answer to a jump is like many faults.
        let finding = if self.is_answering(since) {
            Finding::Undecided
        } else {
            finding
        };
        Diagnosis {
            finding,
            hypotheses,
            none_of_these,
            pair: likeliest,
        }
    }

    /// Profiles with their prior weights, which sum to 1: onsets even in time, half of the faults
    /// still growing, the others full since some time between the onset and now. Of the edges every
    /// `onsets`th may be an onset, every `ends`th an end of growth.
    pub(super) fn profiles(
        &self,
        onsets: usize,
        ends: usize,
    ) -> impl Iterator<Item = (Profile, f64)> + '_ {
        let edges = self.sums.len();
        let horizon = self.sums.age(edges.saturating_sub(1)).max(1.0);
        let places = (0..edges).step_by(onsets);
        let old = places.filter(|&edge| self.sums.age(edge) >= SHORTEST);
        old.flat_map(move |onset| {
            let age = self.sums.age(onset);
            let span = self.spacing(onset, onsets) / horizon;
            let growing = Profile { onset, full: None };
            let full = (0..onset).step_by(ends).map(move |full| {
                let profile = Profile {
                    onset,
                    full: Some(full),
                };
                let share = self.spacing(full, ends) / age;
                (profile, span * (1.0 - STILL_GROWING) * share)
            });
            core::iter::once((growing, span * STILL_GROWING)).chain(full)
        })
    }

    /// Samples for which an edge stands where every `stride`th does.
    fn spacing(&self, edge: usize, stride: usize) -> f64 {
        let younger = edge
            .checked_sub(stride)
            .map_or(0.0, |before| self.sums.age(before));
        (self.sums.age(edge) - younger).max(1.0)
    }

    /// The logarithm of the likelihood ratio of a hypothesis, with its size integrated out, and with
    /// a direction that may be a little off; as residuals wander at `level`.
    fn evidence(
        &self,
        place: usize,
        profile: &Profile,
        found: &Score,
        level: Option<&LevelParts>,
    ) -> f64 {
        let shrink = 0.5 * PRIOR_SPREAD / (1.0 + PRIOR_SPREAD);
        let cost = 0.5 * libm::log(1.0 + PRIOR_SPREAD);
        let size = self.size() as f64;
        if place >= self.parts.hypotheses.len() {
            return shrink * found.squared - size * cost + libm::log(NONE_OF_THESE);
        }
        let left = self.left(place, profile, found, level);
        shrink * found.squared - cost + self.off_direction(1.0, found.squared, left)
    }

    /// What directions that are a little off explain of what so many hypotheses leave.
    pub(super) fn off_direction(&self, hypotheses: f64, squared: f64, left: f64) -> f64 {
        let others = self.size() as f64 - hypotheses;
        if others < 1.0 {
            return 0.0;
        }
        let tolerance = self.parts.options.direction_tolerance;
        let spread = tolerance * tolerance * squared / others;
        0.5 * left * spread / (1.0 + spread) - 0.5 * others * libm::log(1.0 + spread)
    }

    /// Square of the normalised change in any direction that a hypothesis leaves unexplained.
    fn left(
        &self,
        place: usize,
        profile: &Profile,
        found: &Score,
        level: Option<&LevelParts>,
    ) -> f64 {
        let sums = &self.sums;
        let (Some(hypothesis), Some(level)) = (self.parts.hypotheses.get(place), level) else {
            return 0.0;
        };
        let own = profile.own_energy(sums);
        match &hypothesis.kind {
            HypothesisKind::Direction(_) => {
                let total = level.square(|i| profile.weighted(sums, i)) / own;
                let along = found.growth * found.growth / found.variance.max(f64::MIN_POSITIVE);
                (total - along).max(0.0)
            }
            HypothesisKind::Driven(drive) => {
                let first = DriveSums::of(self.size(), *drive).changes;
                let unexplained = |i: usize| {
                    let explained = found.growth * profile.energy(sums, first + i);
                    profile.weighted(sums, i) - explained
                };
                level.square(unexplained) / own
            }
        }
    }

    /// The onsets of a hypothesis. All of them are weighed by how residuals wander over times like
    /// that since the likeliest: a per cent that one level of the memory has too little wander by
    /// would draw all onsets to it.
    fn onsets(&self, place: usize, mixture: &Mixture) -> Onsets {
        let mut onsets = Onsets::new(self.sums.len());
        let Some(best) = mixture.best else {
            return onsets;
        };
        let level = level(&self.parts, &self.sums, best.onset);
        for (profile, prior) in self.profiles(1, 1) {
            let found = score(&self.parts, &self.sums, place, &profile, level);
            let evidence = self.evidence(place, &profile, &found, level);
            onsets.add(evidence, prior, profile.onset);
        }
        onsets
    }

    fn describe(&self, place: usize, mixture: &Mixture, probability: f64) -> Hypothesis {
        let delay = self
            .parts
            .hypotheses
            .get(place)
            .map_or(0.0, |own| own.delay);
        let onsets = if probability >= UNLIKELY {
            self.onsets(place, mixture)
        } else {
            // Nobody asks since when it is not this one.
            let mut onsets = Onsets::new(self.sums.len());
            if let Some(best) = mixture.best {
                onsets.add(0.0, 1.0, best.onset);
            }
            onsets
        };
        let total = mixture.sized.max(f64::MIN_POSITIVE);
        let magnitude = mixture.mean / total;
        // A direction that is off by so much of its length is off along itself by a part of that.
        let tolerance = self.parts.options.direction_tolerance * magnitude;
        let variance = (mixture.square / total - magnitude * magnitude).max(0.0)
            + tolerance * tolerance / self.size().max(1) as f64;
        let half = QUANTILE * libm::sqrt(variance);
        // No finer than the blocks of the memory there.
        let age = |share: f64, blocks: f64| {
            let (age, block) = self.age_at(&onsets.weights, share);
            (age + delay + blocks * block).max(0.0)
        };
        Hypothesis {
            probability,
            magnitude,
            magnitude_low: magnitude - half,
            magnitude_high: magnitude + half,
            age: age(0.5, 0.0),
            age_low: age(0.025, -1.0),
            age_high: age(0.975, 1.0),
        }
    }

    /// The age below which a share of the onsets lies, and the length of the block there; an edge
    /// stands for the time half way to its neighbours.
    fn age_at(&self, weights: &[f64], share: f64) -> (f64, f64) {
        let wanted = share * weights.iter().sum::<f64>();
        let mut before = 0.0;
        for (edge, weight) in weights.iter().enumerate() {
            if before + weight >= wanted && *weight > 0.0 {
                let own = self.sums.age(edge);
                let younger = edge.checked_sub(1).map_or(own, |edge| self.sums.age(edge));
                let older = if edge + 1 < self.sums.len() {
                    self.sums.age(edge + 1)
                } else {
                    own
                };
                let (from, to) = (0.5 * (younger + own), 0.5 * (own + older));
                let age = from + (to - from) * (wanted - before) / weight;
                return (age, self.spacing(edge, 1));
            }
            before += weight;
        }
        let last = self.sums.len().saturating_sub(1);
        (self.sums.age(last), self.spacing(last, 1))
    }
}
