//! Which statistic a test computes of its residual.

use serde::{Deserialize, Serialize};

use super::run_length::{CusumRunLength, SHIRYAEV_ROBERTS_SHIFTS, ShiryaevRobertsRunLength};
use super::tail::Tail;
use crate::FdiError;
use crate::runtime::{
    Cusum, Evaluator, Glr, MAX_WINDOW, Modulus, MovingAverage, ShiryaevRoberts, Sides, Statistic,
    Waveform, Whiteness, WindowedChiSquare, WindowedVariance,
};

/// Simulated white samples for limits that have no closed form.
const WHITE_SAMPLES: usize = 2_000_000;
/// At least so many times as long as an alarm lasts: for 40 peaks.
const WHITE_RELEASES: usize = 320;
/// Seed of that simulation.
const WHITE_SEED: u64 = 0x6774_6664_695f_7768;

/// A statistic of a residual, on both sides of zero.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(tag = "kind", rename_all = "snake_case", deny_unknown_fields)]
pub enum StatisticKind {
    /// The modulus of the residual (the paper's eq. 26); of several residuals their norm.
    Modulus,
    /// The cumulative sum of what exceeds an allowance, for lasting deviations of twice the
    /// allowance or more.
    Cusum {
        /// `k`, in standard deviations.
        allowance: f64,
    },
    /// The generalised likelihood ratio of a deviation that begins at an unknown time.
    Glr {
        /// A step or a ramp.
        waveform: Waveform,
        /// The smallest fault looked for: standard deviations, or standard deviations a sample.
        smallest: f64,
        /// The largest fault looked for.
        largest: f64,
        /// The longest window in samples.
        longest: usize,
    },
    /// The mean over a window.
    MovingAverage {
        /// Samples.
        window: usize,
    },
    /// The sum of squares over a window; of several residuals that of their norms.
    ChiSquare {
        /// Samples.
        window: usize,
    },
    /// The Shiryaev-Roberts procedure, for lasting deviations.
    ShiryaevRoberts {
        /// The deviation that it is best for, in standard deviations.
        shift: f64,
    },
    /// The variance over a window, too large or too small: a sensor that has become noisy, or one
    /// that stands still.
    Variance {
        /// Samples.
        window: usize,
    },
    /// The correlations of neighbouring samples over a window: dynamics that the model has not.
    Whiteness {
        /// Samples.
        window: usize,
        /// Correlations that are looked at.
        lags: usize,
    },
}

impl StatisticKind {
    /// Half a standard deviation: for lasting deviations of one.
    pub const DEFAULT_ALLOWANCE: f64 = 0.5;
    /// The slopes of ramps looked for where nobody says more: two decades, in standard deviations
    /// a sample.
    pub const DEFAULT_SLOPES: (f64, f64) = (1e-4, 1e-2);
    /// The steps looked for where nobody says more, in standard deviations.
    pub const DEFAULT_STEPS: (f64, f64) = (0.1, 10.0);

    /// Refuses parameters that are out of range.
    ///
    /// # Errors
    /// [`FdiError::Statistic`].
    pub fn validate(&self) -> Result<(), FdiError> {
        self.evaluator(1.0).map(|_| ())
    }

    /// Whether it is one of the norm of several residuals, which has no sign and no mean of zero.
    pub fn takes_several(&self) -> bool {
        matches!(self, Self::Modulus | Self::ChiSquare { .. })
    }

    /// The statistic that runs online, with a threshold.
    pub(crate) fn evaluator(&self, threshold: f64) -> Result<Evaluator, FdiError> {
        let sides = Sides::Both;
        Ok(match *self {
            Self::Modulus => Evaluator::Modulus(Modulus::new(threshold)),
            Self::Cusum { allowance } => Evaluator::Cusum(Cusum::new(allowance, threshold, sides)?),
            Self::Glr {
                waveform,
                smallest,
                largest,
                longest,
            } => Evaluator::Glr(Glr::new(
                waveform,
                (smallest, largest),
                longest,
                threshold,
                sides,
            )?),
            Self::MovingAverage { window } => {
                Evaluator::MovingAverage(MovingAverage::new(window, threshold, sides)?)
            }
            Self::ChiSquare { window } => {
                Evaluator::ChiSquare(WindowedChiSquare::new(window, threshold)?)
            }
            Self::ShiryaevRoberts { shift } => {
                Evaluator::ShiryaevRoberts(ShiryaevRoberts::new(shift, threshold, sides)?)
            }
            Self::Variance { window } => {
                Evaluator::Variance(WindowedVariance::new(window, threshold, sides)?)
            }
            Self::Whiteness { window, lags } => {
                Evaluator::Whiteness(Whiteness::new(window, lags, threshold)?)
            }
        })
    }

    /// Samples within the limit that end an alarm: about as many as the statistic remembers.
    pub fn release(&self) -> usize {
        match *self {
            Self::Modulus => 1,
            Self::Cusum { allowance } => memory(allowance),
            Self::ShiryaevRoberts { shift } => memory(0.5 * shift),
            Self::Glr { longest, .. } => longest.div_ceil(4),
            Self::MovingAverage { window }
            | Self::ChiSquare { window }
            | Self::Variance { window }
            | Self::Whiteness { window, .. } => window,
        }
    }

    /// Samples until a window is full and its value means what it says.
    pub fn warm_up(&self) -> usize {
        match *self {
            Self::MovingAverage { window }
            | Self::ChiSquare { window }
            | Self::Variance { window }
            | Self::Whiteness { window, .. } => window,
            _ => 0,
        }
    }

    /// The scale on which high values have an exponential tail, for `residuals` residuals at once:
    /// likelihood ratios and cumulative sums as they are, moduli and averages squared, sums of
    /// squares (and of squared correlations) by the square of the normal deviate that Wilson and Hilferty
    /// give them.
    pub(crate) fn to_tail(self, value: f64, residuals: usize) -> f64 {
        let squares = |sum: f64, window: usize| {
            let freedom = (window * residuals) as f64;
            let spread = 2.0 / (9.0 * freedom);
            let deviate = ((sum / freedom).cbrt() - 1.0 + spread) / spread.sqrt();
            // Continues below the mean, where no limit ever is, so that the scale has an inverse.
            deviate * deviate.abs()
        };
        match self {
            Self::Cusum { .. } | Self::Glr { .. } | Self::ShiryaevRoberts { .. } => value,
            Self::Modulus if residuals == 1 => value * value,
            Self::MovingAverage { .. } | Self::Variance { .. } => value * value,
            Self::Whiteness { lags, .. } => squares(value, lags),
            Self::Modulus => squares(value * value, 1),
            Self::ChiSquare { window } => squares(value, window),
        }
    }

    /// The inverse of [`StatisticKind::to_tail`].
    pub(crate) fn value_of_tail(self, tail: f64, residuals: usize) -> f64 {
        let sum = |window: usize| {
            let freedom = (window * residuals) as f64;
            let spread = 2.0 / (9.0 * freedom);
            let deviate = tail.abs().sqrt().copysign(tail);
            freedom * (1.0 - spread + deviate * spread.sqrt()).max(0.0).powi(3)
        };
        match self {
            Self::Cusum { .. } | Self::Glr { .. } | Self::ShiryaevRoberts { .. } => tail,
            Self::Modulus if residuals == 1 => tail.max(0.0).sqrt(),
            Self::MovingAverage { .. } | Self::Variance { .. } => tail.max(0.0).sqrt(),
            Self::Whiteness { lags, .. } => sum(lags),
            Self::Modulus => sum(1).sqrt(),
            Self::ChiSquare { window } => sum(window),
        }
    }

    /// The limit with a mean time between false alarms of `run_length` samples on white residuals:
    /// of a cumulative sum by its integral equation, else by the tail of a simulation with a fixed
    /// seed.
    pub(crate) fn white_limit(self, residuals: usize, run_length: f64) -> Result<f64, FdiError> {
        if let (Self::Cusum { allowance }, 1) = (self, residuals) {
            return CusumRunLength::threshold_for(allowance, Sides::Both, run_length);
        }
        if let Self::ShiryaevRoberts { shift } = self
            && (SHIRYAEV_ROBERTS_SHIFTS.0..=SHIRYAEV_ROBERTS_SHIFTS.1).contains(&shift)
        {
            // Both sides have nearly the time of one.
            return ShiryaevRobertsRunLength::threshold_for(shift, run_length);
        }
        let mut evaluator = self.evaluator(1.0)?;
        let mut noise = WhiteNoise::new(WHITE_SEED, residuals);
        let samples = WHITE_SAMPLES.max(WHITE_RELEASES * self.release());
        let values: Vec<f64> = (0..samples)
            .map(|_| self.to_tail(evaluator.step(noise.next()).value, residuals))
            .collect();
        let tail = Tail::fit(&[&values], self.release(), run_length)?;
        Ok(self.value_of_tail(tail.limit_for(run_length), residuals))
    }
}

/// Samples that a cumulative sum with this allowance remembers, or so.
#[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)] // within the bounds
fn memory(allowance: f64) -> usize {
    (4.0 / (allowance * allowance)).clamp(1.0, MAX_WINDOW as f64) as usize
}

/// Standard normal numbers, or the norms of vectors of them.
struct WhiteNoise {
    random: rand_chacha::ChaCha8Rng,
    size: usize,
}

impl WhiteNoise {
    fn new(seed: u64, size: usize) -> Self {
        use rand::SeedableRng;
        Self {
            random: rand_chacha::ChaCha8Rng::seed_from_u64(seed),
            size,
        }
    }

    fn next(&mut self) -> f64 {
        use rand_distr::{Distribution, StandardNormal};
        if self.size == 1 {
            return StandardNormal.sample(&mut self.random);
        }
        let squares = (0..self.size).map(|_| {
            let value: f64 = StandardNormal.sample(&mut self.random);
            value * value
        });
        squares.sum::<f64>().sqrt()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// There and back: for one residual and for three, over the values that limits have.
    #[test]
    fn tails_have_an_inverse() {
        let kinds = [
            StatisticKind::Modulus,
            StatisticKind::Cusum { allowance: 0.5 },
            StatisticKind::MovingAverage { window: 20 },
            StatisticKind::ChiSquare { window: 10 },
            StatisticKind::ShiryaevRoberts { shift: 1.0 },
            StatisticKind::Variance { window: 20 },
            StatisticKind::Whiteness {
                window: 100,
                lags: 5,
            },
        ];
        for kind in kinds {
            for residuals in [1, 3] {
                for step in 1..40 {
                    let value = 0.5 * f64::from(step);
                    let back = kind.value_of_tail(kind.to_tail(value, residuals), residuals);
                    // A cube root and a cube.
                    assert!(
                        (back - value).abs() < 1e-12 * value,
                        "{kind:?} {value} {back}"
                    );
                }
            }
        }
    }

    /// Simulated limits against a closed form: rows of one sample beyond a limit, of which
    /// `1 / ARL0` of all samples are, and 20 % of one sample's tail is 3 % of its limit.
    #[test]
    fn the_simulated_white_limit_is_that_of_independent_samples() {
        let limit = StatisticKind::ChiSquare { window: 1 }
            .white_limit(1, 1e5)
            .expect("a limit");
        // P(|z| > 4.4172) = 1e-5.
        assert!(
            (limit.sqrt() / 4.4172 - 1.0).abs() < 0.02,
            "{}",
            limit.sqrt()
        );
    }
}
