//! The dynamic Frisch scheme.

mod monte_carlo;
mod probe;
mod surface;
mod systems;
mod vectors;
