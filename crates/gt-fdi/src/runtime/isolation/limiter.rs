//! Bursts cut, lasting changes not.

use alloc::boxed::Box;
use alloc::vec;

use super::recall::{self, Recall};

/// Share by which the level of a residual follows each sample: about five seconds of ten a second.
const FOLLOW: f64 = 1.0 / 64.0;

/// Cuts what is far from where whitened residuals have been lately: all of them by one share, so
/// that their direction stays what it is. What lasts longer than any burst in healthy records is no
/// burst, and is taken as it is.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Limiter {
    /// The furthest that counts.
    limit: f64,
    /// The longest burst, in samples.
    burst: usize,
    /// Where each residual has been.
    levels: Box<[f64]>,
    /// Samples in a row beyond the limit.
    beyond: usize,
}

impl Limiter {
    pub(super) fn new(size: usize, limit: f64, burst: usize) -> Self {
        Self {
            limit,
            burst,
            levels: vec![0.0; size].into(),
            beyond: 0,
        }
    }

    /// What counts of a sample.
    pub(super) fn step(&mut self, white: &[f64], cut: &mut [f64]) {
        let moves = white.iter().zip(self.levels.iter());
        let furthest = moves.fold(0.0, |most: f64, (from, level)| {
            most.max((from - level).abs())
        });
        let share = if furthest > self.limit {
            self.beyond = self.beyond.saturating_add(1);
            self.limit / furthest
        } else {
            self.beyond = 0;
            1.0
        };
        if self.beyond > self.burst {
            self.beyond = 0;
            cut.copy_from_slice(white);
            self.levels.copy_from_slice(white);
            return;
        }
        for ((to, from), level) in cut.iter_mut().zip(white).zip(self.levels.iter_mut()) {
            let step = share * (from - *level);
            *to = *level + step;
            *level += FOLLOW * step;
        }
    }

    /// Samples in a row, the last one included, that were beyond the limit.
    pub(super) fn beyond(&self) -> usize {
        self.beyond
    }

    /// Forgets where residuals have been.
    pub(super) fn reset(&mut self) {
        self.levels.fill(0.0);
        self.beyond = 0;
    }
}

impl Recall for Limiter {
    fn recall(&mut self, visit: &mut dyn FnMut(&mut f64)) {
        recall::numbers(&mut self.levels, visit);
        recall::count(&mut self.beyond, self.burst, visit);
    }
}

#[cfg(test)]
mod tests {
    use alloc::vec::Vec;

    use super::*;

    fn run(burst: usize, samples: &[[f64; 2]]) -> Vec<[f64; 2]> {
        let mut limiter = Limiter::new(2, 4.0, burst);
        let step = |white: &[f64; 2]| {
            let mut cut = [0.0; 2];
            limiter.step(white, &mut cut);
            cut
        };
        samples.iter().map(step).collect()
    }

    #[test]
    fn a_burst_is_cut_and_keeps_its_direction() {
        let cut = run(3, &[[1.0, 2.0], [60.0, -30.0], [60.0, -30.0], [0.5, 0.0]]);
        let expected = [[1.0, 2.0], [4.0, -2.0], [4.0, -2.0], [0.5, 0.0]];
        for (found, expected) in cut.into_iter().zip(expected) {
            // The level has moved by some hundredths.
            let far = |i: usize| (found[i] - expected[i]).abs();
            assert!(far(0) < 0.1 && far(1) < 0.1, "{found:?} {expected:?}");
        }
    }

    #[test]
    fn what_lasts_longer_than_a_burst_is_taken_as_it_is() {
        let mut there_and_back = [[60.0, -30.0]; 12];
        there_and_back[6..].fill([0.0, 0.0]);
        let cut = run(3, &there_and_back);
        assert!(cut[..3].iter().all(|own| own[0] < 5.0), "{cut:?}");
        assert_eq!(&cut[3..6], &[[60.0, -30.0]; 3]);
        // Back to nothing is as far.
        assert!(cut[6..9].iter().all(|own| own[0] > 50.0), "{cut:?}");
        assert_eq!(&cut[9..], &[[0.0, 0.0]; 3]);
    }
}
