//! The models behind what is in a log, as attachments and as the topic `/ident/model`.

use gt_core::Signal;
use gtfdi::ident::ArxRow;
use serde::Serialize;
use serde_json::json;

use crate::{LogError, LogWriter, ModelFile, ModelKind, sha256_hex};

/// A model with what is known of its errors.
#[derive(Debug, Clone, PartialEq)]
pub struct LoggedModel {
    /// The model.
    pub file: ModelFile,
    /// Of each output one step ahead, in per cent; empty where it is not known.
    pub fit_prediction_percent: Vec<f64>,
    /// Of each output in a free run, in per cent, none where that diverges; empty where it is not
    /// known.
    pub fit_simulation_percent: Vec<Option<f64>>,
}

/// A message of `/ident/model`.
#[derive(Serialize)]
struct ModelEvent<'a> {
    id: &'a str,
    kind: ModelKind,
    inputs: Vec<&'a str>,
    outputs: Vec<&'a str>,
    /// The largest lag of each output's equation.
    orders: Vec<usize>,
    fit_prediction_percent: &'a [f64],
    fit_simulation_percent: &'a [Option<f64>],
    attachment: &'a str,
    sha256: String,
}

fn schema() -> serde_json::Value {
    let texts = json!({"type": "array", "items": {"type": "string"}});
    json!({
        "type": "object",
        "properties": {
            "id": {"type": "string"},
            "kind": {"type": "string"},
            "inputs": texts,
            "outputs": texts,
            "orders": {"type": "array", "items": {"type": "integer", "minimum": 0}},
            "fit_prediction_percent": {"type": "array", "items": {"type": "number"}},
            "fit_simulation_percent": {"type": "array", "items": {"type": ["number", "null"]}},
            "attachment": {"type": "string"},
            "sha256": {"type": "string"}
        }
    })
}

fn names(signals: &[Signal]) -> Vec<&str> {
    signals.iter().map(|own| own.name.as_str()).collect()
}

/// Models that are attached, still to be told on their topic.
pub(crate) struct Attached<'a> {
    models: Vec<(&'a LoggedModel, String, String)>,
}

impl<'a> Attached<'a> {
    /// Attaches models as `models/ID.json`.
    pub(crate) fn new(log: &mut LogWriter, models: &'a [LoggedModel]) -> Result<Self, LogError> {
        let mut attached = Vec::with_capacity(models.len());
        for own in models {
            let name = format!("models/{}.json", own.file.id);
            let bytes =
                serde_json::to_vec_pretty(&own.file).map_err(|cause| LogError::NotJson {
                    path: log.path().to_owned(),
                    cause: cause.to_string(),
                })?;
            log.attach(&name, "application/json", &bytes)?;
            attached.push((own, name, sha256_hex(&bytes)));
        }
        Ok(Self { models: attached })
    }

    /// Writes a message for each model; without any there is no topic.
    pub(crate) fn tell(
        &self,
        log: &mut LogWriter,
        time_ns: u64,
        asset: &str,
    ) -> Result<(), LogError> {
        if self.models.is_empty() {
            return Ok(());
        }
        let topic = log.add_json_topic("/ident/model", "Model", &schema(), asset)?;
        for (own, attachment, sha256) in &self.models {
            let model = &own.file.model;
            let order = |row: &ArxRow| {
                let lags = row.terms.iter().map(|term| term.lag);
                lags.max().unwrap_or(0)
            };
            let event = ModelEvent {
                id: &own.file.id,
                kind: own.file.kind,
                inputs: names(model.inputs()),
                outputs: names(model.outputs()),
                orders: model.rows().iter().map(order).collect(),
                fit_prediction_percent: &own.fit_prediction_percent,
                fit_simulation_percent: &own.fit_simulation_percent,
                attachment,
                sha256: sha256.clone(),
            };
            log.write_json(topic, time_ns, &event)?;
        }
        Ok(())
    }
}
