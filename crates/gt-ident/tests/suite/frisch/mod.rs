//! The dynamic Frisch scheme.

mod monte_carlo;
mod surface;
mod systems;
mod vectors;
