//! Model-based fault diagnosis for turbines and any plant with measured inputs and outputs.
//!
//! This crate is a facade: it only re-exports the rooms of the workspace.
//!
//! * [`core`]: signals, datasets, state-space models;
//! * [`plant`]: the non-linear gas turbine with faults;
//! * [`ident`]: identification and realisation of linear models;
//! * [`fdi`]: residual generators, thresholds, signatures, the online detector.
//!
//! Data flows one way: plant or record -> [`core::Dataset`] -> [`ident::ArxModel`] ->
//! [`core::StateSpace`] -> [`fdi::Bank`] -> [`fdi::Detector`] -> verdict.

pub use gt_core as core;
pub use gt_fdi as fdi;
pub use gt_ident as ident;
pub use gt_plant as plant;

/// The Rust block of the README, run as a documentation test.
#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct Readme;
