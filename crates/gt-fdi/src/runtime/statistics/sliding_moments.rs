//! Mean and spread over a sliding window, without a subtraction.

use alloc::boxed::Box;
use alloc::vec;

use super::moments::Moments;

/// The moments of the last `width` samples.
///
/// As in a [`SlidingSum`](super::sliding_sum::SlidingSum), samples fill a block. When it is full,
/// its moments from each sample to the end are stored, and the next block begins: the window is a
/// rest of the one joined with a start of the other. What has left the window leaves no rounding
/// behind, and one step in `width` takes `width` additions.
///
/// All else follows from the samples bit for bit, so that only these are saved.
#[derive(Debug, Clone)]
pub(super) struct SlidingMoments {
    /// The samples of the full block.
    full: Box<[f64]>,
    /// Whether there is one.
    has_full: bool,
    /// `rest[i]`: the moments of the full block's samples from `i` on.
    rest: Box<[Moments]>,
    /// The samples of the block that is being filled; what stands from `filled` on is of no account.
    block: Box<[f64]>,
    /// How many of them there are: below the width.
    filled: usize,
    /// Their moments.
    start: Moments,
}

/// What is kept, not what stands beyond it.
impl PartialEq for SlidingMoments {
    fn eq(&self, other: &Self) -> bool {
        self.width() == other.width() && self.samples().eq(other.samples())
    }
}

impl SlidingMoments {
    /// No samples yet; `width` is above 0.
    pub(super) fn new(width: usize) -> Self {
        Self {
            full: vec![0.0; width].into(),
            has_full: false,
            rest: vec![Moments::default(); width].into(),
            block: vec![0.0; width].into(),
            filled: 0,
            start: Moments::default(),
        }
    }

    pub(super) fn width(&self) -> usize {
        self.block.len()
    }

    /// The samples that are kept, the oldest first: fewer than twice the width. Pushed one by one
    /// they make the window anew.
    pub(super) fn samples(&self) -> impl Iterator<Item = f64> + '_ {
        let full: &[f64] = if self.has_full { &self.full } else { &[] };
        full.iter()
            .chain(self.block.iter().take(self.filled))
            .copied()
    }

    /// Moves the window on by the sample `r`.
    pub(super) fn push(&mut self, r: f64) {
        if let Some(place) = self.block.get_mut(self.filled) {
            *place = r;
        }
        self.filled += 1;
        self.start = self.start.with(r);
        if self.filled < self.width() {
            return;
        }
        core::mem::swap(&mut self.full, &mut self.block);
        self.has_full = true;
        let mut moments = Moments::default();
        for (rest, &r) in self.rest.iter_mut().zip(&self.full).rev() {
            moments = moments.with(r);
            *rest = moments;
        }
        self.filled = 0;
        self.start = Moments::default();
    }

    /// The moments of the window; `None` until there are as many samples.
    pub(super) fn window(&self) -> Option<Moments> {
        let rest = self.rest.get(self.filled).filter(|_| self.has_full)?;
        Some(rest.join(self.start))
    }

    pub(super) fn reset(&mut self) {
        self.has_full = false;
        self.filled = 0;
        self.start = Moments::default();
    }
}
