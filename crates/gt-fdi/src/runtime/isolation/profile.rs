//! How a fault grows.

use super::memory::MOMENTS;
use super::suffix::Suffixes;

/// A fault that grows evenly from an edge of the memory on, until now or until a later edge, where
/// it stays: a step where that is the next one.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Profile {
    /// The edge at the onset.
    pub(crate) onset: usize,
    /// The edge at which growth ends; `None`: it still grows.
    pub(crate) full: Option<usize>,
}

/// `sum k` and `sum k^2` for `k = 1 ..= age`.
fn ones(age: f64) -> [f64; MOMENTS] {
    let first = age * (age + 1.0) / 2.0;
    [age, first, first * (2.0 * age + 1.0) / 3.0]
}

impl Profile {
    /// Samples for which the fault has grown: its size now over its growth a sample.
    pub(crate) fn growth(&self, sums: &Suffixes) -> f64 {
        sums.age(self.onset) - self.full.map_or(0.0, |full| sums.age(full))
    }

    /// `sum f x` of a signal under this profile `f` of growth 1 a sample.
    pub(crate) fn weighted(&self, sums: &Suffixes, signal: usize) -> f64 {
        let ramp = |edge: usize| sums.of(edge, signal)[1];
        ramp(self.onset) - self.full.map_or(0.0, ramp)
    }

    /// `sum f`.
    pub(crate) fn sum(&self, sums: &Suffixes) -> f64 {
        let ramp = |edge: usize| ones(sums.age(edge))[1];
        ramp(self.onset) - self.full.map_or(0.0, ramp)
    }

    /// `sum f^2 x` of a signal.
    pub(crate) fn energy(&self, sums: &Suffixes, signal: usize) -> f64 {
        self.product(self, sums, |edge| sums.of(edge, signal))
    }

    /// `sum f^2`.
    pub(crate) fn own_energy(&self, sums: &Suffixes) -> f64 {
        self.product(self, sums, |edge| ones(sums.age(edge)))
    }

    /// `sum f g x` of a signal, for another profile `g`.
    pub(crate) fn cross(&self, other: &Self, sums: &Suffixes, signal: Option<usize>) -> f64 {
        match signal {
            Some(signal) => self.product(other, sums, |edge| sums.of(edge, signal)),
            None => self.product(other, sums, |edge| ones(sums.age(edge))),
        }
    }

    fn product(
        &self,
        other: &Self,
        sums: &Suffixes,
        moments: impl Fn(usize) -> [f64; MOMENTS],
    ) -> f64 {
        // Two ramps: the later one with k, the earlier with k plus how much earlier.
        let ramps = |one: usize, two: usize| {
            let (older, newer) = if sums.age(one) >= sums.age(two) {
                (one, two)
            } else {
                (two, one)
            };
            let [_, first, second] = moments(newer);
            second + (sums.age(older) - sums.age(newer)) * first
        };
        let mut total = ramps(self.onset, other.onset);
        if let Some(full) = self.full {
            total -= ramps(full, other.onset);
        }
        if let Some(full) = other.full {
            total -= ramps(self.onset, full);
        }
        if let (Some(one), Some(two)) = (self.full, other.full) {
            total += ramps(one, two);
        }
        total
    }
}
