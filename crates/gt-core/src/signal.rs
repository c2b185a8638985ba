//! A named signal with its unit.

use serde::{Deserialize, Serialize};

use crate::DataError;

/// A measured or computed quantity: its tag and its SI unit.
#[derive(Debug, Clone, PartialEq, Eq, Hash, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Signal {
    /// The tag, unique within a dataset.
    pub name: String,
    /// The unit, in SI symbols (`Pa`, `kg/s`, `K`); empty where unknown or without dimension.
    pub unit: String,
}

impl Signal {
    /// A signal with a unit.
    pub fn new(name: impl Into<String>, unit: impl Into<String>) -> Self {
        Self {
            name: name.into(),
            unit: unit.into(),
        }
    }

    /// Signals without units, one for each name.
    pub fn named<S: AsRef<str>>(names: &[S]) -> Vec<Self> {
        names
            .iter()
            .map(|name| Self::new(name.as_ref(), ""))
            .collect()
    }
}

/// The position of the signal called `name`.
///
/// # Errors
/// [`DataError::UnknownChannel`], with the names there are.
pub fn index_of(signals: &[Signal], name: &str) -> Result<usize, DataError> {
    signals
        .iter()
        .position(|signal| signal.name == name)
        .ok_or_else(|| DataError::UnknownChannel {
            name: name.to_owned(),
            available: signals.iter().map(|signal| signal.name.clone()).collect(),
        })
}
