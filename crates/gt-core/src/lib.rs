//! What every other crate of gtfdi shares: named [`Signal`]s, a [`Dataset`] of inputs and outputs,
//! a checked discrete [`StateSpace`] model with its [`OperatingPoint`], and the errors of shapes
//! and data.
//!
//! `Dataset` and `StateSpace` are the joints of the project: simulators and files end in the
//! first, identification ends in the second, residual generators start from both.

mod dataset;
mod error;
#[cfg(feature = "faer")]
pub mod la;
mod operating_point;
#[cfg(feature = "qp")]
pub mod qp;
mod signal;
mod state_space;
mod stored_matrix;
mod trend;

pub use dataset::Dataset;
pub use error::{DataError, DimensionError, ModelError};
pub use operating_point::OperatingPoint;
pub use signal::{Signal, index_of};
pub use state_space::StateSpace;
pub use stored_matrix::stored_matrix;
pub use trend::Trend;
