//! One file a verb.

pub mod campaign;
pub mod config;
pub mod data_check;
pub mod design;
pub mod detect;
mod equation;
mod finding;
pub mod identify;
pub mod log;
pub mod model;
mod noise;
mod report_folder;
pub mod reproduce;
pub mod serve;
pub mod shell;
pub mod simulate;

/// Version of every JSON object on standard output; it rises when a key changes its meaning.
pub const SCHEMA_VERSION: u32 = 1;
