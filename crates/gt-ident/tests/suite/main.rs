//! Tests of gt-ident through its public interface, in one binary.

#![allow(
    clippy::unwrap_used,
    clippy::panic,
    reason = "the helpers of a test may fail it"
)]
#![allow(
    clippy::float_cmp,
    reason = "numbers that are copied, not computed, are compared exactly"
)]

mod common;
mod eiv_model;
mod eiv;
mod errors;
mod fit;
mod frisch;
mod frequency_response;
mod known;
mod order;
mod pole_zero;
mod realisation;
mod reference;
mod solvers;
mod spread;
mod residual_tests;
