//! Poles and zeros of an identified model with standard errors, and what they say about its order.

mod cancellation;
mod gradient;
mod invariant;
mod polynomial;
mod report;
mod root;

pub use cancellation::{CANCELLATION_LIMIT, Cancellation};
pub use invariant::invariant_zeros;
pub use report::{ChannelZeros, ORIGIN_RADIUS, Pole, PoleZeroReport, pole_zero};
pub use root::{RESOLUTION, Root};
