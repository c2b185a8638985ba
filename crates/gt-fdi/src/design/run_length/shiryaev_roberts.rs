//! Average run length of the Shiryaev-Roberts procedure.

use super::markov::absorption_time;
use super::normal::{density, tail};
use super::quadrature::gauss_legendre;
use super::root::increasing_root;
use super::{check, check_finite, check_run_length};
use crate::FdiError;

/// The shifts that are computed, in standard deviations: the equations grow as they get smaller.
pub const SHIRYAEV_ROBERTS_SHIFTS: (f64, f64) = (0.1, 5.0);
/// The largest threshold that is computed: `R` is then above [`MAX_RUN_LENGTH`](super::MAX_RUN_LENGTH).
pub const MAX_SHIRYAEV_ROBERTS_THRESHOLD: f64 = 30.0;

/// Where the search for a threshold begins: there, half of the first samples alarm or more.
const LOWEST_THRESHOLD: f64 = 1e-9;
/// Standard deviations of a step of `ln R` below which none is looked at: its probability is 1e-19.
const FARTHEST_FALL: f64 = 9.0;
/// Quadrature nodes at least, and per standard deviation of a step of `ln R` or, where that is
/// finer, per unit: the width of `ln(1 + R)` as a function of `ln R`.
const NODES: (f64, f64) = (32.0, 3.0);

/// The average run length of a one-sided [`ShiryaevRoberts`](crate::runtime::ShiryaevRoberts)
/// procedure that starts at `R = 0`, on residuals that are independent and normal with standard
/// deviation 1.
///
/// For a step of size `d`, `ln R` moves by `ln R' = ln(1 + R) + d r - d^2 / 2`. The equation for the
/// mean time from every `ln R` is solved at Gauss-Legendre nodes, as that of the
/// [`CUSUM`](super::CusumRunLength) is; the nodes and `R = 0` are the states of a Markov chain.
///
/// A procedure with both sides has nearly the same time between false alarms at the same threshold:
/// its `R` is the mean of two, and mostly one of them makes it alarm.
///
/// One false alarm in 24 hours at 0.08 s a sample, for a step of one standard deviation; a threshold
/// that is safe without any computation is a little higher:
///
/// ```
/// use gt_fdi::{ShiryaevRoberts, ShiryaevRobertsRunLength};
///
/// let samples = 24.0 * 3600.0 / 0.08;
/// let threshold = ShiryaevRobertsRunLength::threshold_for(1.0, samples)?;
/// let safe = ShiryaevRoberts::safe_threshold(samples)?;
/// assert!(safe - 0.59 < threshold && threshold < safe - 0.57);
/// # Ok::<(), gt_fdi::FdiError>(())
/// ```
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ShiryaevRobertsRunLength {
    shift: f64,
    threshold: f64,
}

impl ShiryaevRobertsRunLength {
    /// For the procedure for a step of `shift` standard deviations, within
    /// [`SHIRYAEV_ROBERTS_SHIFTS`], with the `threshold` on `ln(1 + R)`, above 0 and up to
    /// [`MAX_SHIRYAEV_ROBERTS_THRESHOLD`].
    ///
    /// # Errors
    /// [`FdiError::Option`] for a shift or a threshold out of range.
    pub fn new(shift: f64, threshold: f64) -> Result<Self, FdiError> {
        let (smallest, largest) = SHIRYAEV_ROBERTS_SHIFTS;
        let fits = (smallest..=largest).contains(&shift);
        check("shift", "a number from 0.1 to 5", shift, fits)?;
        let fits = threshold > 0.0 && threshold <= MAX_SHIRYAEV_ROBERTS_THRESHOLD;
        check("threshold", "a number above 0 up to 30", threshold, fits)?;
        Ok(Self { shift, threshold })
    }

    /// Average run length in samples when the residual's mean is `mean` standard deviations, the
    /// side of the step being positive.
    ///
    /// # Errors
    /// [`FdiError::Option`] for a mean that is not finite, [`FdiError::RunLength`] when the result
    /// is above [`MAX_RUN_LENGTH`](super::MAX_RUN_LENGTH).
    pub fn samples(&self, mean: f64) -> Result<f64, FdiError> {
        check_finite("mean", mean)?;
        let found = self.unchecked(mean);
        check_run_length(found, 1.0)?;
        Ok(found)
    }

    /// The threshold on `ln(1 + R)` at which the average run length without a fault is `run_length`
    /// samples.
    ///
    /// # Errors
    /// [`FdiError::Option`] for a bad shift; [`FdiError::RunLength`] when `run_length` is below that
    /// of threshold 0 or above [`MAX_RUN_LENGTH`](super::MAX_RUN_LENGTH).
    pub fn threshold_for(shift: f64, run_length: f64) -> Result<f64, FdiError> {
        let lowest = Self::new(shift, LOWEST_THRESHOLD)?;
        check_run_length(run_length, lowest.unchecked(0.0))?;
        // The mean run length is that of R at the alarm, so that this is high enough.
        let highest = run_length.ln_1p();
        increasing_root((LOWEST_THRESHOLD, highest), |threshold| {
            let procedure = Self { shift, threshold };
            Ok((procedure.unchecked(0.0) / run_length).ln())
        })
    }

    /// As [`ShiryaevRobertsRunLength::samples`], however long.
    fn unchecked(&self, mean: f64) -> f64 {
        let Self { shift, threshold } = *self;
        let drift = shift * (mean - 0.5 * shift);
        // ln R at the alarm, and where it practically never falls below.
        let high = threshold.exp_m1().ln();
        let low = high.min(0.0) + drift.min(0.0) - FARTHEST_FALL * shift;
        let width = high - low;
        #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)] // below 3000
        let count = (NODES.0 + NODES.1 * width / shift.min(1.0)).ceil() as usize;
        let nodes: Vec<(f64, f64)> = gauss_legendre(count, width)
            .into_iter()
            .map(|(place, weight)| (low + place, weight))
            .collect();
        // The logarithm of 1 + R in each state, the first of which is R = 0.
        let starts = nodes.iter().map(|&(ratio, _)| ratio.exp().ln_1p());
        let starts: Vec<f64> = std::iter::once(0.0).chain(starts).collect();
        let deviate = |start: f64, ratio: f64| (ratio - start - drift) / shift;
        let rows = starts.iter().map(|&start| {
            let falls = std::iter::once(tail(-deviate(start, low)));
            let moves = nodes
                .iter()
                .map(|&(ratio, weight)| weight / shift * density(deviate(start, ratio)));
            falls.chain(moves).collect()
        });
        let alarms = starts.iter().map(|&start| tail(deviate(start, high)));
        // No less to rounding either.
        absorption_time(rows.collect(), alarms.collect()).max(1.0)
    }
}
