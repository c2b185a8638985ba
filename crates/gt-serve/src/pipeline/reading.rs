//! What a source says of one tag.

use super::Quality;

/// A reading of one tag of one machine.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Reading {
    /// The tag's place: inputs of the detector, then its outputs.
    pub tag: usize,
    /// Time of the source in nanoseconds since 1970.
    pub time_ns: i64,
    /// The value, in the unit of the detector's signal.
    pub value: f64,
    /// What the source says of it.
    pub quality: Quality,
}
