//! Sums from every possible onset until now.

use alloc::vec;
use alloc::vec::Vec;

use super::memory::{MOMENTS, Memory};

/// For each edge between blocks, from the newest on, the moments `sum x`, `sum k x`, `sum k^2 x`
/// of all samples after it, where `k = 1` is the first sample after the edge: what a step, a ramp
/// and the energy of a ramp need that begin there.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Suffixes {
    size: usize,
    /// Samples after each edge.
    ages: Vec<usize>,
    levels: Vec<usize>,
    moments: Vec<f64>,
    edges: usize,
}

impl Suffixes {
    /// Room for the edges of a memory of so many signals.
    pub(crate) fn new(memory: &Memory, signals: usize) -> Self {
        let capacity = memory.capacity();
        Self {
            size: signals * MOMENTS,
            ages: vec![0; capacity],
            levels: vec![0; capacity],
            moments: vec![0.0; capacity * signals * MOMENTS],
            edges: 0,
        }
    }

    /// Takes the sums of a memory.
    pub(crate) fn gather(&mut self, memory: &Memory) {
        let size = self.size;
        let (mut edge, mut age) = (0, 0);
        let (ages, levels, moments) = (&mut self.ages, &mut self.levels, &mut self.moments);
        memory.newest_first(|level, samples, block| {
            if edge >= ages.len() {
                return;
            }
            age += samples;
            ages[edge] = age;
            levels[edge] = level;
            let (before, after) = moments.split_at_mut(edge * size);
            let younger = before.chunks_exact(size).next_back();
            let length = samples as f64;
            let own = after
                .chunks_exact_mut(MOMENTS)
                .zip(block.chunks_exact(MOMENTS));
            match younger {
                None => own.for_each(|(to, block)| to.copy_from_slice(block)),
                Some(younger) => {
                    for ((to, block), later) in own.zip(younger.chunks_exact(MOMENTS)) {
                        if let ([t0, t1, t2], [b0, b1, b2], [s0, s1, s2]) = (to, block, later) {
                            *t0 = s0 + b0;
                            *t1 = s1 + length * s0 + b1;
                            *t2 = s2 + 2.0 * length * s1 + length * length * s0 + b2;
                        }
                    }
                }
            }
            edge += 1;
        });
        self.edges = edge;
    }

    /// Number of edges.
    pub(crate) fn len(&self) -> usize {
        self.edges
    }

    /// Samples after an edge.
    pub(crate) fn age(&self, edge: usize) -> f64 {
        self.ages.get(edge).copied().unwrap_or(0) as f64
    }

    /// The level of the block before which an edge lies.
    pub(crate) fn level(&self, edge: usize) -> usize {
        self.levels.get(edge).copied().unwrap_or(0)
    }

    /// The moments of a signal after an edge.
    pub(crate) fn of(&self, edge: usize, signal: usize) -> [f64; MOMENTS] {
        let start = edge * self.size + signal * MOMENTS;
        let found = self.moments.get(start..start + MOMENTS);
        found
            .and_then(|own| own.try_into().ok())
            .unwrap_or_default()
    }
}
