//! Disturbances of which nothing is known but where they enter: residuals that feel them least, and
//! residuals that do not feel them.

mod decoupling;
mod error;
mod fault_model;
mod frequency_gain;
mod generator;
mod linear_residual;
mod observer;
mod robustness;
mod unified;

pub use decoupling::{MIN_DECOUPLING_GAIN, MIN_DETECTABILITY};
pub use error::UnknownInputError;
pub use fault_model::{FaultModel, UnknownInput};
pub use frequency_gain::{FrequencyBand, PEAK_TOLERANCE, PeakGain, peak_gain};
pub use linear_residual::LinearResidual;
pub use observer::UnknownInputObserver;
pub use robustness::Robustness;
pub use unified::{MIN_REACH, UnifiedFilter};
