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
///
/// Deserialisation checks the version and that the id is that of the model.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(try_from = "Unchecked")]
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

/// The fields of a [`ModelFile`] as they come from a file.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Unchecked {
    schema_version: u32,
    kind: ModelKind,
    id: String,
    input_sha256: Option<String>,
    model: ArxModel,
}

impl TryFrom<Unchecked> for ModelFile {
    type Error = String;

    fn try_from(raw: Unchecked) -> Result<Self, String> {
        if raw.schema_version != SCHEMA_VERSION {
            let found = raw.schema_version;
            return Err(format!(
                "schema_version: expected {SCHEMA_VERSION}, found {found}"
            ));
        }
        let expected = id(&raw.model).map_err(|cause| cause.to_string())?;
        if raw.id != expected {
            return Err(format!(
                "id: expected `{expected}`, the digest of the model, found `{}`: the file was \
                 changed after it was written",
                raw.id
            ));
        }
        Ok(Self {
            schema_version: raw.schema_version,
            kind: raw.kind,
            id: raw.id,
            input_sha256: raw.input_sha256,
            model: raw.model,
        })
    }
}

/// The first digits of the digest of the model's compact JSON.
fn id(model: &ArxModel) -> Result<String, serde_json::Error> {
    let mut digest = sha256_hex(&serde_json::to_vec(model)?);
    digest.truncate(ID_DIGITS);
    Ok(digest)
}

impl ModelFile {
    /// The file of an ARX model identified from a record with the digest `input_sha256`.
    ///
    /// # Errors
    /// [`LogError::NotJson`] when the model has no JSON form.
    pub fn arx(model: ArxModel, input_sha256: Option<&str>) -> Result<Self, LogError> {
        let id = id(&model).map_err(|cause| LogError::NotJson {
            path: "model".into(),
            cause: cause.to_string(),
        })?;
        Ok(Self {
            schema_version: SCHEMA_VERSION,
            kind: ModelKind::Arx,
            id,
            input_sha256: input_sha256.map(str::to_owned),
            model,
        })
    }
}

#[cfg(test)]
mod tests {
    use gtfdi::core::{Dataset, Signal};
    use gtfdi::ident::{Arx, ArxStructure};
    use nalgebra::DMatrix;

    use super::ModelFile;

    fn file() -> serde_json::Value {
        let u = DMatrix::from_fn(1, 50, |_, t| f64::from(u8::from(t % 7 < 3)));
        let mut y = DMatrix::zeros(1, 50);
        for t in 1..50 {
            y[(0, t)] = 0.3 * y[(0, t - 1)] + u[(0, t - 1)];
        }
        let (inputs, outputs) = (Signal::named(&["u"]), Signal::named(&["y"]));
        let data = Dataset::new(inputs, outputs, u, y, 0.1).unwrap();
        let structure = ArxStructure::Diagonal {
            na: 1,
            nb: vec![1],
            nk: vec![1],
        };
        let model = Arx::new(structure).fit(&data).unwrap();
        serde_json::to_value(ModelFile::arx(model, None).unwrap()).unwrap()
    }

    fn read(value: &serde_json::Value) -> Result<ModelFile, String> {
        serde_json::from_str(&value.to_string()).map_err(|error| error.to_string())
    }

    #[test]
    fn a_model_comes_back_with_its_id() {
        let value = file();
        let read = read(&value).unwrap();
        assert_eq!(serde_json::to_value(read).unwrap(), value);
    }

    #[test]
    fn another_version_and_a_changed_coefficient_are_refused() {
        let mut newer = file();
        newer["schema_version"] = 2.into();
        assert!(
            read(&newer)
                .unwrap_err()
                .starts_with("schema_version: expected 1, found 2")
        );
        let mut changed = file();
        changed["model"]["rows"][0]["terms"][0]["coefficient"] = 0.31.into();
        assert!(read(&changed).unwrap_err().starts_with("id: expected `"));
    }
}
