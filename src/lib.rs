//! Model-based fault diagnosis for turbines and any plant with measured inputs and outputs.
//!
//! A record of healthy running becomes a model, a model a bank of residual generators with limits,
//! and the bank judges what comes after:
//!
//! ```text
//! plant or file -> core::Dataset -> ident::Arx::fit -> ident::ArxModel -> output_model
//!     -> core::StateSpace -> fdi::ResidualGenerator -> fdi::ResidualTest -> fdi::Bank
//!     -> fdi::Detector::step -> fdi::Verdict
//! ```
//!
//! ```
//! use gtfdi::fdi::{Bank, Detector, ResidualGenerator, ResidualTest, StatisticKind, ThresholdRule};
//! use gtfdi::ident::{Arx, OrderKind};
//! use gtfdi::plant::{Fault, FaultCase, Scenario, simulate};
//!
//! // Two healthy records of the simulated turbine, and one whose thermocouple drifts from 30 s on.
//! let record = |run_index, faults| {
//!     let scenario = Scenario { duration_s: 120.0, run_index, faults, ..Scenario::default() };
//!     let run = simulate(&scenario)?;
//!     Ok::<_, Box<dyn std::error::Error>>(run.measured.select(&["a_v", "M_f"], &["t3"])?)
//! };
//! let (train, healthy) = (record(0, vec![])?, record(1, vec![])?);
//! let drift = Fault::growing(FaultCase::ThermocoupleDrift, 30.0, 20.0, None);
//! let faulty = record(2, vec![drift])?;
//!
//! // A model of order 8; the fuel demand acts within its sample, so its lags begin at 0.
//! let structure = OrderKind::Diagonal { nk: vec![1, 0] }.structure(8, 1)?;
//! let part = Arx::new(structure).fit(&train)?.output_model(0)?;
//!
//! // An observer with all its poles at 0.3, and a limit of twice the largest healthy residual.
//! let poles = vec![0.3; part.model.nx()];
//! let observer = ResidualGenerator::observer(part.model, part.point, &poles)?;
//! let rule = ThresholdRule::Margin { factor: 2.0, consecutive: 3 };
//! let statistic = StatisticKind::Modulus;
//! let test = ResidualTest::calibrate("t3", &[&observer], &[healthy], statistic, rule)?;
//! let bank = Bank::new("thermocouple", vec![observer], vec![test])?;
//!
//! // Sample by sample, as beside the plant.
//! let mut detector = Detector::new(&bank);
//! let mut first_alarm_s = None;
//! for k in 0..faulty.len() {
//!     let (u, y) = (faulty.u().column(k), faulty.y().column(k));
//!     let verdict = detector.step(faulty.time_s(k), u.as_slice(), y.as_slice())?;
//!     if verdict.channels[0].new_alarm && first_alarm_s.is_none() {
//!         first_alarm_s = Some(verdict.time_s);
//!     }
//! }
//! assert!(first_alarm_s.is_some_and(|time_s| time_s > 30.0));
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! # Rooms
//!
//! This crate is a facade: it only re-exports the rooms of the workspace.
//!
//! | room | what is there | begin with |
//! |---|---|---|
//! | [`core`] | signals, records, state-space models | [`core::Dataset`], [`core::StateSpace`] |
//! | [`plant`] | the non-linear gas turbine with its faults | [`plant::simulate`], [`plant::Scenario`] |
//! | [`ident`] | models from records, exact inputs or noisy ones | [`ident::Arx`], [`ident::eiv`] |
//! | [`fdi`] | residuals, limits, verdicts, names of faults | [`fdi::design`], [`fdi::runtime`] |
//!
//! Files, campaigns and the service are crates of their own beside it: `gt-log`, `gt-campaign`,
//! `gt-serve`.
//!
//! # How to go on
//!
//! - **Noise on the inputs**: [`ident::eiv::EivIdentification`] finds the relation and the noise of
//!   every channel, [`fdi::ResidualGenerator::kalman`] makes the filter for it.
//! - **Limits that promise something**: [`fdi::ThresholdRule::MeanTimeBetweenFalseAlarms`] with a
//!   statistic of [`fdi::StatisticKind`] on the whitened residual; [`fdi::MeanTime`] says what so much
//!   healthy running can promise.
//! - **Which fault, since when, how large**: [`fdi::Isolator`].
//! - **Beside the plant**: [`fdi::Detector`] allocates nothing a step and needs no std without the
//!   feature `design`; [`fdi::DetectorState`] is all that it remembers.
//!
//! Conventions: matrices are `channels x samples`, units are SI and stand in names, *prediction* is one
//! step ahead and *simulation* a free run, randomness is a seed and a run index.

pub use gt_core as core;
pub use gt_fdi as fdi;
pub use gt_ident as ident;
pub use gt_plant as plant;

/// The Rust block of the README, run as a documentation test.
#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct Readme;
