//! Errors-in-variables models: the likelihood and its information against identities, the fit
//! against its bound, published-style vectors and exact errors.

mod fit;
mod identification;
mod likelihood;
mod minimiser;
mod monte_carlo;
mod order;
mod reference;
mod refused;
mod system;
mod vectors;
