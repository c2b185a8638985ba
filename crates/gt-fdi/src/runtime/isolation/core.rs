//! The evidence for each hypothesis, sample by sample.

use alloc::boxed::Box;
use alloc::vec;
use alloc::vec::Vec;

use serde::Serialize;

use super::diagnosis::DiagnosisOptions;
use super::drive::Drive;
use super::joint_whitener::JointWhitener;
use super::memory::Memory;
use super::profile::Profile;
use super::suffix::Suffixes;
use crate::runtime::{Generator, Update};

/// What a fault does to the whitened residuals.
#[derive(Debug, Clone, PartialEq)]
pub(crate) enum HypothesisKind {
    /// A lasting change of them (m) for each unit of the fault.
    Direction(Vec<f64>),
    /// A change that follows an input, by the drive of this number.
    Driven(usize),
}

/// A hypothesis in numbers.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct HypothesisParts {
    pub(crate) kind: HypothesisKind,
    /// Whether the fault has both signs; else it is positive.
    pub(crate) both_signs: bool,
    /// Healthy mean of the agreement between residuals and drive, a sample.
    pub(crate) offset: f64,
    /// Energy of the drive that is its own noise's, a sample.
    pub(crate) floor: f64,
    /// Samples by which the residuals come late.
    pub(crate) delay: f64,
}

/// What a [`Core`] is made of.
#[derive(Debug, Clone)]
pub(crate) struct CoreParts {
    pub(crate) generators: Vec<Generator>,
    pub(crate) whitener: JointWhitener,
    /// Whitened residuals further than this from their own level count as this far.
    pub(crate) limiter: f64,
    pub(crate) hypotheses: Vec<HypothesisParts>,
    pub(crate) drives: Vec<Drive>,
    /// Samples by which drives are late.
    pub(crate) delay: usize,
    /// Samples until the generators have settled.
    pub(crate) settle: usize,
    /// How far back onsets are looked for, in samples.
    pub(crate) longest: usize,
    /// A limit a hypothesis, and one for a change in any direction.
    pub(crate) limits: Vec<f64>,
    /// For each of them, by the memory's level, the healthy mean of its square over that of white
    /// residuals, at least 1.
    pub(crate) dispersion: Vec<Vec<f64>>,
    pub(crate) options: DiagnosisOptions,
}

/// What isolation says of a sample.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct IsolationVerdict {
    /// Time of the sample in seconds.
    pub time_s: f64,
    /// The statistic of each hypothesis and, last, of a change in any direction: the logarithm of
    /// its likelihood ratio at the likeliest onset, over how much healthy residuals exceed white
    /// ones. Renewed every eighth sample.
    pub statistics: Vec<f64>,
    /// Whether a statistic is above its limit.
    pub exceeds: bool,
    /// Whether an alarm is up.
    pub alarm: bool,
    /// Whether the alarm came up with this sample.
    pub new_alarm: bool,
    /// Position of the statistic furthest above its limit, while one is.
    pub leading: Option<usize>,
    /// Whether the generators have not yet settled, so that nothing is judged.
    pub settling: bool,
}

/// Share by which the level of a residual follows each sample: about five seconds of ten a second.
const FOLLOW: f64 = 1.0 / 64.0;
/// Blocks between two scans.
const BLOCKS_A_SCAN: usize = 2;
/// Scans without an exceedance that end an alarm.
const RELEASE_SCANS: usize = 64;
/// The youngest onset that is judged, in samples.
pub(super) const SHORTEST: f64 = 8.0;

/// Generators, whitening, memory and statistics.
#[derive(Debug, Clone)]
pub(crate) struct Core {
    pub(super) parts: CoreParts,
    memory: Memory,
    pub(super) sums: Suffixes,
    residuals: Box<[f64]>,
    /// Where each whitened residual has been lately, so that bursts are cut and lasting changes, of
    /// whatever size, are not.
    levels: Box<[f64]>,
    /// Whitened residuals on their way to the memory, round.
    waiting: Vec<Box<[f64]>>,
    next_waiting: usize,
    sample: Box<[f64]>,
    unsettled: usize,
    blocks: usize,
    quiet_scans: usize,
    verdict: IsolationVerdict,
}

impl Core {
    pub(crate) fn new(parts: CoreParts) -> Self {
        let size: usize = parts.generators.iter().map(Generator::ny).sum();
        let signals = signals(size, parts.drives.len());
        let memory = Memory::new(signals, parts.longest);
        let sums = Suffixes::new(&memory, signals);
        let unsettled = parts.settle + parts.whitener.order();
        Self {
            memory,
            sums,
            residuals: vec![0.0; size].into(),
            levels: vec![0.0; size].into(),
            waiting: vec![vec![0.0; size].into(); parts.delay + 1],
            next_waiting: 0,
            sample: vec![0.0; signals].into(),
            unsettled,
            blocks: 0,
            quiet_scans: 0,
            verdict: IsolationVerdict {
                time_s: f64::NAN,
                statistics: vec![0.0; parts.hypotheses.len() + 1],
                exceeds: false,
                alarm: false,
                new_alarm: false,
                leading: None,
                settling: true,
            },
            parts,
        }
    }

    /// Residuals.
    pub(super) fn size(&self) -> usize {
        self.residuals.len()
    }

    /// Takes a sample.
    pub(crate) fn step(&mut self, time_s: f64, u: &[f64], y: &[f64]) -> &IsolationVerdict {
        let mut worst = Update::Residual;
        let mut first = 0;
        for generator in &mut self.parts.generators {
            let own = first..first + generator.ny();
            if let Some(residuals) = self.residuals.get_mut(own.clone()) {
                worst = worst.max(generator.step(u, y, first, residuals));
            }
            first = own.end;
        }
        if worst != Update::Residual {
            self.unsettled = self.parts.settle + self.parts.whitener.order();
        }
        let limiter = self.parts.limiter;
        let white = self.parts.whitener.step(&self.residuals);
        let settling = self.unsettled > 0;
        self.unsettled = self.unsettled.saturating_sub(1);
        if let Some(newest) = self.waiting.get_mut(self.next_waiting) {
            for ((to, from), level) in newest.iter_mut().zip(white).zip(&mut self.levels) {
                // Without a residual there is no evidence.
                *to = 0.0;
                if !settling {
                    let step = (from - *level).clamp(-limiter, limiter);
                    *to = *level + step;
                    *level += FOLLOW * step;
                }
            }
        }
        self.next_waiting = (self.next_waiting + 1) % self.waiting.len();
        let full = self.collect(u) && self.memory.push(&self.sample);
        self.verdict.time_s = time_s;
        self.verdict.new_alarm = false;
        self.verdict.settling = settling;
        if full {
            self.blocks = (self.blocks + 1) % BLOCKS_A_SCAN;
            if self.blocks == 0 {
                self.scan();
            }
        }
        &self.verdict
    }

    pub(crate) fn verdict(&self) -> &IsolationVerdict {
        &self.verdict
    }

    /// The oldest residuals that wait, with what the drives say of the same time.
    fn collect(&mut self, u: &[f64]) -> bool {
        let Some(white) = self.waiting.get(self.next_waiting) else {
            return false;
        };
        let size = white.len();
        let (own, driven) = self.sample.split_at_mut(size);
        own.copy_from_slice(white);
        let settled = own.iter().any(|value| *value != 0.0);
        for (drive, places) in self
            .parts
            .drives
            .iter_mut()
            .zip(driven.chunks_mut(size + 2))
        {
            let change = drive.step(u);
            if let [agreement, energy, changes @ ..] = places {
                let shown = |value: f64| if settled { value } else { 0.0 };
                *agreement = shown(dot(own, change));
                *energy = shown(dot(change, change));
                for (to, from) in changes.iter_mut().zip(change) {
                    *to = shown(*from);
                }
            }
        }
        true
    }

    /// Judges all onsets.
    fn scan(&mut self) {
        self.sums.gather(&self.memory);
        let best = vec_of_zeros(&mut self.verdict.statistics);
        for edge in 0..self.sums.len() {
            if self.sums.age(edge) < SHORTEST {
                continue;
            }
            let profile = Profile {
                onset: edge,
                full: None,
            };
            for (place, best) in best.iter_mut().enumerate() {
                let half = 0.5 * score(&self.parts, &self.sums, place, &profile).squared;
                *best = best.max(half);
            }
        }
        let statistics = self.verdict.statistics.iter().zip(&self.parts.limits);
        let ratios = statistics.map(|(statistic, limit)| statistic / limit);
        let leading = ratios
            .enumerate()
            .max_by(|left, right| left.1.total_cmp(&right.1));
        let above = leading.filter(|(_, ratio)| *ratio > 1.0);
        self.verdict.leading = above.map(|(place, _)| place);
        self.verdict.exceeds = above.is_some();
        if above.is_some() {
            self.quiet_scans = 0;
            self.verdict.new_alarm = !self.verdict.alarm;
            self.verdict.alarm = true;
        } else if self.verdict.alarm {
            self.quiet_scans += 1;
            if self.quiet_scans >= RELEASE_SCANS {
                self.verdict.alarm = false;
                self.quiet_scans = 0;
            }
        }
    }

    /// Forgets all samples.
    pub(crate) fn reset(&mut self) {
        for generator in &mut self.parts.generators {
            generator.reset();
        }
        for drive in &mut self.parts.drives {
            drive.reset();
        }
        self.parts.whitener.reset();
        self.memory.reset();
        self.sums.gather(&self.memory);
        self.levels.fill(0.0);
        for waiting in &mut self.waiting {
            waiting.fill(0.0);
        }
        self.unsettled = self.parts.settle + self.parts.whitener.order();
        (self.blocks, self.quiet_scans) = (0, 0);
        self.verdict.statistics.fill(0.0);
        self.verdict.time_s = f64::NAN;
        (self.verdict.exceeds, self.verdict.alarm) = (false, false);
        (self.verdict.new_alarm, self.verdict.leading) = (false, None);
        self.verdict.settling = true;
    }

    /// Brings the sums up to the newest sample.
    pub(super) fn refresh(&mut self) {
        self.sums.gather(&self.memory);
    }

    /// Levels of the memory.
    pub(crate) fn levels(&self) -> usize {
        self.memory.levels()
    }

    /// For each statistic the square at every edge with the edge's level, as of the last scan;
    /// for calibration.
    pub(crate) fn squares(&self, mut visit: impl FnMut(usize, usize, f64)) {
        for edge in 0..self.sums.len() {
            if self.sums.age(edge) < SHORTEST {
                continue;
            }
            let profile = Profile {
                onset: edge,
                full: None,
            };
            for place in 0..=self.parts.hypotheses.len() {
                let squared = score(&self.parts, &self.sums, place, &profile).squared;
                visit(place, self.sums.level(edge), squared);
            }
        }
    }

    /// The sample that the memory took last: whitened residuals, then a drive's agreement, energy
    /// and changes.
    pub(crate) fn last_sample(&self) -> &[f64] {
        &self.sample
    }
}

/// Signals in the memory.
fn signals(size: usize, drives: usize) -> usize {
    size + drives * (size + 2)
}

fn dot(left: &[f64], right: &[f64]) -> f64 {
    left.iter().zip(right).map(|(l, r)| l * r).sum()
}

fn vec_of_zeros(values: &mut [f64]) -> &mut [f64] {
    values.fill(0.0);
    values
}

/// A hypothesis under a profile of growth.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Score {
    /// Square of the normalised agreement, over the dispersion; 0 where the sign is wrong.
    pub(super) squared: f64,
    /// Growth of the fault a sample; 0 for a change in any direction.
    pub(super) growth: f64,
    /// Its variance.
    pub(super) variance: f64,
}

/// The score of the hypothesis at `place`; after the last one, of a change in any direction.
pub(super) fn score(parts: &CoreParts, sums: &Suffixes, place: usize, profile: &Profile) -> Score {
    let level = sums.level(profile.onset);
    let levels = parts.dispersion.get(place);
    let dispersion = levels
        .and_then(|own| own.get(level).or(own.last()))
        .copied()
        .unwrap_or(1.0);
    let size = parts.generators.iter().map(Generator::ny).sum::<usize>();
    let Some(hypothesis) = parts.hypotheses.get(place) else {
        let energy = profile.own_energy(sums);
        let squares = (0..size).map(|i| profile.weighted(sums, i).powi(2));
        return Score {
            squared: squares.sum::<f64>() / energy / dispersion,
            growth: 0.0,
            variance: 0.0,
        };
    };
    let (agreement, energy) = match &hypothesis.kind {
        HypothesisKind::Direction(direction) => {
            let terms = direction.iter().enumerate();
            let agreement = terms
                .map(|(i, g)| g * profile.weighted(sums, i))
                .sum::<f64>();
            (
                agreement,
                dot(direction, direction) * profile.own_energy(sums),
            )
        }
        HypothesisKind::Driven(drive) => {
            let first = size + drive * (size + 2);
            let agreement = profile.weighted(sums, first) - hypothesis.offset * profile.sum(sums);
            let energy = profile.energy(sums, first + 1);
            (
                agreement,
                energy + hypothesis.floor * profile.own_energy(sums),
            )
        }
    };
    if energy <= 0.0 || (agreement < 0.0 && !hypothesis.both_signs) {
        return Score::default();
    }
    Score {
        squared: agreement * agreement / energy / dispersion,
        growth: agreement / energy,
        variance: dispersion / energy,
    }
}
