//! Identification of linear models from a record: ARX in canonical and in free structure, the
//! choice of its order, its realisation as a state-space model and its validation.
//!
//! ```text
//! Dataset -> Arx::fit -> ArxModel -> validate, predict, simulate
//!                                 -> state_space, output_model -> gt_core::StateSpace
//! ```
//!
//! ```
//! use gt_core::{Dataset, Signal};
//! use gt_ident::{Arx, ArxStructure, validate};
//! use nalgebra::DMatrix;
//!
//! // y(t) = 0.8 y(t-1) + 0.5 u(t-1), driven by a square wave of 14 samples.
//! let u = DMatrix::from_fn(1, 84, |_, t| if t % 14 < 7 { 1.0 } else { 0.0 });
//! let mut y = DMatrix::zeros(1, 84);
//! for t in 1..84 {
//!     y[t] = 0.8 * y[t - 1] + 0.5 * u[t - 1];
//! }
//! let data = Dataset::new(Signal::named(&["valve"]), Signal::named(&["speed"]), u, y, 0.1)?;
//!
//! let structure = ArxStructure::Canonical { indices: vec![1], feedthrough: false };
//! let model = Arx::new(structure).fit(&data)?;
//! let fit = &validate(&model, &data)?.outputs[0];
//! assert!(fit.fit_simulation_percent > Some(95.0));
//! assert!((model.state_space()?.a()[0] - 0.8).abs() < 0.05);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! The means are removed before the fit; where a record starts far from its mean, as here, this
//! costs some accuracy even without noise.
//!
//! Equation numbers are those of Simani and Fantuzzi (2006), section 4.1. Two of their formulas
//! are used corrected: in eq. 21 the blocks `M_ij` hold `alpha_ij` (printed: `alpha_ii`), in
//! eq. 16 the ones of `C` stand in columns `1, v_1 + 1, ...` (printed: `v_i + 1`).
//!
//! **One step ahead or free run** is always said: [`ArxModel::predict`] sees the measured past
//! outputs, [`ArxModel::simulate`] sees only the inputs, and no number of one carries the name of
//! the other.

mod arx;
mod canonical;
pub mod constrained;
mod denominator;
mod dependence;
mod distributions;
pub mod eiv;
mod error;
mod estimate;
mod factor;
mod free_run;
mod frequency_response;
pub mod frisch;
mod gram;
mod index_search;
mod joint;
mod kernel;
mod least_squares;
mod model;
mod options;
mod order;
mod order_choice;
pub mod output_error;
mod parameter_covariance;
pub mod pole_zero;
mod predict;
mod realisation_report;
mod realise;
mod record;
mod refine;
mod regressor;
mod residual_tests;
pub mod schedule;
mod similarity;
mod structure;
mod symmetric;
mod tall;
mod transfer;
mod validate;

pub use arx::{Arx, ArxFit};
pub use canonical::CanonicalForm;
pub use dependence::Dependence;
pub use distributions::{chi_square_tail, chi_square_threshold, normal_quantile};
pub use error::IdentError;
pub use estimate::Estimate;
pub use free_run::{DIVERGENCE_FACTOR, FreeRun, START_LIMIT, Start};
pub use frequency_response::{FrequencyPoint, dc_gains, frequency_response};
pub use index_search::{INDEX_SET_LIMIT, IndexRow, IndexTable, index_table};
pub use least_squares::CONDITION_LIMIT;
pub use model::{ArxModel, ArxRow, Term};
pub use options::{Centre, EquationErrors, Missing, SolvedBy, Solver};
pub use order::{OrderKind, OrderRow, OrderTable, order_table};
pub use order_choice::{ChosenStructure, OrderChoice};
pub use parameter_covariance::{check_covariances, exact_coefficients, parameter_covariance};
pub use realisation_report::{
    CONDITION_WARNING, HANKEL_TOLERANCE, RealisationReport, RealisationWarning, realisation_report,
};
pub use realise::{OutputModel, STATE_LIMIT};
pub use record::unbroken;
pub use residual_tests::{
    Autocorrelation, ChiSquareTest, CrossCorrelation, OutputVerdict, RecordOrigin, ResidualOptions,
    ResidualReport, ResidualVerdict, Verdict, test_residuals, test_residuals_until,
};
pub use similarity::{RANK_TOLERANCE, Similarity};
pub use structure::{ArxStructure, Channel, Regressor, generic_indices};
pub use validate::{OutputFit, Validation, ValidationOptions, validate, validate_records};

#[cfg(test)]
mod stop_tests;
