//! The file of an identified model.

use gtfdi::ident::eiv::{ChannelNoise, EivModel};
use gtfdi::ident::{ArxModel, IdentError};
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
    /// Errors in variables by the Frisch scheme.
    Frisch,
    /// Errors in variables by maximum likelihood.
    Eiv,
}

/// The noise of an errors-in-variables model, in the order of its channels.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ModelNoise {
    /// Of the outputs (ny).
    pub outputs: Vec<ChannelNoise>,
    /// Of the inputs (nu).
    pub inputs: Vec<ChannelNoise>,
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
    /// The model; the relation between the noise-free channels where there is noise beside it.
    pub model: ArxModel,
    /// The noise of an errors-in-variables model.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub noise: Option<ModelNoise>,
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
    noise: Option<ModelNoise>,
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
        let noise_expected = raw.kind != ModelKind::Arx;
        if raw.noise.is_some() != noise_expected {
            let [expected, found] = [noise_expected, !noise_expected].map(|there| {
                if there {
                    "the noise of the channels"
                } else {
                    "none"
                }
            });
            return Err(format!("noise: expected {expected}, found {found}"));
        }
        let expected = id(&raw.model, raw.noise.as_ref()).map_err(|cause| cause.to_string())?;
        if raw.id != expected {
            return Err(format!(
                "id: expected `{expected}`, the digest of the model, found `{}`: the file was \
                 changed after it was written",
                raw.id
            ));
        }
        let file = Self {
            schema_version: raw.schema_version,
            kind: raw.kind,
            id: raw.id,
            input_sha256: raw.input_sha256,
            model: raw.model,
            noise: raw.noise,
        };
        file.eiv().map_err(|cause| cause.to_string())?;
        Ok(file)
    }
}

/// The first digits of the digest of the model's compact JSON, and its noise's where it has one.
fn id(model: &ArxModel, noise: Option<&ModelNoise>) -> Result<String, serde_json::Error> {
    let mut bytes = serde_json::to_vec(model)?;
    if let Some(noise) = noise {
        bytes.extend(serde_json::to_vec(noise)?);
    }
    let mut digest = sha256_hex(&bytes);
    digest.truncate(ID_DIGITS);
    Ok(digest)
}

impl ModelFile {
    /// The file of an ARX model identified from a record with the digest `input_sha256`.
    ///
    /// # Errors
    /// [`LogError::NotJson`] when the model has no JSON form.
    pub fn arx(model: ArxModel, input_sha256: Option<&str>) -> Result<Self, LogError> {
        Self::new(ModelKind::Arx, model, None, input_sha256)
    }

    /// The file of an errors-in-variables model, found by the Frisch scheme or by maximum
    /// likelihood.
    ///
    /// # Errors
    /// As [`ModelFile::arx`].
    pub fn with_noise(
        kind: ModelKind,
        model: &EivModel,
        input_sha256: Option<&str>,
    ) -> Result<Self, LogError> {
        let noise = ModelNoise {
            outputs: model.output_noise().to_vec(),
            inputs: model.input_noise().to_vec(),
        };
        Self::new(kind, model.relation().clone(), Some(noise), input_sha256)
    }

    fn new(
        kind: ModelKind,
        model: ArxModel,
        noise: Option<ModelNoise>,
        input_sha256: Option<&str>,
    ) -> Result<Self, LogError> {
        let id = id(&model, noise.as_ref()).map_err(|cause| LogError::NotJson {
            path: "model".into(),
            cause: cause.to_string(),
        })?;
        Ok(Self {
            schema_version: SCHEMA_VERSION,
            kind,
            id,
            input_sha256: input_sha256.map(str::to_owned),
            model,
            noise,
        })
    }

    /// The errors-in-variables model, where it is one.
    ///
    /// # Errors
    /// As [`EivModel::new`]; a file that was read has been checked.
    pub fn eiv(&self) -> Result<Option<EivModel>, IdentError> {
        let Some(noise) = &self.noise else {
            return Ok(None);
        };
        let (outputs, inputs) = (noise.outputs.clone(), noise.inputs.clone());
        EivModel::new(self.model.clone(), outputs, inputs).map(Some)
    }
}

#[cfg(test)]
mod tests {
    use gtfdi::core::{Dataset, Signal};
    use gtfdi::ident::eiv::{ChannelNoise, EivModel};
    use gtfdi::ident::{Arx, ArxModel, ArxStructure};
    use nalgebra::DMatrix;

    use super::{ModelFile, ModelKind};

    fn model() -> ArxModel {
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
        Arx::new(structure).fit(&data).unwrap()
    }

    fn file() -> serde_json::Value {
        serde_json::to_value(ModelFile::arx(model(), None).unwrap()).unwrap()
    }

    fn noisy_file() -> serde_json::Value {
        let noise = |variance| ChannelNoise {
            variance,
            standard_error: Some(0.5 * variance),
            at_limit: false,
        };
        let model = EivModel::new(model(), vec![noise(0.25)], vec![noise(0.01)]).unwrap();
        let file = ModelFile::with_noise(ModelKind::Eiv, &model, None).unwrap();
        assert_eq!(file.eiv().unwrap(), Some(model));
        serde_json::to_value(file).unwrap()
    }

    fn read(value: &serde_json::Value) -> Result<ModelFile, String> {
        serde_json::from_str(&value.to_string()).map_err(|error| error.to_string())
    }

    #[test]
    fn a_model_comes_back_with_its_id() {
        for value in [file(), noisy_file()] {
            let read = read(&value).unwrap();
            assert_eq!(serde_json::to_value(read).unwrap(), value);
        }
    }

    #[test]
    fn noise_belongs_to_the_models_that_have_it_and_is_checked() {
        let mut without = noisy_file();
        without.as_object_mut().unwrap().remove("noise");
        assert_eq!(
            read(&without).unwrap_err(),
            "noise: expected the noise of the channels, found none"
        );
        let mut with = file();
        with["noise"] = noisy_file()["noise"].clone();
        assert_eq!(
            read(&with).unwrap_err(),
            "noise: expected none, found the noise of the channels"
        );
        let mut changed = noisy_file();
        changed["noise"]["outputs"][0]["variance"] = 0.26.into();
        assert!(read(&changed).unwrap_err().starts_with("id: expected `"));
        let negative = ChannelNoise {
            variance: -1.0,
            standard_error: None,
            at_limit: false,
        };
        let error = EivModel::new(model(), vec![negative], vec![negative]).unwrap_err();
        assert_eq!(
            error.to_string(),
            "noise of `y`, variance: expected a finite number of at least 0, found -1"
        );
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
