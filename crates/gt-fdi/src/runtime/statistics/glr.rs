//! Generalised likelihood ratios for steps and ramps of unknown onset and size.

use alloc::boxed::Box;
use alloc::vec::Vec;

use serde::{Deserialize, Serialize};

use super::super::wide::{Simd, Wide, Work, lanes_of, registers};
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
    /// Ascending, the last one as often as fills its group.
    windows: Box<[Windows]>,
    history: History,
    wide: Wide,
    value: f64,
    change: Option<Change>,
}

/// Windows that are judged side by side.
const GROUP: usize = 8;

/// Some windows over the last samples.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Windows {
    /// In samples.
    length: [usize; GROUP],
    /// `E`.
    energy: [f64; GROUP],
    /// `1 / E`.
    inverse: [f64; GROUP],
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
        let all: Vec<usize> = lengths(longest).collect();
        let windows = all.chunks(GROUP).map(|group| {
            let length = core::array::from_fn(|lane| group.get(lane).copied().unwrap_or(longest));
            let energy = length.map(|length| waveform.energy(length as f64));
            Windows {
                length,
                energy,
                inverse: energy.map(f64::recip),
            }
        });
        let windows = windows.collect();
        Ok(Self {
            waveform,
            smallest,
            largest,
            threshold,
            sides,
            windows,
            history: History::new(longest),
            wide: Wide::new(),
            value: 0.0,
            change: None,
        })
    }

    /// The lengths of the windows in samples, ascending: 1, 2, 3, 4, 6, 8, 11, 16, ..., each about
    /// the square root of two times the one before, and the longest.
    pub fn windows(&self) -> impl Iterator<Item = usize> + '_ {
        let lengths = self.windows.iter().flat_map(|group| group.length);
        let longest = self.history.longest();
        let below = lengths.take_while(move |&length| length < longest);
        below.chain(core::iter::once(longest))
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
        let wide = self.wide;
        let (value, likeliest) = wide.run(Judge(self));
        self.value = value;
        self.change = likeliest.map(|(age, signed, size)| Change {
            age,
            size: if signed < 0.0 { -size } else { size },
        });
    }
}

/// The largest ratio over all windows, with its window, what was summed over it and the size.
struct Judge<'a>(&'a Glr);

impl Work for Judge<'_> {
    type Output = (f64, Option<(usize, f64, f64)>);

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) -> Self::Output {
        let Self(glr) = self;
        let splat = |value| simd.splat_f64s(value);
        let (smallest, largest, half) = (splat(glr.smallest), splat(glr.largest), splat(0.5));
        let newest = glr.history.newest();
        let (p, q) = (splat(newest.0), splat(newest.1));
        // Of each lane the largest ratio so far, its group, what was summed and the size.
        let mut best = [[splat(0.0); GROUP]; 4];
        for (group, windows) in glr.windows.iter().enumerate() {
            let [mut before, mut p_before, mut q_before] = [[0.0; GROUP]; 3];
            for (lane, &length) in windows.length.iter().enumerate() {
                let (samples, sums) = glr.history.before(length);
                before[lane] = samples as f64;
                (p_before[lane], q_before[lane]) = sums;
            }
            for register in 0..GROUP / S::F64_LANES {
                let of = |values: &[f64; GROUP]| registers::<S>(values)[register];
                let sum = simd.sub_f64s(p, of(&p_before));
                let found = match glr.waveform {
                    Waveform::Step => sum,
                    Waveform::Ramp => {
                        let moment = simd.sub_f64s(q, of(&q_before));
                        simd.sub_f64s(moment, simd.mul_f64s(of(&before), sum))
                    }
                };
                let agreement = match glr.sides {
                    Sides::Upper => found,
                    Sides::Lower => simd.neg_f64s(found),
                    Sides::Both => simd.abs_f64s(found),
                };
                let likely = simd.mul_f64s(agreement, of(&windows.inverse));
                let size = simd.min_f64s(simd.max_f64s(likely, smallest), largest);
                let cost = simd.mul_f64s(simd.mul_f64s(half, size), of(&windows.energy));
                let ratio = simd.mul_f64s(size, simd.sub_f64s(agreement, cost));
                let larger = simd.less_than_f64s(best[0][register], ratio);
                for (best, new) in best
                    .iter_mut()
                    .zip([ratio, splat(group as f64), found, size])
                {
                    best[register] = simd.select_f64s(larger, new, best[register]);
                }
            }
        }
        let lanes = best.map(|registers| {
            let mut lanes = [0.0; GROUP];
            let used = lanes_of::<S>(&registers);
            lanes.copy_from_slice(&used[..GROUP]);
            lanes
        });
        let [ratios, groups, signed, sizes] = &lanes;
        let value = ratios.iter().copied().fold(0.0, f64::max);
        let mut first = None;
        if value > 0.0 {
            for lane in (0..GROUP).filter(|&lane| ratios[lane] >= value) {
                if first.is_none_or(|first: usize| groups[lane] < groups[first]) {
                    first = Some(lane);
                }
            }
        }
        let likeliest = first.and_then(|lane| {
            #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)] // a small index
            let windows = glr.windows.get(groups[lane] as usize)?;
            Some((windows.length[lane], signed[lane], sizes[lane]))
        });
        (value, likeliest)
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
