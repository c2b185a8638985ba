//! What a file holds that records are watched with.

use std::path::Path;

use gtfdi::fdi::{Bank, Isolator};
use serde::Serialize;

use crate::model_file::parse_json;
use crate::{LogError, source};

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
    /// As [`read_json`](crate::read_json).
    pub fn read(path: &Path) -> Result<Self, LogError> {
        Self::parse(path, &source::read(path)?)
    }

    /// Reads the bytes of a file, which errors call `path`.
    ///
    /// # Errors
    /// [`LogError::Json`] with the line and column.
    pub fn parse(path: &Path, bytes: &[u8]) -> Result<Self, LogError> {
        let document: serde_json::Value = parse_json(path, bytes)?;
        // Once more from the text, so that an error has its line.
        if document.get("fields").is_some() {
            Ok(Self::Isolator(Box::new(parse_json(path, bytes)?)))
        } else {
            Ok(Self::Bank(parse_json(path, bytes)?))
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
