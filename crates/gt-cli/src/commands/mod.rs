//! One file a verb.

pub mod design;
pub mod detect;
pub mod identify;
pub mod log_info;
mod poles;
pub mod reproduce;
pub mod simulate;

/// Version of every JSON object on standard output; it rises when a key changes its meaning.
pub const SCHEMA_VERSION: u32 = 1;
