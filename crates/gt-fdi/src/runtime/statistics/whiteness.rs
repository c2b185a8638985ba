//! The correlation of a residual with its own past.

use alloc::boxed::Box;
use alloc::vec;
use alloc::vec::Vec;

use serde::{Deserialize, Serialize};

use super::statistic::Statistic;
use super::{MAX_WINDOW, StatisticError, check_state, check_threshold};

/// The most lags that are looked at.
pub const MAX_LAGS: usize = 1024;

/// Residuals count in multiples of `1 / UNITS` standard deviations, so that sums are exact.
const UNITS: f64 = 4_294_967_296.0;
/// Residuals beyond this many standard deviations count as that. The product of two has less than
/// 2^104 units, the sum of 2^16 products less than 2^120.
const FARTHEST: f64 = 1_048_576.0;

/// The portmanteau statistic of the last `n` residuals over the lags 1 to `m`:
/// `Q = n (n + 2) sum_k p_k^2 / (n - k)`, `p_k = c_k / c_0`, `c_k = sum r_i r_(i - k)` over the pairs
/// within the window (Ljung and Box, *Biometrika* 65, 1978). A model that no longer fits leaves
/// residuals that know of each other.
///
/// The mean is not taken off, because a healthy residual has the mean 0: a shift shows at all lags
/// alike. The variance drops out. While the residual is healthy and white, `Q` is nearly chi-square
/// with `m` degrees of freedom for `n` large against `m`; a residual that is the one-step error of a
/// model fitted to the very same window would have fewer. It is 0 until the window is full, and
/// while all residuals in it are 0.
///
/// A step takes a time in proportion to `m`, whatever `n`: the pairs that the new residual makes are
/// added, those that the oldest made are taken off. Residuals are rounded to multiples of 2^-32
/// standard deviations and count up to 2^20 standard deviations, so that the sums are whole numbers:
/// what has left the window leaves nothing behind, for ever.
///
/// Neighbouring windows overlap, so the time between false alarms is not that of independent
/// draws; [`SimulatedRuns`](crate::design::SimulatedRuns) measures it.
#[derive(Debug, Clone, Serialize, Deserialize)]
#[serde(try_from = "Saved", into = "Saved")]
pub struct Whiteness {
    threshold: f64,
    /// The last residuals in units, in a ring; what stands from `filled` on is of no account.
    ring: Box<[i64]>,
    filled: usize,
    /// Where the next one goes: the place of the oldest once the ring is full.
    next: usize,
    /// `c_0, ..., c_m` in squares of units.
    sums: Box<[i128]>,
    value: f64,
}

/// What is kept, wherever it stands in the ring.
impl PartialEq for Whiteness {
    fn eq(&self, other: &Self) -> bool {
        self.threshold.to_bits() == other.threshold.to_bits()
            && self.ring.len() == other.ring.len()
            && self.sums.len() == other.sums.len()
            && self.oldest_first().eq(other.oldest_first())
    }
}

/// What of a [`Whiteness`] is saved: all else follows from it.
#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct Saved {
    window: usize,
    lags: usize,
    threshold: f64,
    samples: Vec<f64>,
}

impl From<Whiteness> for Saved {
    fn from(whiteness: Whiteness) -> Self {
        Self {
            window: whiteness.window(),
            lags: whiteness.lags(),
            threshold: whiteness.threshold,
            samples: whiteness.oldest_first().map(from_units).collect(),
        }
    }
}

impl TryFrom<Saved> for Whiteness {
    type Error = StatisticError;

    fn try_from(saved: Saved) -> Result<Self, StatisticError> {
        let mut whiteness = Self::new(saved.window, saved.lags, saved.threshold)?;
        if saved.samples.len() > saved.window {
            return Err(StatisticError::Length {
                what: "samples",
                expected: saved.window,
                found: saved.samples.len(),
            });
        }
        for &r in &saved.samples {
            check_state("sample", r, -FARTHEST, FARTHEST)?;
            whiteness.push(to_units(r));
        }
        whiteness.judge();
        Ok(whiteness)
    }
}

impl Whiteness {
    /// A window without samples for `window` of them, 2 to [`MAX_WINDOW`], over the lags 1 to
    /// `lags`, which is below the window and at most [`MAX_LAGS`], with the `threshold` (above 0) on
    /// `Q`, which has no unit.
    ///
    /// # Errors
    /// [`StatisticError::WindowRange`], [`StatisticError::Lags`] or [`StatisticError::Threshold`].
    pub fn new(window: usize, lags: usize, threshold: f64) -> Result<Self, StatisticError> {
        if !(2..=MAX_WINDOW).contains(&window) {
            return Err(StatisticError::WindowRange {
                shortest: 2,
                longest: MAX_WINDOW,
                found: window,
            });
        }
        let most = MAX_LAGS.min(window - 1);
        if !(1..=most).contains(&lags) {
            return Err(StatisticError::Lags { most, found: lags });
        }
        check_threshold(threshold)?;
        Ok(Self {
            threshold,
            ring: vec![0; window].into(),
            filled: 0,
            next: 0,
            sums: vec![0; lags + 1].into(),
            value: 0.0,
        })
    }

    /// Samples in the window.
    pub fn window(&self) -> usize {
        self.ring.len()
    }

    /// The largest lag.
    pub fn lags(&self) -> usize {
        self.sums.len() - 1
    }

    /// The autocorrelations `p_1, ..., p_m` of the samples in the window; 0 while all are 0.
    pub fn correlations(&self) -> impl Iterator<Item = f64> + '_ {
        let energy = self.sums.first().copied().unwrap_or(0);
        // Whole numbers below 2^120: rounded once.
        let scale = if energy > 0 { energy as f64 } else { 1.0 };
        self.sums.iter().skip(1).map(move |&sum| sum as f64 / scale)
    }

    fn oldest_first(&self) -> impl DoubleEndedIterator<Item = i64> + '_ {
        let kept = self.ring.get(..self.filled).unwrap_or(&[]);
        // Until the ring is full, the oldest stands at its beginning.
        let turn = if self.filled < self.ring.len() {
            0
        } else {
            self.next
        };
        let (new, old) = kept.split_at_checked(turn).unwrap_or((&[], kept));
        old.iter().chain(new).copied()
    }

    /// Moves the window on by the residual `r`, in units.
    fn push(&mut self, r: i64) {
        let mut sums = core::mem::take(&mut self.sums);
        let full = self.filled == self.ring.len();
        if full {
            let mut later = self.oldest_first();
            if let Some(oldest) = later.next() {
                for (sum, later) in sums.iter_mut().zip(core::iter::once(oldest).chain(later)) {
                    *sum -= i128::from(oldest) * i128::from(later);
                }
            }
        }
        // As many as are left without the oldest, which the newest replaces.
        let left = self.filled - usize::from(full);
        let earlier = self.oldest_first().rev().take(left);
        for (sum, earlier) in sums.iter_mut().zip(core::iter::once(r).chain(earlier)) {
            *sum += i128::from(r) * i128::from(earlier);
        }
        self.sums = sums;
        if let Some(place) = self.ring.get_mut(self.next) {
            *place = r;
        }
        self.filled = left + 1;
        self.next = (self.next + 1) % self.ring.len();
    }

    fn judge(&mut self) {
        self.value = 0.0;
        if self.filled < self.ring.len() {
            return;
        }
        let n = self.ring.len() as f64;
        let mut sum = 0.0;
        for (lag, correlation) in (1_u32..).zip(self.correlations()) {
            sum += correlation * correlation / (n - f64::from(lag));
        }
        self.value = n * (n + 2.0) * sum;
    }
}

impl Statistic for Whiteness {
    fn take(&mut self, r: f64) {
        self.push(to_units(r.clamp(-FARTHEST, FARTHEST)));
        self.judge();
    }

    fn reset(&mut self) {
        self.filled = 0;
        self.next = 0;
        self.sums.fill(0);
        self.value = 0.0;
    }

    fn value(&self) -> f64 {
        self.value
    }

    fn threshold(&self) -> f64 {
        self.threshold
    }
}

/// The nearest whole number of units.
fn to_units(r: f64) -> i64 {
    #[allow(clippy::cast_possible_truncation)] // up to 2^52
    let units = libm::round(r * UNITS) as i64;
    units
}

/// A number of units below 2^53 in standard deviations, exactly.
fn from_units(units: i64) -> f64 {
    units as f64 / UNITS
}
