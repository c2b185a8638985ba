//! What a file holds that records are watched with.

use std::path::Path;

use gtfdi::fdi::{Bank, Isolator};
use serde::Serialize;

use crate::{LogError, read_json};

/// A bank or an isolator, as `gtfdi design` writes them. In JSON it is the one or the other.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[serde(untagged)]
pub enum DetectorFile {
    /// Tests with their limits.
    Bank(Bank),
    /// Hypotheses of faults with their limits.
    Isolator(Box<Isolator>),
}

impl DetectorFile {
    /// Reads a file, and tells by what is in it which of the two it is.
    ///
    /// # Errors
    /// As [`read_json`].
    pub fn read(path: &Path) -> Result<Self, LogError> {
        let document: serde_json::Value = read_json(path)?;
        // Once more from the text, so that an error has its line.
        if document.get("fields").is_some() {
            Ok(Self::Isolator(Box::new(read_json(path)?)))
        } else {
            Ok(Self::Bank(read_json(path)?))
        }
    }

    /// Tags of the inputs.
    pub fn inputs(&self) -> Vec<String> {
        match self {
            Self::Bank(bank) => bank.inputs(),
            Self::Isolator(isolator) => isolator.inputs(),
        }
    }

    /// Tags of the outputs.
    pub fn outputs(&self) -> Vec<String> {
        match self {
            Self::Bank(bank) => bank.outputs(),
            Self::Isolator(isolator) => isolator.outputs(),
        }
    }

    /// The sample time in seconds.
    pub fn sample_time_s(&self) -> f64 {
        match self {
            Self::Bank(bank) => bank.sample_time_s(),
            Self::Isolator(isolator) => isolator.sample_time_s(),
        }
    }
}
