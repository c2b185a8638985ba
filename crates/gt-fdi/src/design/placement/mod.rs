//! Poles of observers: as they are stored, and their placement for several outputs.

mod assignment;
mod error;
mod least_norm;
mod placed_poles;
mod schur;
mod schur_placement;

pub use error::PlacementError;
pub use schur_placement::{SchurPlacement, StabilityBound};

pub(super) use placed_poles::{PlacedPoles, check_complex, pair, polynomial};
