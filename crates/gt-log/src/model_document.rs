//! The file of an identified model.

use gtfdi::ident::ArxModel;
use serde::{Deserialize, Serialize};

use crate::{LogError, sha256_hex};

/// Version of the model file; it rises when a key changes its meaning.
const SCHEMA_VERSION: u32 = 1;
/// Hexadecimal digits of the model's digest that make its id.
const ID_DIGITS: usize = 12;

/// How the model was identified.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum ModelKind {
    /// Equation-error least squares.
    Arx,
}

/// A model with what is needed to trust it: its own id and the digest of the record behind it.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ModelFile {
    /// Version of this file's format.
    pub schema_version: u32,
    /// How the model was identified.
    pub kind: ModelKind,
    /// The first digits of the SHA-256 digest of the model's JSON: equal models, equal ids.
    pub id: String,
    /// SHA-256 digest of the record, where that was a file.
    pub input_sha256: Option<String>,
    /// The model.
    pub model: ArxModel,
}

impl ModelFile {
    /// The file of an ARX model identified from a record with the digest `input_sha256`.
    ///
    /// # Errors
    /// [`LogError::NotJson`] when the model has no JSON form.
    pub fn arx(model: ArxModel, input_sha256: Option<&str>) -> Result<Self, LogError> {
        let bytes = serde_json::to_vec(&model).map_err(|cause| LogError::NotJson {
            path: "model".into(),
            cause: cause.to_string(),
        })?;
        let mut id = sha256_hex(&bytes);
        id.truncate(ID_DIGITS);
        Ok(Self {
            schema_version: SCHEMA_VERSION,
            kind: ModelKind::Arx,
            id,
            input_sha256: input_sha256.map(str::to_owned),
            model,
        })
    }
}
