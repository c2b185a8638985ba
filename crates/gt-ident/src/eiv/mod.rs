//! Errors-in-variables models: white noise on inputs and outputs alike, a noise-free relation
//! between what they would be without it.
//!
//! ```text
//! Dataset -> Spectrum (autoregression) -> Likelihood, minimised from many starts -> EivEstimate
//! ```
//!
//! ```no_run
//! use gt_ident::eiv::{Eiv, EivLags, eiv_order_table};
//! # fn record() -> gt_core::Dataset { unimplemented!() }
//!
//! let data = record(); // one output, two inputs
//! let order = eiv_order_table(&data, 1..=4, &[1, 1])?.best_bic();
//! let estimate = Eiv::new(vec![EivLags::new(order, vec![1, 1])?]).fit(&data)?;
//! for (input, noise) in estimate.inputs.iter().zip(&estimate.input_noise) {
//!     if !noise.identifiable() {
//!         println!("{}: the record does not tell the noise", input.name);
//!     }
//! }
//! # Ok::<(), gt_ident::IdentError>(())
//! ```
//!
//! [`Eiv`] reaches the bound that no consistent estimator beats on all systems of the example
//! `eiv_monte_carlo`, slow poles included, where least squares is off by 5 to 80 times as much.
//! One thing it does not reach: the variance of an input that a slow plant shows only at
//! frequencies below the resolution of the spectrum. At 30 dB and N = 2000 with poles 0.95 and 0.8
//! it comes out several of its deviations too large (0.2 per cent of the variance of the input).

mod autoregression;
mod coordinates;
mod estimate;
mod fit;
mod hermitian;
mod identification;
mod information;
mod joint;
mod layout;
mod lbfgs;
mod likelihood;
mod model;
mod moments;
mod order;
mod record;
mod refine;
mod reflection;
mod remark;
mod row;
mod spectrum;
mod start;

pub use autoregression::NOISE_FLOOR;
pub use estimate::{EivEstimate, EivVariance, IDENTIFIABLE_DEVIATION};
pub use fit::Eiv;
pub use identification::{EivIdentification, EivMethod, IdentifiedEiv};
pub use lbfgs::{Lbfgs, Minimum};
pub use likelihood::Likelihood;
pub use model::{ChannelNoise, EivModel};
pub use order::{EivOrderRow, EivOrderTable, eiv_order_table, eiv_order_table_until};
pub use remark::EivRemark;
pub use row::{EivLags, EivRow, NoiseVariances};
pub use spectrum::Spectrum;
