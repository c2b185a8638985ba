//! Errors of the plant.

use gt_core::DataError;
use thiserror::Error;

use crate::FaultCase;

/// Why a plant, a scenario or a run is refused.
#[derive(Debug, Clone, PartialEq, Error)]
pub enum PlantError {
    /// A parameter of the turbine is physically impossible.
    #[error("plant parameter {name}: expected {expected}, found {found}")]
    Parameter {
        /// Path of the field.
        name: &'static str,
        /// What would be possible.
        expected: &'static str,
        /// The value found.
        found: f64,
    },
    /// A number of the scenario, its profile or a fault makes no sense.
    #[error("{what}: expected {expected}, found {found}")]
    Scenario {
        /// Which option.
        what: &'static str,
        /// What would make sense.
        expected: &'static str,
        /// The value found.
        found: f64,
    },
    /// The record would be empty or too long.
    #[error("duration: expected between {shortest_s} and {longest_s} s, found {found_s}")]
    Duration {
        /// The shortest record, one sample, in seconds.
        shortest_s: f64,
        /// The longest record in seconds.
        longest_s: f64,
        /// The duration found, in seconds.
        found_s: f64,
    },
    /// The integration step is outside the stability limit, or absurdly small.
    #[error(
        "substeps: expected {least} to {most} a sample (RK4 is stable up to a step of {limit_s} s), found {found}"
    )]
    Substeps {
        /// Fewest substeps that are stable.
        least: usize,
        /// Most substeps that are accepted.
        most: usize,
        /// Longest stable step in seconds.
        limit_s: f64,
        /// The number found.
        found: usize,
    },
    /// A name that stands for nothing.
    #[error("{what}: expected one of {}, found `{found}`", expected.join(", "))]
    UnknownName {
        /// What was to be named.
        what: &'static str,
        /// The names there are.
        expected: &'static [&'static str],
        /// The name found.
        found: String,
    },
    /// One fault case stands twice in a scenario.
    #[error("faults: expected each case once, found {} twice", case.name())]
    RepeatedFault {
        /// The case.
        case: FaultCase,
    },
    /// Newton's method found no equilibrium.
    #[error(
        "trim: expected a largest relative rate below {tolerance_per_s} 1/s within {iterations} \
         iterations, found {found_per_s}"
    )]
    Trim {
        /// Iterations spent.
        iterations: usize,
        /// What counts as an equilibrium: rate of each state over its size, 1/s.
        tolerance_per_s: f64,
        /// The rate that was left, 1/s.
        found_per_s: f64,
    },
    /// The plant left the range in which the model means something, or is no longer finite.
    #[error("{quantity} at {time_s} s: expected between {low} and {high}, found {found}")]
    OutOfRange {
        /// When, in seconds.
        time_s: f64,
        /// Which quantity, with its unit.
        quantity: &'static str,
        /// Lower end of the range.
        low: f64,
        /// Upper end of the range.
        high: f64,
        /// The value found.
        found: f64,
    },
    /// A dataset could not be built.
    #[error(transparent)]
    Data(#[from] DataError),
}
