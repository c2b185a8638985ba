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
mod constrained;
mod eiv;
mod eiv_model;
mod errors;
mod fit;
mod free_run;
mod frequency_response;
mod frisch;
mod known;
mod order;
mod output_error;
mod pole_zero;
mod realisation;
mod reference;
mod residual_tests;
mod schedule;
mod solvers;
mod spread;
