//! Seeded campaigns on the simulated turbine: the source paper's tables and figures again, and the
//! report that shows them.
//!
//! | what is wanted | begin with |
//! |---|---|
//! | the paper's tables and figures again | [`reproduce()`], [`Reproduction`] |
//! | thousands of runs with faults drawn at random | [`campaign::Spec`], [`campaign::prepare`], [`campaign::Campaign::fill`] |
//! | what they say: detection against size, delays, ROC, names | [`campaign::Summary`] |
//! | two campaigns side by side | [`campaign::Comparison`] |
//! | how small a fault an isolator finds, and how it names it | [`isolation`] |
//! | a bank or an isolator from a model, as the command line and Python make it | [`TestPlan`], [`StatisticChoice`], [`IsolatorPlan`] |
//!
//! [`reproduce()`] simulates, identifies, designs and detects; [`Reproduction`] holds the numbers and
//! writes the page, figures and logs. [`campaign`] runs faults that are drawn at random by the
//! thousand, and says how they are detected. [`reports`] makes pages of single identifications and
//! detections. Progress is told to a [`Progress`]; drawing it is the
//! caller's affair.

mod bank_design;
pub mod campaign;
mod error;
pub mod isolation;
mod isolator_design;
pub mod paper;
mod paper_models;
mod parallel;
mod progress;
pub mod report;
pub mod reports;
mod reproduce;
mod statistic_choice;
mod unknown_input;

pub use bank_design::{
    JOINT_TEST, Refusal, TestPlan, Watch, in_sample_optimism, kalman_generator, search_observers,
};
pub use error::CampaignError;
pub use isolator_design::{
    DescriptionError, FaultDescription, FaultDescriptions, IsolatorPlan, PairDescription,
    PairRecords, joint_kalman_generator,
};
pub use progress::{Progress, Silent};
pub use reproduce::tables;
pub use reproduce::{Depth, Reproduction, reproduce};
pub use statistic_choice::{OptionRefusal, StatisticChoice, StatisticName};
pub use unknown_input::unknown_input_generator;
