//! The dynamic Frisch scheme.

mod errors;
mod monte_carlo;
mod order;
mod reference;
mod shared;
mod surface;
mod systems;
mod vectors;
