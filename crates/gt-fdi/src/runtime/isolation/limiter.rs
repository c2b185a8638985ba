//! Bursts cut, lasting changes not.

use alloc::boxed::Box;
use alloc::vec;

use super::recall::{self, Recall};

/// Share by which the level of a residual follows each sample: about five seconds of ten a second.
const FOLLOW: f64 = 1.0 / 64.0;

/// What a sample is.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Phase {
    /// Within the limit, or after a jump that residuals have answered to.
    Plain,
    /// Beyond the limit for no longer than a burst may last.
    Burst,
    /// Beyond it for longer, while residuals still answer: what they do says nothing of what jumped,
    /// nor did the burst that it began with.
    Answer,
}

impl From<f64> for Phase {
    fn from(number: f64) -> Self {
        if number == 1.0 {
            Self::Burst
        } else if number == 2.0 {
            Self::Answer
        } else {
            Self::Plain
        }
    }
}

impl From<Phase> for f64 {
    fn from(phase: Phase) -> Self {
        match phase {
            Phase::Plain => 0.0,
            Phase::Burst => 1.0,
            Phase::Answer => 2.0,
        }
    }
}

/// Cuts what is far from where whitened residuals have been lately: all of them by one share, so
/// that their direction stays what it is. What lasts longer than any burst in healthy records is no
/// burst: once residuals have answered, it is taken as it is.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Limiter {
    /// The furthest that counts.
    limit: f64,
    /// The longest burst, in samples.
    burst: usize,
    /// The samples in which residuals answer to a jump.
    answer: usize,
    /// Where each residual has been.
    levels: Box<[f64]>,
    /// Samples in a row beyond the limit.
    beyond: usize,
}

impl Limiter {
    pub(super) fn new(size: usize, limit: f64, burst: usize, answer: usize) -> Self {
        Self {
            limit,
            burst,
            answer,
            levels: vec![0.0; size].into(),
            beyond: 0,
        }
    }

    /// Samples in a row after which a jump is taken as it is.
    fn longest(&self) -> usize {
        self.burst.max(self.answer)
    }

    /// What counts of a sample, beside where residuals have been before it.
    pub(super) fn step(&mut self, white: &[f64], cut: &mut [f64], levels: &mut [f64]) -> Phase {
        levels.copy_from_slice(&self.levels);
        let moves = white.iter().zip(self.levels.iter());
        let furthest = moves.fold(0.0, |most: f64, (from, level)| {
            most.max((from - level).abs())
        });
        if furthest <= self.limit {
            self.beyond = 0;
            self.follow(white, cut, 1.0);
            return Phase::Plain;
        }
        self.beyond = self.beyond.saturating_add(1);
        if self.beyond > self.longest() {
            self.beyond = 0;
            cut.copy_from_slice(white);
            self.levels.copy_from_slice(white);
            return Phase::Plain;
        }
        if self.beyond > self.burst {
            cut.copy_from_slice(&self.levels);
            return Phase::Answer;
        }
        self.follow(white, cut, self.limit / furthest);
        Phase::Burst
    }

    /// Goes this share of the way to where residuals are.
    fn follow(&mut self, white: &[f64], cut: &mut [f64], share: f64) {
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

    /// Whether residuals may still answer to a jump.
    pub(super) fn is_answering(&self) -> bool {
        (1..=self.answer).contains(&self.beyond)
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
        let longest = self.longest();
        recall::count(&mut self.beyond, longest, visit);
    }
}

#[cfg(test)]
mod tests {
    use alloc::vec::Vec;

    use super::*;

    fn run(burst: usize, answer: usize, samples: &[[f64; 2]]) -> Vec<(Phase, [f64; 2])> {
        let mut limiter = Limiter::new(2, 4.0, burst, answer);
        let step = |white: &[f64; 2]| {
            let (mut cut, mut levels) = ([0.0; 2], [0.0; 2]);
            let phase = limiter.step(white, &mut cut, &mut levels);
            (phase, cut)
        };
        samples.iter().map(step).collect()
    }

    #[test]
    fn a_burst_is_cut_and_keeps_its_direction() {
        let cut = run(
            3,
            0,
            &[[1.0, 2.0], [60.0, -30.0], [60.0, -30.0], [0.5, 0.0]],
        );
        let expected = [[1.0, 2.0], [4.0, -2.0], [4.0, -2.0], [0.5, 0.0]];
        let phases = [Phase::Plain, Phase::Burst, Phase::Burst, Phase::Plain];
        for ((found, expected), phase) in cut.into_iter().zip(expected).zip(phases) {
            assert_eq!(found.0, phase);
            // The level has moved by some hundredths.
            let far = |i: usize| (found.1[i] - expected[i]).abs();
            assert!(far(0) < 0.1 && far(1) < 0.1, "{found:?} {expected:?}");
        }
    }

    #[test]
    fn what_lasts_longer_than_a_burst_is_taken_as_it_is_once_residuals_have_answered() {
        let mut there_and_back = [[60.0, -30.0]; 20];
        there_and_back[10..].fill([0.0, 0.0]);
        let cut = run(3, 6, &there_and_back);
        let phase = |sample: usize| cut[sample].0;
        assert!((0..3).all(|k| phase(k) == Phase::Burst && cut[k].1[0] < 5.0));
        // As if nothing had happened yet.
        assert!((3..6).all(|k| phase(k) == Phase::Answer && cut[k].1[0] < 0.5));
        assert!((6..10).all(|k| cut[k] == (Phase::Plain, [60.0, -30.0])));
        // Back to nothing is as far.
        assert!((10..13).all(|k| phase(k) == Phase::Burst));
        assert!((13..16).all(|k| phase(k) == Phase::Answer && cut[k].1[0] > 50.0));
        assert!((16..20).all(|k| cut[k] == (Phase::Plain, [0.0, 0.0])));
    }

    #[test]
    fn bursts_may_last_longer_than_answers() {
        let cut = run(6, 3, &[[60.0, -30.0]; 8]);
        assert!(cut[..6].iter().all(|own| own.0 == Phase::Burst));
        assert!(
            cut[6..]
                .iter()
                .all(|own| *own == (Phase::Plain, [60.0, -30.0]))
        );
    }
}
