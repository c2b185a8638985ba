//! The dynamic Frisch scheme: relation and noise variances of an errors-in-variables model from
//! second-order statistics alone, with no model of the inputs.
//!
//! White noise of unknown variances on the inputs and the output leaves a surface of variances and
//! relations that explain the covariance of the lagged channels equally well
//! ([`AdmissibleSurface`]); a [`Criterion`] chooses the point. The estimates are consistent, not
//! efficient: they are what a likelihood starts from, and what tells where it cannot be trusted
//! ([`FrischNoise`]).
//!
//! Beghelli, Guidorzi and Soverini (1990), Automatica 26(1) 171-176; Diversi, Guidorzi and Soverini
//! (2003), "Algorithms for optimal errors-in-variables filtering"; Soederstroem (2018),
//! "Errors-in-Variables Methods in System Identification", ch. 8.

mod brent;
mod covariance;
mod criterion;
mod criterion_kind;
mod estimate;
mod fit;
mod moment_system;
mod moments;
mod nelder_mead;
mod order;
mod search;
mod shared;
mod surface;

pub use covariance::LaggedCovariance;
pub use criterion::Criterion;
pub use criterion_kind::{CRITERION_LAGS, CriterionKind};
pub use estimate::{BOUNDARY_SHARE, FrischEstimate, FrischNoise};
pub use fit::Frisch;
pub use moments::{MomentsEstimate, WeightedMoments};
pub use order::{FrischOrderRow, FrischOrderTable, frisch_order_table, frisch_order_table_until};
pub use shared::SharedFrischEstimate;
pub use surface::{AdmissibleSurface, SurfacePoint};
