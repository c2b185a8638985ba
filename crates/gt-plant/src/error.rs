//! Errors of the plant.

use gt_core::{DataError, ModelError, Stopped};
use thiserror::Error;

use crate::maps::{MapExit, MapKind, MapRule};
use crate::{Channel, Variant};

/// Why a plant, a scenario or a run is refused.
#[derive(Debug, Clone, PartialEq, Error)]
pub enum PlantError {
    /// The caller wanted the work to end.
    #[error(transparent)]
    Stopped(#[from] Stopped),
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
    /// The integration step is outside the stability limit of RK4 on the plant as it starts, or
    /// absurdly small.
    #[error(
        "substeps: expected {least} to {most} a sample (a step of at most {limit_s:.6} s), found {found}"
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
    /// An option that means nothing in the variant.
    #[error("{what}: expected in the variant {variant} {expected}, found {found}")]
    NotInVariant {
        /// Which option.
        what: &'static str,
        /// The variant of the scenario.
        variant: Variant,
        /// What would make sense there.
        expected: &'static str,
        /// What was found.
        found: String,
    },
    /// The keys of a fault in a file contradict each other, or one is missing.
    #[error("fault: expected {expected}, found {found}")]
    FaultTable {
        /// Which keys make sense.
        expected: &'static str,
        /// The keys found.
        found: String,
    },
    /// A mode that is on or off has another shape or size.
    #[error("mode {mode} of a fault: expected a step or intermittent of size 1, found {found} of {}",
        if *found == "ramp" { format!("{size} an hour") } else { format!("size {size}") })]
    FaultShape {
        /// The mode.
        mode: &'static str,
        /// The shape found.
        found: &'static str,
        /// Its size, or its rate per hour.
        size: f64,
    },
    /// One of several faults makes no sense.
    #[error("fault {number} ({name}), {cause}")]
    Fault {
        /// Which fault of the list, from 1.
        number: usize,
        /// What fails.
        name: String,
        /// Why.
        cause: Box<PlantError>,
    },
    /// Two faults hold one sensor or one actuator.
    #[error("faults: expected at most one that holds {held}, found {first} and {second}")]
    FaultConflict {
        /// The sensor or actuator.
        held: String,
        /// The first of the faults.
        first: String,
        /// The second.
        second: String,
    },
    /// A number of a channel's noise makes no sense.
    #[error("noise of {channel}, {option}: expected {expected}, found {found}")]
    Noise {
        /// Which channel.
        channel: Channel,
        /// Which option.
        option: &'static str,
        /// What would make sense.
        expected: &'static str,
        /// The value found.
        found: f64,
    },
    /// A channel's noise has two sizes.
    #[error("noise of {channel}: expected deviation or share, found both")]
    NoiseTwice {
        /// Which channel.
        channel: Channel,
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
    /// The equilibrium of the gas path is none of the plant with its controllers.
    #[error(
        "trim: expected controllers that hold the plant (a largest relative rate below \
         {tolerance_per_s} 1/s), found {found_per_s:.3e} 1/s: a limit, a stop or a stuck actuator \
         is in the way"
    )]
    NotHeld {
        /// What counts as held: rate of each state over its size, 1/s.
        tolerance_per_s: f64,
        /// The rate found, 1/s.
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
    /// A linear plant has a pole where its gain is asked for.
    #[error(
        "gain at {omega_rad_s} rad/s: expected j w I - A with a reciprocal condition of at least \
         {least}, found {found}"
    )]
    Singular {
        /// Angular frequency w in rad/s.
        omega_rad_s: f64,
        /// The least reciprocal condition that leaves a digit of the gain.
        least: f64,
        /// The reciprocal condition found; NaN when w is not finite.
        found: f64,
    },
    /// A linear plant or its discrete model could not be built.
    #[error(transparent)]
    Model(#[from] ModelError),
    /// A map has too few or too many speed lines.
    #[error("map: expected {least} to {most} speed lines, found {found}")]
    MapLines {
        /// Fewest lines that can be interpolated.
        least: usize,
        /// Most lines that are accepted.
        most: usize,
        /// The number found.
        found: usize,
    },
    /// The speed of a line of a map makes no sense, alone or behind the line before it.
    #[error("map line {line}, speed: expected {expected}, found {found}")]
    MapSpeed {
        /// Which line, from 1.
        line: usize,
        /// What would make sense.
        expected: MapRule,
        /// The speed found.
        found: f64,
    },
    /// A line of a map has too few or too many points.
    #[error("map line {line} (speed {speed}): expected {least} to {most} points, found {found}")]
    MapPoints {
        /// Which line, from 1.
        line: usize,
        /// Its speed.
        speed: f64,
        /// Fewest points of a line.
        least: usize,
        /// Most points of a line.
        most: usize,
        /// The number found: the length of `pressure_ratio`.
        found: usize,
    },
    /// The lists of a line of a map are not of one length.
    #[error(
        "map line {line} (speed {speed}), {list}: expected {expected} values, as many as in \
         pressure_ratio, found {found}"
    )]
    MapLength {
        /// Which line, from 1.
        line: usize,
        /// Its speed.
        speed: f64,
        /// Which list.
        list: &'static str,
        /// The length of `pressure_ratio`.
        expected: usize,
        /// The length found.
        found: usize,
    },
    /// A point of a map makes no sense, alone or beside its neighbours on the line.
    #[error("map line {line} (speed {speed}), {list}[{index}]: expected {expected}, found {found}")]
    MapPoint {
        /// Which line, from 1.
        line: usize,
        /// Its speed.
        speed: f64,
        /// Which list.
        list: &'static str,
        /// Which value of the list, from 0.
        index: usize,
        /// What would make sense.
        expected: MapRule,
        /// The value found.
        found: f64,
    },
    /// The plant left a tabulated map that refuses extrapolation.
    #[error(
        "{component} map at {time_s} s, {}: expected a {} between {} and {}, found {}",
        exit.edge, exit.edge.coordinate(), exit.low, exit.high, exit.value
    )]
    OutsideMap {
        /// Whose map: compressor or turbine.
        component: &'static str,
        /// When, in seconds.
        time_s: f64,
        /// Over which edge.
        exit: MapExit,
    },
    /// The map of one component was given to the other.
    #[error("map of the {component}: expected one of that kind, found one of kind {}", found.name())]
    MapOfOther {
        /// Whose map it should be.
        component: &'static str,
        /// The kind found.
        found: MapKind,
    },
    /// A dataset could not be built.
    #[error(transparent)]
    Data(#[from] DataError),
}
