//! Reports of one identification or one detection: a page that explains itself, made of a model or
//! a detector and the records that it met.

mod clock;
mod detection;
mod isolation;
mod model;
mod orders;
mod provenance;
mod signals;
mod statistic;

pub use detection::detection_report;
pub use isolation::isolation_report;
pub(crate) use model::{Certainty, pole_figures, response_figures};
pub use model::{ModelReport, Orders, model_report};
pub use orders::OrderComparison;
pub use provenance::Provenance;
