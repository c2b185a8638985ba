//! An output as the argument of a call.

use gtfdi::core::{DataError, Signal, index_of};
use pyo3::prelude::*;

/// An output, by position or name.
#[derive(FromPyObject)]
pub enum OutputKey {
    /// Its position, from 0.
    #[pyo3(annotation = "int")]
    Index(usize),
    /// Its tag.
    #[pyo3(annotation = "str")]
    Name(String),
}

impl OutputKey {
    /// Its position among `outputs`, which a position given is not checked against.
    pub fn index(&self, outputs: &[Signal]) -> Result<usize, DataError> {
        match self {
            Self::Index(index) => Ok(*index),
            Self::Name(name) => index_of(outputs, name),
        }
    }
}
