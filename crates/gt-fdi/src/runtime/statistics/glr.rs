//! Generalised likelihood ratios for steps and ramps of unknown onset and size.

use alloc::boxed::Box;
use alloc::vec::Vec;

use serde::{Deserialize, Serialize};

use super::history::History;
use super::statistic::{LARGEST_SAMPLE, Statistic};
use super::{Sides, StatisticError, Waveform, check_state, check_threshold, check_window};

/// The logarithm of the likelihood ratio of a fault against none, at the likeliest onset and size.
///
/// With the mean `size x w_j` at the `j`-th faulty sample (`w_j = 1` for a step, `j` for a ramp),
/// `A = sum w_j r_j` and `E = sum w_j^2` over the last `m` samples, the likeliest size within the
/// declared range is `s = clip(A / E)`, and the value is the largest `s A - s^2 E / 2` over the
/// windows `m`, or 0 when all are negative (Willsky and Jones, *IEEE Transactions on Automatic
/// Control* 21, 1976; Basseville and Nikiforov, *Detection of Abrupt Changes*, 1993, section 2.4.3).
/// A range of sizes that is no wider than the faults to be found makes detection faster.
///
/// Windows of all lengths would cost much and gain little: their lengths grow by the square root of
/// two, and an onset is found to that resolution.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(try_from = "Saved", into = "Saved")]
pub struct Glr {
    waveform: Waveform,
    smallest: f64,
    largest: f64,
    threshold: f64,
    sides: Sides,
    /// Ascending.
    windows: Box<[Window]>,
    history: History,
    value: f64,
    change: Option<Change>,
}

/// The last samples, as many as `length`.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Window {
    length: usize,
    /// `E`.
    energy: f64,
    /// `1 / E`.
    inverse: f64,
}

/// The likeliest fault.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Change {
    /// Samples since the onset, the newest included.
    pub age: usize,
    /// The fault's size with its sign: standard deviations (a step), or standard deviations a
    /// sample (a ramp).
    pub size: f64,
}

/// What of a [`Glr`] is saved: all else follows from it.
#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct Saved {
    waveform: Waveform,
    smallest: f64,
    largest: f64,
    longest: usize,
    threshold: f64,
    sides: Sides,
    samples: Vec<f64>,
}

impl From<Glr> for Saved {
    fn from(glr: Glr) -> Self {
        Self {
            waveform: glr.waveform,
            smallest: glr.smallest,
            largest: glr.largest,
            longest: glr.history.longest(),
            threshold: glr.threshold,
            sides: glr.sides,
            samples: glr.history.samples().to_vec(),
        }
    }
}

impl TryFrom<Saved> for Glr {
    type Error = StatisticError;

    fn try_from(saved: Saved) -> Result<Self, StatisticError> {
        let sizes = (saved.smallest, saved.largest);
        let mut glr = Self::new(
            saved.waveform,
            sizes,
            saved.longest,
            saved.threshold,
            saved.sides,
        )?;
        if saved.samples.len() > 2 * saved.longest {
            return Err(StatisticError::Length {
                what: "samples",
                expected: 2 * saved.longest,
                found: saved.samples.len(),
            });
        }
        for &r in &saved.samples {
            check_state("sample", r, -LARGEST_SAMPLE, LARGEST_SAMPLE)?;
            glr.history.push(r);
        }
        glr.judge();
        Ok(glr)
    }
}

impl Glr {
    /// The longest window where nobody asks for another: onsets up to 4096 samples ago.
    pub const DEFAULT_LONGEST: usize = 4096;

    /// A ratio without samples, for faults of this `waveform` with the sizes `smallest..=largest`
    /// (above 0; standard deviations for a step, standard deviations a sample for a ramp) whose
    /// onset is up to `longest` samples ago, 1 to [`MAX_WINDOW`](super::MAX_WINDOW). The
    /// `threshold` (above 0) is on the logarithm of the likelihood ratio, which has no unit.
    ///
    /// # Errors
    /// [`StatisticError::Sizes`], [`StatisticError::Window`] or [`StatisticError::Threshold`].
    pub fn new(
        waveform: Waveform,
        (smallest, largest): (f64, f64),
        longest: usize,
        threshold: f64,
        sides: Sides,
    ) -> Result<Self, StatisticError> {
        if !(smallest > 0.0 && smallest <= largest && largest.is_finite()) {
            return Err(StatisticError::Sizes { smallest, largest });
        }
        check_window(longest)?;
        check_threshold(threshold)?;
        let windows = lengths(longest)
            .map(|length| {
                let energy = waveform.energy(length as f64);
                Window {
                    length,
                    energy,
                    inverse: energy.recip(),
                }
            })
            .collect();
        Ok(Self {
            waveform,
            smallest,
            largest,
            threshold,
            sides,
            windows,
            history: History::new(longest),
            value: 0.0,
            change: None,
        })
    }

    /// The lengths of the windows in samples, ascending: 1, 2, 3, 4, 6, 8, 11, 16, ..., each about
    /// the square root of two times the one before, and the longest.
    pub fn windows(&self) -> impl Iterator<Item = usize> + '_ {
        self.windows.iter().map(|window| window.length)
    }

    /// The likeliest fault; `None` while no fault is likelier than none.
    pub fn change(&self) -> Option<Change> {
        self.change
    }

    /// The deviation of the mean at the newest sample that a fault stands for, in standard
    /// deviations.
    pub fn deviation(&self, change: Change) -> f64 {
        match self.waveform {
            Waveform::Step => change.size,
            Waveform::Ramp => change.size * change.age as f64,
        }
    }

    fn judge(&mut self) {
        let (mut value, mut likeliest) = (0.0, None);
        for window in &self.windows {
            let Some((sum, moment)) = self.history.window(window.length) else {
                break;
            };
            let signed = match self.waveform {
                Waveform::Step => sum,
                Waveform::Ramp => moment,
            };
            let agreement = self.sides.fold(signed);
            let size = (agreement * window.inverse)
                .max(self.smallest)
                .min(self.largest);
            let ratio = size * (agreement - 0.5 * size * window.energy);
            if ratio > value {
                value = ratio;
                likeliest = Some((window.length, signed, size));
            }
        }
        self.value = value;
        self.change = likeliest.map(|(age, signed, size)| Change {
            age,
            size: if signed < 0.0 { -size } else { size },
        });
    }
}

impl Statistic for Glr {
    fn take(&mut self, r: f64) {
        self.history.push(r);
        self.judge();
    }

    fn reset(&mut self) {
        self.history.reset();
        self.judge();
    }

    fn value(&self) -> f64 {
        self.value
    }

    fn threshold(&self) -> f64 {
        self.threshold
    }
}

/// Powers of the square root of two, rounded, each once, below `longest`, and `longest`.
fn lengths(longest: usize) -> impl Iterator<Item = usize> {
    #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)] // up to 2^31.5
    let between = |power: usize| (core::f64::consts::SQRT_2 * power as f64 + 0.5) as usize;
    (0..usize::BITS / 2)
        .flat_map(move |exponent| {
            let power = 1_usize << exponent;
            // The root of two rounds to 1, which is there.
            let next = (exponent > 0).then(|| between(power));
            core::iter::once(power).chain(next)
        })
        .take_while(move |&length| length < longest)
        .chain(core::iter::once(longest))
}
