//! Average run length of the run sum.

use super::markov::absorption_time;
use super::normal::tail;
use super::root::increasing_root;
use super::{check, check_finite, check_run_length};
use crate::FdiError;
use crate::runtime::{RunSum, Sides};

/// The largest threshold that is computed: the equations grow with it.
pub const MAX_RUN_SUM_THRESHOLD: u32 = 250;
/// The bracket of a width: from no zones to where a residual beyond the first has a probability of
/// 1e-300.
const WIDTHS: (f64, f64) = (1e-6, 37.0);

/// The average run length of a [`RunSum`] that starts at 0, on residuals that are independent and
/// normal with standard deviation 1.
///
/// The sums up to the threshold on either side are the states of a Markov chain, whose mean time to
/// absorption is solved for exactly (Champ and Rigdon, *Journal of Quality Technology* 29, 1997).
///
/// ```
/// use gt_fdi::{RunSum, RunSumRunLength, Sides, Statistic};
///
/// let scores = RunSum::ZONE_SCORES;
/// // The zone control chart raises a false alarm every 95 samples.
/// let chart = RunSumRunLength::new(1.0, scores, 7, Sides::Both)?;
/// assert_eq!(chart.samples(0.0)?.round(), 95.0);
/// // Every 2000 with zones that are wider by two fifths.
/// let width = RunSumRunLength::width_for(scores, 7, Sides::Both, 2000.0)?;
/// assert!(1.42 < width && width < 1.44);
/// let mut sum = RunSum::new(width, scores, 7.0, Sides::Both)?;
/// assert!(!sum.step(1.0).alarm);
/// # Ok::<(), gt_fdi::FdiError>(())
/// ```
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct RunSumRunLength {
    width: f64,
    scores: [u32; 4],
    threshold: u32,
    sides: Sides,
}

impl RunSumRunLength {
    /// For the run sum with zones of this `width`, in standard deviations, these `scores` and
    /// `sides`, and an alarm above the `threshold`, 1 to [`MAX_RUN_SUM_THRESHOLD`].
    ///
    /// # Errors
    /// [`FdiError::Statistic`] for zones that [`RunSum::new`] refuses, [`FdiError::Option`] for a
    /// threshold out of range.
    pub fn new(
        width: f64,
        scores: [u32; 4],
        threshold: u32,
        sides: Sides,
    ) -> Result<Self, FdiError> {
        let fits = (1..=MAX_RUN_SUM_THRESHOLD).contains(&threshold);
        let found = f64::from(threshold);
        check("threshold", "a whole number from 1 to 250", found, fits)?;
        RunSum::new(width, scores, found, sides)?;
        Ok(Self {
            width,
            scores,
            threshold,
            sides,
        })
    }

    /// Average run length in samples when the residual's mean is `shift` standard deviations.
    ///
    /// # Errors
    /// [`FdiError::Option`] for a shift that is not finite, [`FdiError::RunLength`] when the
    /// result is above [`MAX_RUN_LENGTH`](super::MAX_RUN_LENGTH).
    pub fn samples(&self, shift: f64) -> Result<f64, FdiError> {
        check_finite("shift", shift)?;
        let found = self.unchecked(shift);
        check_run_length(found, 1.0)?;
        Ok(found)
    }

    /// The width of the zones, in standard deviations, at which the average run length without a
    /// shift is `run_length` samples.
    ///
    /// # Errors
    /// As [`RunSumRunLength::new`]; [`FdiError::RunLength`] when `run_length` is not reached by any
    /// width: with an inner score above 0, however wide the zones are, a run alarms at last.
    pub fn width_for(
        scores: [u32; 4],
        threshold: u32,
        sides: Sides,
        run_length: f64,
    ) -> Result<f64, FdiError> {
        let (narrowest, widest) = WIDTHS;
        let shortest = Self::new(narrowest, scores, threshold, sides)?;
        let longest = Self {
            width: widest,
            ..shortest
        };
        check_run_length(run_length, shortest.unchecked(0.0))?;
        let high = longest.unchecked(0.0);
        if run_length > high {
            let low = shortest.unchecked(0.0);
            let found = run_length;
            return Err(FdiError::RunLength { low, high, found });
        }
        increasing_root(WIDTHS, |width| {
            let chart = Self { width, ..shortest };
            Ok((chart.unchecked(0.0) / run_length).ln())
        })
    }

    /// As [`RunSumRunLength::samples`], however long; infinite beyond the range of doubles.
    fn unchecked(&self, shift: f64) -> f64 {
        // Rises and falls, and the sides with which they do not count.
        let sides = [
            (Sides::Lower, self.zones(-shift)),
            (Sides::Upper, self.zones(shift)),
        ];
        let sums = self.threshold as usize;
        // State 0 is no run, or one with the sum 0; then the sums of rises; then those of falls.
        let states = 2 * sums + 1;
        let place = |side: usize, sum: usize| if sum == 0 { 0 } else { side * sums + sum };
        let mut moves = vec![vec![0.0; states]; states];
        let mut exits = vec![0.0; states];
        for (from, (moves, exit)) in moves.iter_mut().zip(&mut exits).enumerate() {
            for (side, (idle, zones)) in sides.iter().enumerate() {
                // The sum before, as far as it is on this side.
                let before = from.checked_sub(side * sums).filter(|&sum| sum <= sums);
                for (score, chance) in zones {
                    let sum = before.unwrap_or(0) + *score as usize;
                    if self.sides == *idle {
                        add(moves, 0, *chance);
                    } else if sum > sums {
                        *exit += chance;
                    } else {
                        add(moves, place(side, sum), *chance);
                    }
                }
            }
        }
        absorption_time(moves, exits)
    }

    /// The scores above zero and the probabilities of their zones, for a residual with the mean
    /// `-shift`.
    fn zones(&self, shift: f64) -> [(u32, f64); 4] {
        let limit = |zone: usize| zone as f64 * self.width + shift;
        let mut zone = 0;
        self.scores.map(|score| {
            let (inner, outer) = (limit(zone), limit(zone + 1));
            zone += 1;
            let chance = if zone == self.scores.len() {
                tail(inner)
            } else if inner < 0.0 {
                // A difference of the two tails on the farther side.
                tail(-outer) - tail(-inner)
            } else {
                tail(inner) - tail(outer)
            };
            (score, chance)
        })
    }
}

/// Adds `chance` to the one at `place`.
fn add(moves: &mut [f64], place: usize, chance: f64) {
    if let Some(found) = moves.get_mut(place) {
        *found += chance;
    }
}
