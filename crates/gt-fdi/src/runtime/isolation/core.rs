//! The evidence for each hypothesis, sample by sample.

use alloc::boxed::Box;
use alloc::vec;
use alloc::vec::Vec;

use serde::Serialize;

use super::diagnosis::DiagnosisOptions;
use super::drive::Drive;
use super::joint_whitener::JointWhitener;
use super::lag::{LAGS, LagParts};
use super::limiter::Limiter;
use super::memory::{Memory, YOUNGEST};
use super::profile::Profile;
use super::recall::{self, Recall};
use super::score::{level, score};
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
    /// What tells the size of a lag; empty for other faults.
    pub(crate) lags: Vec<LagParts>,
}

/// How healthy residuals wander over times of one level of the memory.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct LevelParts {
    /// Inverse `M` of the covariance (m x m, row by row) of normalised sums; the identity for white
    /// residuals.
    pub(crate) metric: Vec<f64>,
    /// Of each hypothesis with a direction `g`: `M g`; else nothing.
    pub(crate) projected: Vec<Vec<f64>>,
    /// Of each hypothesis: `g' M g`; of a driven one the variance of its normalised agreement.
    pub(crate) scale: Vec<f64>,
}

impl LevelParts {
    /// `s' M s`.
    pub(super) fn square(&self, s: impl Fn(usize) -> f64) -> f64 {
        let size = self.metric.len().isqrt();
        let rows = self.metric.chunks_exact(size.max(1)).enumerate();
        rows.map(|(i, row)| {
            let own = s(i);
            let terms = row.iter().enumerate();
            terms.map(|(j, value)| own * value * s(j)).sum::<f64>()
        })
        .sum()
    }
}

/// What a [`Core`] is made of.
#[derive(Debug, Clone)]
pub(crate) struct CoreParts {
    pub(crate) generators: Vec<Generator>,
    pub(crate) whitener: JointWhitener,
    /// Whitened residuals further than this from their own level count as this far.
    pub(crate) limiter: f64,
    /// What is beyond that for more samples in a row is no burst.
    pub(crate) burst: usize,
    pub(crate) hypotheses: Vec<HypothesisParts>,
    pub(crate) drives: Vec<Drive>,
    /// Samples by which drives are late.
    pub(crate) delay: usize,
    /// Samples until the generators have settled.
    pub(crate) settle: usize,
    /// Samples in which residuals answer to a fault that comes at once.
    pub(crate) answer: usize,
    /// How far back onsets are looked for, in samples.
    pub(crate) longest: usize,
    /// A limit a hypothesis, and one for a change in any direction.
    pub(crate) limits: Vec<f64>,
    /// How healthy residuals wander, by the memory's level.
    pub(crate) levels: Vec<LevelParts>,
    pub(crate) options: DiagnosisOptions,
}

/// What isolation says of a sample.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[allow(clippy::struct_excessive_bools)] // four independent answers, read by name
pub struct IsolationVerdict {
    /// Time of the sample in seconds.
    pub time_s: f64,
    /// The statistic of each hypothesis and, last, of a change in any direction: the logarithm of
    /// its likelihood ratio at the likeliest onset. Renewed every eighth sample.
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

impl IsolationVerdict {
    /// The largest ratio of a statistic to its limit.
    pub fn worst_ratio(&self, limits: &[f64]) -> f64 {
        let ratios = self.statistics.iter().zip(limits);
        ratios.map(|(own, limit)| own / limit).fold(0.0, f64::max)
    }
}

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
    /// Cuts bursts, and lasting changes of whatever size not.
    limiter: Limiter,
    /// Whitened residuals on their way to the memory, round: with bursts cut, then as they were.
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
            limiter: Limiter::new(size, parts.limiter, parts.burst),
            waiting: vec![vec![0.0; 2 * size].into(); parts.delay + 1],
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
        let white = self.parts.whitener.step(&self.residuals);
        let settling = self.unsettled > 0;
        self.unsettled = self.unsettled.saturating_sub(1);
        if let Some(newest) = self.waiting.get_mut(self.next_waiting) {
            // Without a residual there is no evidence.
            newest.fill(0.0);
            if !settling {
                let (cut, whole) = newest.split_at_mut(white.len());
                whole.copy_from_slice(white);
                self.limiter.step(white, cut);
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

    /// The residuals of the last sample, not whitened; NaN where something was missing.
    pub(crate) fn residuals(&self) -> &[f64] {
        &self.residuals
    }

    /// The oldest residuals that wait, with what the drives say of the same time.
    fn collect(&mut self, u: &[f64]) -> bool {
        let Some(waiting) = self.waiting.get(self.next_waiting) else {
            return false;
        };
        let size = self.residuals.len();
        let (white, whole) = waiting.split_at(size);
        let (own, driven) = self.sample.split_at_mut(size);
        own.copy_from_slice(white);
        let settled = own.iter().any(|value| *value != 0.0);
        for (drive, places) in self
            .parts
            .drives
            .iter_mut()
            .zip(driven.chunks_mut(size + DriveSums::COUNT))
        {
            drive.step(u);
            let shown = |value: f64| if settled { value } else { 0.0 };
            let change = drive.change(0);
            let (changes, places) = places.split_at_mut(size);
            for (to, from) in changes.iter_mut().zip(change) {
                *to = shown(*from);
            }
            // With the residuals as they are: what a lag does comes in bursts.
            for (lag, pair) in places.chunks_exact_mut(2).enumerate() {
                let change = drive.change(lag);
                if let [agreement, energy] = pair {
                    *agreement = shown(dot(whole, change));
                    *energy = shown(dot(change, change));
                }
            }
        }
        true
    }

    /// Judges all onsets.
    fn scan(&mut self) {
        self.sums.gather(&self.memory);
        let best = &mut self.verdict.statistics;
        best.fill(0.0);
        for edge in 0..self.sums.len() {
            if self.sums.age(edge) < SHORTEST {
                continue;
            }
            let profile = Profile {
                onset: edge,
                full: None,
            };
            let level = level(&self.parts, &self.sums, edge);
            for (place, best) in best.iter_mut().enumerate() {
                let half = 0.5 * score(&self.parts, &self.sums, place, &profile, level).squared;
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

    /// Takes the time of the last sample, after a recall.
    pub(crate) fn set_time_s(&mut self, time_s: f64) {
        self.verdict.time_s = time_s;
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
        self.limiter.reset();
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

    /// Whether residuals may still answer to a jump so many samples ago, so that nothing tells what it
    /// is: an onset is known to two scans or so.
    pub(super) fn is_answering(&self, age: f64) -> bool {
        let scans = (2 * BLOCKS_A_SCAN * YOUNGEST) as f64;
        age < self.parts.answer as f64 + scans
    }

    /// Brings the sums up to the newest sample.
    pub(super) fn refresh(&mut self) {
        self.sums.gather(&self.memory);
    }

    /// Samples in a row beyond the limiter.
    pub(crate) fn beyond(&self) -> usize {
        self.limiter.beyond()
    }

    /// Levels of the memory.
    pub(crate) fn levels(&self) -> usize {
        self.memory.levels()
    }

    /// For calibration: `visit(level, place, values)` with the normalised sums (m) of the whitened
    /// residuals for every edge, as of the last scan, under the place one past the hypotheses, and
    /// with the normalised agreement of each driven hypothesis under its own.
    pub(crate) fn normalised(&self, mut visit: impl FnMut(usize, usize, &[f64])) {
        let mut values = vec![0.0; self.size()];
        let count = self.parts.hypotheses.len();
        for edge in 0..self.sums.len() {
            if self.sums.age(edge) < SHORTEST {
                continue;
            }
            let profile = Profile {
                onset: edge,
                full: None,
            };
            let root = libm::sqrt(profile.own_energy(&self.sums));
            for (i, value) in values.iter_mut().enumerate() {
                *value = profile.weighted(&self.sums, i) / root;
            }
            let index = self.sums.level(edge);
            visit(index, count, &values);
            for (place, hypothesis) in self.parts.hypotheses.iter().enumerate() {
                if matches!(hypothesis.kind, HypothesisKind::Driven(_)) {
                    let own = level(&self.parts, &self.sums, edge);
                    let squared = score(&self.parts, &self.sums, place, &profile, own).squared;
                    visit(index, place, &[libm::sqrt(squared)]);
                }
            }
        }
    }

    /// The sample that the memory took last: whitened residuals, then a drive's [`DriveSums`] and
    /// changes.
    pub(crate) fn last_sample(&self) -> &[f64] {
        &self.sample
    }
}

impl Recall for Core {
    fn recall(&mut self, visit: &mut dyn FnMut(&mut f64)) {
        for generator in &mut self.parts.generators {
            recall::numbers(generator.state_mut(), visit);
        }
        self.parts.whitener.recall(visit);
        for drive in &mut self.parts.drives {
            drive.recall(visit);
        }
        self.memory.recall(visit);
        recall::numbers(&mut self.residuals, visit);
        self.limiter.recall(visit);
        for waiting in &mut self.waiting {
            recall::numbers(waiting, visit);
        }
        let slots = self.waiting.len();
        recall::count(&mut self.next_waiting, slots.saturating_sub(1), visit);
        let settle = self.parts.settle + self.parts.whitener.order();
        recall::count(&mut self.unsettled, settle, visit);
        recall::count(&mut self.blocks, BLOCKS_A_SCAN - 1, visit);
        recall::count(&mut self.quiet_scans, RELEASE_SCANS, visit);
        let verdict = &mut self.verdict;
        recall::numbers(&mut verdict.statistics, visit);
        for flag in [
            &mut verdict.exceeds,
            &mut verdict.alarm,
            &mut verdict.new_alarm,
            &mut verdict.settling,
        ] {
            recall::flag(flag, visit);
        }
        // Nothing leads is 0, the first statistic 1.
        let mut leading = verdict.leading.map_or(0, |place| place + 1);
        recall::count(&mut leading, verdict.statistics.len(), visit);
        verdict.leading = leading.checked_sub(1);
        // Sums are those of the last scan only after the next.
        self.sums.gather(&self.memory);
    }
}

/// Signals in the memory.
fn signals(size: usize, drives: usize) -> usize {
    size + drives * (size + DriveSums::COUNT)
}

/// Where the memory has what a drive says: the changes (m) it would make round its nominal lag,
/// their agreement with the residuals, bursts not cut, and their energy, then agreement and energy
/// for each of [`LAGS`].
#[derive(Debug, Clone, Copy)]
pub(crate) struct DriveSums {
    pub(crate) changes: usize,
    pub(crate) agreement: usize,
    pub(crate) energy: usize,
}

impl DriveSums {
    const COUNT: usize = 2 + 2 * LAGS.len();

    /// Of the drive of this number beside `size` residuals.
    pub(crate) fn of(size: usize, drive: usize) -> Self {
        let changes = size + drive * (size + Self::COUNT);
        Self {
            changes,
            agreement: changes + size,
            energy: changes + size + 1,
        }
    }

    /// Agreement and energy round one of [`LAGS`].
    pub(crate) fn lag(&self, index: usize) -> [usize; 2] {
        let first = self.energy + 1 + 2 * index;
        [first, first + 1]
    }
}

fn dot(left: &[f64], right: &[f64]) -> f64 {
    left.iter().zip(right).map(|(l, r)| l * r).sum()
}
