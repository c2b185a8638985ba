//! How much more a residual feels faults than disturbances.

use gt_core::StateSpace;

use super::frequency_gain::{FrequencyBand, PeakGain, least_gain, peak_gain};
use crate::FdiError;

/// The two gains of a residual and their ratio, `H_- / H_inf`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Robustness {
    /// The most that a disturbance is amplified, over all frequencies and directions.
    pub disturbance: PeakGain,
    /// The least that a fault within the band is amplified, over all directions: `H_-`. It is 0
    /// where there are more faults than residuals, infinite where there is no fault.
    pub fault: f64,
    /// Where that is, in hertz.
    pub fault_frequency_hz: f64,
    /// `fault / disturbance.gain`.
    pub ratio: f64,
}

impl Robustness {
    /// Judges a residual by its responses to disturbances (nr x nd) and to faults (nr x nf). The
    /// largest gain is that of [`peak_gain`]; the smallest one is found by a sweep over the band
    /// whose lowest minima are refined.
    ///
    /// # Errors
    /// As [`peak_gain`]; [`super::UnknownInputError::Band`].
    pub fn of(
        from_disturbance: &StateSpace,
        from_fault: &StateSpace,
        band: FrequencyBand,
    ) -> Result<Self, FdiError> {
        let disturbance = peak_gain(from_disturbance)?;
        let (fault, fault_frequency_hz) = least_gain(from_fault, band)?;
        Ok(Self {
            disturbance,
            fault,
            fault_frequency_hz,
            ratio: fault / disturbance.gain,
        })
    }
}
