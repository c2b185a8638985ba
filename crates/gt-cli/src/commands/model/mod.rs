//! `gtfdi model`: what stands in a model file, and whether it is sound.

mod check;
mod on_record;
mod realisation;
mod roots;
mod show;

use std::path::Path;

use gt_log::{ModelFile, read_json};

pub use check::check;
pub use show::show;

use crate::failure::Failure;

/// Reads a model file, which is checked on the way: version, digest, equations.
fn read(path: &Path) -> Result<ModelFile, Failure> {
    read_json(path).map_err(Failure::input)
}
