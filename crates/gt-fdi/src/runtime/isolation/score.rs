//! How much speaks for a hypothesis under a profile, and how large the fault is.

use super::core::{CoreParts, DriveSums, HypothesisKind, LevelParts};
use super::lag::{self, LEAST_REAL};
use super::profile::Profile;
use super::suffix::Suffixes;

/// A hypothesis under a profile of growth.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Score {
    /// Square of the normalised agreement; 0 where the sign is wrong.
    pub(super) squared: f64,
    /// Growth of the fault a sample; 0 for a change in any direction.
    pub(super) growth: f64,
    /// Its variance.
    pub(super) variance: f64,
    /// The agreement over its standard deviation, with its sign.
    pub(super) normalised: f64,
    /// That standard deviation.
    pub(super) deviation: f64,
}

/// The size now and its variance that a hypothesis has under a profile, by what is not cut.
pub(super) fn size(
    parts: &CoreParts,
    sums: &Suffixes,
    place: usize,
    profile: &Profile,
    own: &Score,
) -> (f64, f64) {
    let growth = profile.growth(sums);
    match parts.hypotheses.get(place) {
        Some(hypothesis) => match hypothesis.kind {
            HypothesisKind::Driven(drive) => {
                let level = level(parts, sums, profile.onset);
                let size = level.map_or(0, |level| level.metric.len().isqrt());
                let scale = level.and_then(|level| level.scale.get(place)).copied();
                let at = DriveSums::of(size, drive);
                let scale = scale.unwrap_or(1.0);
                lag::size(&hypothesis.lags, sums, at, profile, scale)
            }
            HypothesisKind::Direction(_) => (growth * own.growth, growth * growth * own.variance),
        },
        None => (0.0, 0.0),
    }
}

/// The level of the memory that an onset lies in.
pub(super) fn level<'a>(
    parts: &'a CoreParts,
    sums: &Suffixes,
    onset: usize,
) -> Option<&'a LevelParts> {
    let levels = &parts.levels;
    levels.get(sums.level(onset)).or(levels.last())
}

/// The score of the hypothesis at `place`, as residuals wander at `level`; after the last one, of a
/// change in any direction.
pub(super) fn score(
    parts: &CoreParts,
    sums: &Suffixes,
    place: usize,
    profile: &Profile,
    level: Option<&LevelParts>,
) -> Score {
    let Some(level) = level else {
        return Score::default();
    };
    let Some(hypothesis) = parts.hypotheses.get(place) else {
        let square = level.square(|i| profile.weighted(sums, i));
        return Score {
            squared: square / profile.own_energy(sums),
            ..Score::default()
        };
    };
    let scale = level.scale.get(place).copied().unwrap_or(1.0);
    // For the estimate the energy of what was real, for its error that of all.
    let (agreement, real, variance) = match &hypothesis.kind {
        HypothesisKind::Direction(_) => {
            let projected = level.projected.get(place).into_iter().flatten();
            let terms = projected.enumerate();
            let agreement = terms
                .map(|(i, g)| g * profile.weighted(sums, i))
                .sum::<f64>();
            let energy = scale * profile.own_energy(sums);
            (agreement, energy, energy)
        }
        HypothesisKind::Driven(drive) => {
            let size = level.metric.len().isqrt();
            let own = DriveSums::of(size, *drive);
            let agreement =
                profile.weighted(sums, own.agreement) - hypothesis.offset * profile.sum(sums);
            let energy = profile.energy(sums, own.energy);
            let noise = hypothesis.floor * profile.own_energy(sums);
            let real = (energy - noise).max(LEAST_REAL * energy);
            (agreement, real, scale * (energy + noise))
        }
    };
    if real <= 0.0 || (agreement < 0.0 && !hypothesis.both_signs) {
        return Score::default();
    }
    let deviation = libm::sqrt(variance);
    Score {
        squared: agreement * agreement / variance,
        growth: agreement / real,
        variance: variance / (real * real),
        normalised: agreement / deviation,
        deviation,
    }
}
