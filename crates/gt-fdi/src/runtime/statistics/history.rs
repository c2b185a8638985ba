//! Sums over every window that ends now.

use alloc::boxed::Box;
use alloc::vec;

/// The last samples and their running sums.
///
/// With `P_i = r_1 + ... + r_i` and `Q_i = 1 r_1 + ... + i r_i`, the sums over any window are
/// differences. They are counted from the first sample kept, not from the beginning of time: when
/// the room for twice the longest window is used up, its newer half moves to the front and the sums
/// are made anew from the samples. So the sums stay small and forget what has left the window, at
/// the cost of one step in `longest` that takes `longest` additions.
///
/// The sums follow from the samples bit for bit, so that only these are saved.
#[derive(Debug, Clone)]
pub(super) struct History {
    longest: usize,
    filled: usize,
    /// `r_1, r_2, ...`; what stands from `filled` on is of no account.
    samples: Box<[f64]>,
    /// `(P_0, Q_0) = (0, 0), (P_1, Q_1), ...`
    sums: Box<[(f64, f64)]>,
}

/// What is kept, not what stands beyond it.
impl PartialEq for History {
    fn eq(&self, other: &Self) -> bool {
        self.longest == other.longest && self.samples() == other.samples()
    }
}

impl History {
    /// No samples yet, with room for windows of up to `longest` samples.
    pub(super) fn new(longest: usize) -> Self {
        let room = 2 * longest;
        Self {
            longest,
            filled: 0,
            samples: vec![0.0; room].into(),
            sums: vec![(0.0, 0.0); room + 1].into(),
        }
    }

    /// The samples that are kept, the oldest first.
    pub(super) fn samples(&self) -> &[f64] {
        self.samples.get(..self.filled).unwrap_or(&[])
    }

    /// The longest window.
    pub(super) fn longest(&self) -> usize {
        self.longest
    }

    pub(super) fn push(&mut self, r: f64) {
        if self.filled >= self.samples.len() {
            self.samples.copy_within(self.longest.., 0);
            self.filled = self.longest;
            for index in 0..self.longest {
                self.sum_up(index);
            }
        }
        if let Some(place) = self.samples.get_mut(self.filled) {
            *place = r;
            self.sum_up(self.filled);
            self.filled += 1;
        }
    }

    /// Sets the sums behind the sample at `index` from those before it.
    fn sum_up(&mut self, index: usize) {
        let (Some(&r), Some(&(p, q))) = (self.samples.get(index), self.sums.get(index)) else {
            return;
        };
        if let Some(sums) = self.sums.get_mut(index + 1) {
            *sums = (p + r, q + (index + 1) as f64 * r);
        }
    }

    /// `(P, Q)` after the newest sample.
    #[inline(always)]
    pub(super) fn newest(&self) -> (f64, f64) {
        self.sums.get(self.filled).copied().unwrap_or_default()
    }

    /// How many samples stand before a window of the last ones, and `(P, Q)` there: `sum r` over the
    /// window is the difference `P' - P`, and `sum j r`, where `j = 1` is its oldest,
    /// `(Q' - Q) - before (P' - P)`. A window longer than what is kept has no samples.
    #[inline(always)]
    pub(super) fn before(&self, window: usize) -> (usize, (f64, f64)) {
        let before = self.filled.checked_sub(window).unwrap_or(self.filled);
        (before, self.sums.get(before).copied().unwrap_or_default())
    }

    pub(super) fn reset(&mut self) {
        self.filled = 0;
    }
}
