//! Excitation: random levels of valve, speed reference and fuel with limited slew, a schedule of
//! the fuel, and fuel dither.

mod choice;
mod dither;
mod level;
mod named;
mod profile;
pub mod schedule;

pub(crate) use choice::ProfileChoice;
pub(crate) use dither::Dither;
pub(crate) use level::SteppedLevel;
pub use profile::Profile;

pub(crate) use crate::random::standard_normal;
