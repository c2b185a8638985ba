//! Sums over the past in blocks that grow with their age.

use alloc::vec;
use alloc::vec::Vec;

use super::recall::{self, Recall};

/// Samples in the youngest blocks.
pub(super) const YOUNGEST: usize = 4;
/// Blocks of one length that are kept before two are joined: an onset is resolved to between a
/// sixteenth and a thirty-second of its age.
const KEPT: usize = 16;
/// Moments of each signal: `sum x`, `sum j x`, `sum j^2 x`.
pub(crate) const MOMENTS: usize = 3;

/// The moments of some signals over consecutive blocks of samples, the older the longer: memory and
/// time grow with the logarithm of how far back it reaches (an exponential histogram: Datar, Gionis,
/// Indyk and Motwani, *SIAM Journal on Computing* 31, 2002).
///
/// In each block `j = 1` is its oldest sample, so sums stay small however long it runs.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Memory {
    signals: usize,
    /// A level a block length, the youngest first.
    levels: Vec<Level>,
    /// The block that is being filled, and its samples so far.
    current: Vec<f64>,
    filled: usize,
    /// A block on its way between levels.
    carried: Vec<f64>,
}

/// Blocks of one length, in a ring.
#[derive(Debug, Clone, PartialEq)]
struct Level {
    blocks: Vec<f64>,
    oldest: usize,
    count: usize,
}

impl Memory {
    /// No samples yet of `signals` signals; reaches back at least `longest` samples.
    pub(crate) fn new(signals: usize, longest: usize) -> Self {
        let mut levels = Vec::new();
        let (mut reach, mut length) = (0, YOUNGEST);
        while reach < longest || levels.is_empty() {
            levels.push(Level {
                blocks: vec![0.0; (KEPT + 2) * signals * MOMENTS],
                oldest: 0,
                count: 0,
            });
            reach += KEPT * length;
            length *= 2;
        }
        Self {
            signals,
            levels,
            current: vec![0.0; signals * MOMENTS],
            filled: 0,
            carried: vec![0.0; signals * MOMENTS],
        }
    }

    /// The most blocks there can be, the one being filled included.
    pub(crate) fn capacity(&self) -> usize {
        self.levels.len() * (KEPT + 1) + 1
    }

    /// Number of levels.
    pub(crate) fn levels(&self) -> usize {
        self.levels.len()
    }

    /// Takes a sample of every signal; says whether it filled a block.
    pub(crate) fn push(&mut self, sample: &[f64]) -> bool {
        self.filled += 1;
        let j = self.filled as f64;
        for (sums, x) in self.current.chunks_exact_mut(MOMENTS).zip(sample) {
            let weighted = [*x, j * x, j * j * x];
            for (sum, x) in sums.iter_mut().zip(weighted) {
                *sum += x;
            }
        }
        if self.filled < YOUNGEST {
            return false;
        }
        self.filled = 0;
        self.carried.copy_from_slice(&self.current);
        self.current.fill(0.0);
        let size = self.signals * MOMENTS;
        let mut length = YOUNGEST as f64;
        for level in &mut self.levels {
            level.append(&self.carried, size);
            if level.count <= KEPT + 1 {
                return true;
            }
            level.join_oldest(&mut self.carried, size, length);
            length *= 2.0;
        }
        true
    }

    /// Forgets everything.
    pub(crate) fn reset(&mut self) {
        for level in &mut self.levels {
            (level.oldest, level.count) = (0, 0);
        }
        self.current.fill(0.0);
        self.filled = 0;
    }

    /// Calls `visit(level, samples, moments)` for each block from the newest to the oldest.
    pub(crate) fn newest_first(&self, mut visit: impl FnMut(usize, usize, &[f64])) {
        if self.filled > 0 {
            visit(0, self.filled, &self.current);
        }
        let size = self.signals * MOMENTS;
        for (index, level) in self.levels.iter().enumerate() {
            for back in 1..=level.count {
                let slot = (level.oldest + level.count - back) % (KEPT + 2);
                if let Some(block) = level.blocks.get(slot * size..(slot + 1) * size) {
                    visit(index, YOUNGEST << index, block);
                }
            }
        }
    }
}

impl Recall for Memory {
    fn recall(&mut self, visit: &mut dyn FnMut(&mut f64)) {
        for level in &mut self.levels {
            recall::numbers(&mut level.blocks, visit);
            recall::count(&mut level.oldest, KEPT + 1, visit);
            recall::count(&mut level.count, KEPT + 1, visit);
        }
        recall::numbers(&mut self.current, visit);
        recall::count(&mut self.filled, YOUNGEST - 1, visit);
    }
}

impl Level {
    fn append(&mut self, block: &[f64], size: usize) {
        let slot = (self.oldest + self.count) % (KEPT + 2);
        if let Some(place) = self.blocks.get_mut(slot * size..(slot + 1) * size) {
            place.copy_from_slice(block);
            self.count += 1;
        }
    }

    /// Takes the two oldest blocks out and joins them.
    fn join_oldest(&mut self, joined: &mut [f64], size: usize, length: f64) {
        let second = (self.oldest + 1) % (KEPT + 2);
        let older = self
            .blocks
            .get(self.oldest * size..(self.oldest + 1) * size);
        if let Some(older) = older {
            joined.copy_from_slice(older);
        }
        if let Some(younger) = self.blocks.get(second * size..(second + 1) * size) {
            let pairs = joined
                .chunks_exact_mut(MOMENTS)
                .zip(younger.chunks_exact(MOMENTS));
            for (older, younger) in pairs {
                if let ([a0, a1, a2], [b0, b1, b2]) = (older, younger) {
                    *a2 += b2 + 2.0 * length * b1 + length * length * b0;
                    *a1 += b1 + length * b0;
                    *a0 += b0;
                }
            }
        }
        self.oldest = (self.oldest + 2) % (KEPT + 2);
        self.count -= 2;
    }
}
