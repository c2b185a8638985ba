//! The poles of an output observer that tell a fault best from what is there without it (the
//! paper's eq. 23 and 24, Algorithm 1), and how much any filter could tell.

mod data_bound;
mod energy_ratio;
mod equation_error;
mod error;
mod evolution;
mod observer_design;
mod pole_search;
mod record_pair;
mod sections;
mod sqp;
mod start;

pub use data_bound::DataBound;
pub use energy_ratio::{Criterion, EnergyRatio};
pub use error::SearchError;
pub use observer_design::{Attempt, ObserverDesign};
pub use pole_search::{PoleSearch, SearchMethod};
pub use record_pair::RecordPair;
pub use sections::Sections;
pub use start::Start;
