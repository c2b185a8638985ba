//! What all statistics share.

use serde::Serialize;

/// The largest modulus of a sample, in standard deviations: larger ones count as this.
pub const LARGEST_SAMPLE: f64 = 1e100;

/// What a statistic says of one sample.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Decision {
    /// The statistic after the sample, in its own unit.
    pub value: f64,
    /// Whether the value is above the threshold.
    pub alarm: bool,
    /// Whether the sample was NaN or infinite: then the value is that of the sample before.
    pub missing: bool,
}

/// A decision on one residual with memory, judged against one threshold.
///
/// | looks for | statistic |
/// |---|---|
/// | a step of about known size | [`Cusum`](super::Cusum), [`ShiryaevRoberts`](super::ShiryaevRoberts) |
/// | a step or ramp of a range of sizes, with its onset and size | [`Glr`](super::Glr) |
/// | a shift, by simple means | [`MovingAverage`](super::MovingAverage), [`RunSum`](super::RunSum) |
/// | which of two means it is, once | [`Sprt`](super::Sprt) |
/// | more energy | [`WindowedChiSquare`](super::WindowedChiSquare), [`GrowingChiSquare`](super::GrowingChiSquare) |
/// | more or less noise | [`WindowedVariance`](super::WindowedVariance), [`GrowingVariance`](super::GrowingVariance) |
/// | a model that no longer fits | [`Whiteness`](super::Whiteness) |
///
/// Residuals are whitened and in units of their healthy standard deviation. Steps take a bounded
/// time and allocate nothing. States are values: they compare, clone and pass through serde without
/// losing a bit, and go on as if nothing had happened.
///
/// - **Missing samples.** A residual that is NaN or infinite changes nothing and is flagged; time,
///   for windows and onsets, is the number of samples that were not missing.
/// - **Huge samples.** A residual beyond [`LARGEST_SAMPLE`] counts as that, so that no sum
///   overflows.
/// - **Start.** Windows that are not yet full hold zeros (averages, sums of squares) or are not
///   looked at (likelihood ratios, variances, correlations): then the value is 0.
/// - **Alarm.** It is up while the value is above the threshold; nothing resets by itself.
pub trait Statistic {
    /// Takes the residual `r` (in standard deviations) into account.
    fn step(&mut self, r: f64) -> Decision {
        let missing = !r.is_finite();
        if !missing {
            self.take(r.clamp(-LARGEST_SAMPLE, LARGEST_SAMPLE));
        }
        let value = self.value();
        Decision {
            value,
            alarm: value > self.threshold(),
            missing,
        }
    }

    /// Takes a residual between -[`LARGEST_SAMPLE`] and [`LARGEST_SAMPLE`] into account; called by
    /// [`Statistic::step`].
    fn take(&mut self, r: f64);

    /// Forgets all samples.
    fn reset(&mut self);

    /// The statistic after the last sample, in its own unit.
    fn value(&self) -> f64;

    /// The value above which the alarm is up.
    fn threshold(&self) -> f64;
}
