//! Errors-in-variables models: white noise on inputs and outputs alike, a noise-free relation
//! between what they would be without it.

mod model;
mod row;

pub use model::{ChannelNoise, EivModel, IDENTIFIABLE_DEVIATION};
pub use row::{EivLags, EivRow, NoiseVariances};
