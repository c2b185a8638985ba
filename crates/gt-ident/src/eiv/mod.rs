//! Errors-in-variables models: white noise on inputs and outputs alike, a noise-free relation
//! between what they would be without it.

mod autoregression;
mod coordinates;
mod estimate;
mod fit;
mod hermitian;
mod information;
mod layout;
mod lbfgs;
mod likelihood;
mod model;
mod moments;
mod order;
mod record;
mod refine;
mod reflection;
mod row;
mod spectrum;
mod start;

pub use autoregression::NOISE_FLOOR;
pub use estimate::{EivEstimate, EivVariance, IDENTIFIABLE_DEVIATION};
pub use fit::Eiv;
pub use lbfgs::{Lbfgs, Minimum};
pub use likelihood::Likelihood;
pub use model::{ChannelNoise, EivModel};
pub use order::{EivOrderRow, EivOrderTable, eiv_order_table};
pub use row::{EivLags, EivRow, NoiseVariances};
pub use spectrum::Spectrum;
