//! Average run length of the CUSUM.

use super::markov::absorption_time;
use super::normal::{density, tail};
use super::quadrature::gauss_legendre;
use super::root::increasing_root;
use super::{check, check_finite, check_run_length};
use crate::FdiError;
use crate::runtime::Sides;

/// The largest threshold that is computed: the equations grow with it.
pub const MAX_CUSUM_THRESHOLD: f64 = 250.0;

/// Quadrature nodes at threshold 0 and per unit of the threshold. The kernel is a normal density of
/// standard deviation 1; at 3 nodes a unit they are at most `pi / 6` apart, where the error of the
/// quadrature, about `exp(-2 pi^2 36 / pi^2)`, is far below rounding.
const NODES: (f64, f64) = (32.0, 3.0);
/// The bracket of a threshold grows by this factor.
const GROWTH: f64 = 1.5;

/// The average run length of a [`Cusum`](crate::runtime::Cusum) that starts at zero, on residuals
/// that are independent and normal with standard deviation 1.
///
/// From `z`, the one-sided sum runs `L(z) = 1 + L(0) Phi(k - z - mu) + int_0^h L(x) phi(x + k - z -
/// mu) dx` samples in the mean (Page, *Biometrika* 41, 1954), solved at Gauss-Legendre nodes
/// (Nystroem's method); the nodes and zero are the states of a Markov chain. With both sides the rates of alarm add up: `1/L = 1/L(mu) + 1/L(-mu)`,
/// which is exact because the two sums cannot both be above zero near an alarm (Kemp, *Journal of
/// the Royal Statistical Society B* 24, 1962; Lucas and Crosier, *Technometrics* 24, 1982).
///
/// One false alarm in 24 hours at 0.08 s a sample; a step of one standard deviation is then found
/// within 26 samples in the mean:
///
/// ```
/// use gt_fdi::{Cusum, CusumRunLength, Sides, Statistic};
///
/// let samples = 24.0 * 3600.0 / 0.08;
/// let threshold = CusumRunLength::threshold_for(0.5, Sides::Both, samples)?;
/// let delay = CusumRunLength::new(0.5, threshold, Sides::Both)?.samples(1.0)?;
/// assert!(25.0 < delay && delay < 26.0);
///
/// let mut cusum = Cusum::new(0.5, threshold, Sides::Both)?;
/// assert!(!cusum.step(0.3).alarm);
/// # Ok::<(), gt_fdi::FdiError>(())
/// ```
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct CusumRunLength {
    allowance: f64,
    threshold: f64,
    sides: Sides,
}

impl CusumRunLength {
    /// For the CUSUM with this `allowance` (0 or above), `threshold` (0 to
    /// [`MAX_CUSUM_THRESHOLD`]), both in standard deviations, and `sides`.
    ///
    /// # Errors
    /// [`FdiError::Option`] for an allowance or a threshold out of range.
    pub fn new(allowance: f64, threshold: f64, sides: Sides) -> Result<Self, FdiError> {
        check_allowance(allowance)?;
        let fits = (0.0..=MAX_CUSUM_THRESHOLD).contains(&threshold);
        check("threshold", "a number from 0 to 250", threshold, fits)?;
        Ok(Self {
            allowance,
            threshold,
            sides,
        })
    }

    /// Average run length in samples when the residual's mean is `shift` standard deviations, to a
    /// relative error below 1e-11.
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

    /// The threshold at which the average run length without a shift is `run_length` samples.
    ///
    /// # Errors
    /// [`FdiError::Option`] for a bad allowance; [`FdiError::RunLength`] when `run_length` is
    /// below that of threshold 0, above [`MAX_RUN_LENGTH`](super::MAX_RUN_LENGTH), or above that of
    /// [`MAX_CUSUM_THRESHOLD`].
    pub fn threshold_for(allowance: f64, sides: Sides, run_length: f64) -> Result<f64, FdiError> {
        check_allowance(allowance)?;
        let log_ratio = |threshold: f64| {
            let chart = Self {
                allowance,
                threshold,
                sides,
            };
            Ok::<f64, FdiError>((chart.unchecked(0.0) / run_length).ln())
        };
        let shortest = Self::new(allowance, 0.0, sides)?.unchecked(0.0);
        check_run_length(run_length, shortest)?;
        let (mut low, mut high) = (0.0, 1.0);
        while log_ratio(high)? < 0.0 {
            if high >= MAX_CUSUM_THRESHOLD {
                return Err(FdiError::RunLength {
                    low: shortest,
                    high: Self::new(allowance, high, sides)?.unchecked(0.0),
                    found: run_length,
                });
            }
            low = high;
            high = (GROWTH * high).min(MAX_CUSUM_THRESHOLD);
        }
        increasing_root((low, high), log_ratio)
    }

    /// As [`CusumRunLength::samples`], however long; infinite beyond the range of doubles.
    fn unchecked(&self, shift: f64) -> f64 {
        let side = |shift: f64| one_sided(self.allowance, self.threshold, shift);
        let length = match self.sides {
            Sides::Upper => side(shift),
            Sides::Lower => side(-shift),
            Sides::Both => 1.0 / (side(shift).recip() + side(-shift).recip()),
        };
        // No less to rounding either.
        length.max(1.0)
    }
}

fn check_allowance(found: f64) -> Result<(), FdiError> {
    let fits = found.is_finite() && found >= 0.0;
    check("allowance", "a finite number not below 0", found, fits)
}

/// Average run length of `S = max(0, S + r - k)` from 0 to above `threshold`.
fn one_sided(allowance: f64, threshold: f64, shift: f64) -> f64 {
    // The mean step downwards.
    let drift = allowance - shift;
    #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)] // 32 to 782
    let count = (NODES.0 + NODES.1 * threshold).ceil() as usize;
    let mut starts = vec![(0.0, 0.0)];
    starts.extend(gauss_legendre(count, threshold));
    let rows = starts.iter().map(|&(from, _)| {
        let row = starts.iter().enumerate().map(|(column, &(to, weight))| {
            if column == 0 {
                tail(from - drift)
            } else {
                weight * density(to - from + drift)
            }
        });
        row.collect()
    });
    let alarms = starts
        .iter()
        .map(|&(from, _)| tail(threshold - from + drift));
    absorption_time(rows.collect(), alarms.collect())
}
