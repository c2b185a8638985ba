//! Errors-in-variables models: white noise on inputs and outputs alike, a noise-free relation
//! between what they would be without it.

mod row;

pub use row::{EivLags, EivRow, NoiseVariances};
