//! What every other crate of gtfdi shares: named [`Signal`]s, a [`Dataset`] of inputs and outputs,
//! a checked discrete [`StateSpace`] model with its [`OperatingPoint`], and the errors of shapes
//! and data.
//!
//! `Dataset` and `StateSpace` are the joints of the project: simulators and files end in the
//! first, identification ends in the second, residual generators start from both.
//!
//! ```
//! use gt_core::{Dataset, Signal, StateSpace};
//! use nalgebra::{DMatrix, DVector};
//!
//! // A column is a sample: channels x samples.
//! let (u, y) = (DMatrix::from_element(1, 50, 2.0), DMatrix::zeros(1, 50));
//! let (inputs, outputs) = (vec![Signal::new("fuel", "kg/s")], vec![Signal::new("speed", "rad/s")]);
//! let record = Dataset::new(inputs.clone(), outputs.clone(), u, y, 0.1)?;
//! assert_eq!((record.nu(), record.ny(), record.len()), (1, 1, 50));
//!
//! // x(t+1) = 0.5 x(t) + u(t), y(t) = x(t): from 0 it goes to 2 u.
//! let matrices = [0.5, 1.0, 1.0, 0.0].map(|entry| DMatrix::from_element(1, 1, entry));
//! let model = StateSpace::new(matrices, 0.1, inputs, outputs)?;
//! let free_run = model.simulate(&DVector::zeros(1), record.u())?;
//! // 0.5^49 is left of the way.
//! assert!((free_run[49] - 4.0).abs() < 1e-13);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! A sample that is not valid is NaN; what takes no NaN calls [`Dataset::check_finite`] and says which
//! sample of which channel it is. Matrices are those of nalgebra. The features `faer` and `qp` open the
//! only doors to those libraries, for the crates that factorise and optimise.

mod dataset;
mod error;
#[cfg(feature = "faer")]
pub mod la;
mod operating_point;
#[cfg(feature = "qp")]
pub mod qp;
mod signal;
mod state_space;
mod stop;
mod stored_matrix;
mod trend;

pub use dataset::Dataset;
pub use error::{DataError, DimensionError, ModelError};
pub use operating_point::OperatingPoint;
pub use signal::{Signal, index_of};
pub use state_space::StateSpace;
pub use stop::{Never, Stop, Stopped};
pub use stored_matrix::stored_matrix;
pub use trend::Trend;
