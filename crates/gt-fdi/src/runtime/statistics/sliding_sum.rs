//! The sum over a sliding window, without a subtraction.

use alloc::boxed::Box;
use alloc::vec;

use serde::{Deserialize, Serialize};

use super::{StatisticError, check_state, check_window};

/// Above the sum of the squares of the largest samples over the longest window.
const LARGEST_VALUE: f64 = 1e205;

/// The sum of the last `width` values; those before the first are zeros.
///
/// Samples fill a block of `width` values. When it is full, its sums from each value to the end are
/// stored, and the next block begins: the window is a rest of the one and a start of the other. A
/// huge value that has left the window leaves no rounding behind, sums of squares never fall below
/// zero, and one step in `width` takes `width` additions.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(try_from = "Unchecked")]
pub(super) struct SlidingSum {
    /// `rest[i]`: the sum of the full block's values from `i` on.
    rest: Box<[f64]>,
    /// The values of the block that is being filled.
    block: Box<[f64]>,
    /// How many of them there are: below the width.
    filled: usize,
    /// Their sum, which the values give back bit for bit.
    #[serde(skip)]
    start: f64,
}

/// The fields of a [`SlidingSum`] as they come from a file.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Unchecked {
    rest: Box<[f64]>,
    block: Box<[f64]>,
    filled: usize,
}

impl TryFrom<Unchecked> for SlidingSum {
    type Error = StatisticError;

    fn try_from(raw: Unchecked) -> Result<Self, StatisticError> {
        let made = Self::new(raw.block.len())?;
        let width = made.width();
        if raw.rest.len() != width {
            return Err(StatisticError::Length {
                what: "rest",
                expected: width,
                found: raw.rest.len(),
            });
        }
        let last = (width - 1) as f64;
        check_state("filled", raw.filled as f64, 0.0, last)?;
        for &value in raw.rest.iter().chain(&raw.block) {
            check_state("value", value, -LARGEST_VALUE, LARGEST_VALUE)?;
        }
        let start = raw.block.iter().take(raw.filled);
        Ok(Self {
            start: start.fold(0.0, |sum, value| sum + value),
            rest: raw.rest,
            block: raw.block,
            filled: raw.filled,
        })
    }
}

impl SlidingSum {
    /// Zero over `width` values.
    pub(super) fn new(width: usize) -> Result<Self, StatisticError> {
        check_window(width)?;
        Ok(Self {
            rest: vec![0.0; width].into(),
            block: vec![0.0; width].into(),
            filled: 0,
            start: 0.0,
        })
    }

    pub(super) fn width(&self) -> usize {
        self.block.len()
    }

    /// Moves the window on by `value`.
    pub(super) fn push(&mut self, value: f64) {
        if let Some(place) = self.block.get_mut(self.filled) {
            *place = value;
        }
        self.filled += 1;
        self.start += value;
        if self.filled < self.width() {
            return;
        }
        let mut sum = 0.0;
        for (rest, value) in self.rest.iter_mut().zip(&self.block).rev() {
            sum += value;
            *rest = sum;
        }
        self.filled = 0;
        self.start = 0.0;
    }

    /// The sum over the window.
    pub(super) fn sum(&self) -> f64 {
        self.rest.get(self.filled).copied().unwrap_or(0.0) + self.start
    }

    /// Refuses a state that sums of squares cannot have.
    pub(super) fn check_not_negative(&self) -> Result<(), StatisticError> {
        for &value in self.rest.iter().chain(&self.block) {
            check_state("square", value, 0.0, LARGEST_VALUE)?;
        }
        Ok(())
    }

    pub(super) fn reset(&mut self) {
        self.rest.fill(0.0);
        self.block.fill(0.0);
        self.filled = 0;
        self.start = 0.0;
    }
}
