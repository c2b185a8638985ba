//! The kinds of TOML files that users write.

use std::path::Path;

use clap::ValueEnum;
use gt_campaign::FaultDescriptions;
use gt_campaign::campaign::Spec;
use gt_log::TagMap;
use gt_serve::ServeConfig;
use gtfdi::plant::maps::SpeedLineTable;
use gtfdi::plant::{Scenario, Variant};
use schemars::{Schema, schema_for};
use serde::Serialize;
use serde::de::DeserializeOwned;
use serde_json::Value;
use toml::Table;

use crate::config::{ConfigFile, check_choices};
use crate::scenario::FaultFile;
use crate::toml_text::explained;

/// A kind of TOML file.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum TomlKind {
    /// Options of the verbs, for --config
    Config,
    /// A run of the turbine, for simulate --scenario
    Scenario,
    /// Faults that are simulated, for simulate --faults
    Faults,
    /// Faults that are told apart, for design --faults
    FaultDescriptions,
    /// Speed lines of a compressor or a turbine, for simulate --compressor-map and --turbine-map
    Map,
    /// Names, units and ranges of tags, for --tags
    Tags,
    /// A campaign
    Campaign,
    /// The monitoring service, for serve --config
    Serve,
}

impl TomlKind {
    /// What a file of this kind is called in a sentence.
    pub fn title(self) -> &'static str {
        match self {
            Self::Config => "a configuration file (--config)",
            Self::Scenario => "a scenario (simulate --scenario)",
            Self::Faults => "a file of simulated faults (simulate --faults)",
            Self::FaultDescriptions => "a file of described faults (design --faults)",
            Self::Map => "a table of speed lines (simulate --compressor-map, --turbine-map)",
            Self::Tags => "a map of tags (--tags)",
            Self::Campaign => "a campaign",
            Self::Serve => "a monitoring service (serve --config)",
        }
    }

    /// The JSON Schema of such a file, from the type that reads it.
    pub fn schema(self) -> Schema {
        match self {
            Self::Config => schema_for!(ConfigFile),
            Self::Scenario => schema_for!(Scenario),
            Self::Faults => schema_for!(FaultFile),
            Self::FaultDescriptions => schema_for!(FaultDescriptions),
            Self::Map => schema_for!(SpeedLineTable),
            Self::Tags => schema_for!(TagMap),
            Self::Campaign => schema_for!(Spec),
            Self::Serve => schema_for!(ServeConfig),
        }
    }

    /// The kind whose keys a file has.
    ///
    /// # Errors
    /// No key of any kind at its top, or as many keys of one as of another.
    pub fn recognised(table: &Table) -> Result<Self, String> {
        let names = || table.keys().map(|key| format!("`{key}`"));
        let found = if table.is_empty() {
            "none".to_owned()
        } else {
            names().collect::<Vec<_>>().join(", ")
        };
        let kinds = Self::value_variants();
        let scores = kinds.iter().map(|kind| {
            let schema = kind.schema();
            let root = schema.as_value();
            let tops = branches(root, root);
            let mut known = tops.into_iter().filter_map(properties);
            let is_known = known.any(|own| table.keys().any(|key| own.contains_key(key)));
            is_known.then(|| (score(root, root, &toml::Value::Table(table.clone())), *kind))
        });
        let mut scores: Vec<(i64, Self)> = scores.flatten().collect();
        scores.sort_by_key(|(score, _)| -score);
        match scores[..] {
            [] => {
                let known: Vec<&str> = kinds.iter().map(|kind| kind.title()).collect();
                Err(format!(
                    "expected the keys of {}, found {found}",
                    known.join(", ")
                ))
            }
            [(first, one), (second, other), ..] if first == second => Err(format!(
                "expected a file of one kind, found the keys of {} and of {}: say which with --kind",
                one.title(),
                other.title()
            )),
            [(_, kind), ..] => Ok(kind),
        }
    }

    /// Refuses a file that the verb which reads it would refuse.
    ///
    /// # Errors
    /// The line or the key, what was expected and what was found.
    pub fn check(self, path: &Path, text: &str) -> Result<(), String> {
        let said = |error: &dyn std::fmt::Display| error.to_string();
        match self {
            Self::Config => {
                self.read::<ConfigFile>(text)?;
                check_choices(&self.read(text)?)
            }
            Self::Scenario => {
                let scenario: Scenario = self.read(text)?;
                scenario.validate().map_err(|error| said(&error))
            }
            Self::Faults => {
                let file: FaultFile = self.read(text)?;
                if file.fault.is_empty() {
                    return Err("expected at least one [[fault]] table, found none".to_owned());
                }
                // A fault of the guide vanes is one of cogeneration only.
                let of = |variant| Scenario {
                    faults: file.fault.clone(),
                    ..Scenario::of(variant)
                };
                of(Variant::Prototype)
                    .validate()
                    .or_else(|error| of(Variant::Cogeneration).validate().map_err(|_| error))
                    .map_err(|error| said(&error))
            }
            Self::FaultDescriptions => {
                let file: FaultDescriptions = self.read(text)?;
                file.check().map_err(|error| said(&error))
            }
            Self::Map => self.read::<SpeedLineTable>(text).map(drop),
            Self::Tags => {
                self.read::<Table>(text)?;
                TagMap::read(path).map(drop).map_err(|error| {
                    let text = said(&error);
                    let name = format!("{}: ", path.display());
                    text.strip_prefix(&name).unwrap_or(&text).to_owned()
                })
            }
            Self::Campaign => self
                .read::<Spec>(text)?
                .validate()
                .map_err(|error| said(&error)),
            Self::Serve => self
                .read::<ServeConfig>(text)?
                .check()
                .map_err(|error| said(&error)),
        }
    }

    fn read<T: DeserializeOwned>(self, text: &str) -> Result<T, String> {
        toml::from_str(text).map_err(|error| explained(&error, &self.schema()))
    }
}

/// How many keys of a value a schema knows, less those that it does not.
fn score(root: &Value, schema: &Value, value: &toml::Value) -> i64 {
    match value {
        toml::Value::Table(table) => {
            let own = branches(root, schema);
            let known = |key: &str| {
                own.iter()
                    .find_map(|branch| properties(branch)?.get(key))
                    .or_else(|| own.iter().find_map(|branch| free_values(branch)))
            };
            let scores = table.iter().map(|(key, inner)| match known(key) {
                Some(schema) => 1 + score(root, schema, inner),
                None => -1,
            });
            scores.sum()
        }
        toml::Value::Array(items) => {
            let own = branches(root, schema);
            let Some(of_items) = own.iter().find_map(|branch| branch.get("items")) else {
                return 0;
            };
            items.iter().map(|item| score(root, of_items, item)).sum()
        }
        _ => 0,
    }
}

/// The schema of the values of a table whose keys are free.
fn free_values(schema: &Value) -> Option<&Value> {
    schema
        .get("additionalProperties")
        .filter(|own| own.is_object())
}

fn properties(schema: &Value) -> Option<&serde_json::Map<String, Value>> {
    schema.get("properties")?.as_object()
}

/// The schemas that a schema stands for: itself, what it refers to, its alternatives.
pub fn branches<'a>(root: &'a Value, schema: &'a Value) -> Vec<&'a Value> {
    let mut found = vec![schema];
    if let Some(target) = schema.get("$ref").and_then(Value::as_str)
        && let Some(inner) = root.pointer(target.trim_start_matches('#'))
    {
        found.extend(branches(root, inner));
    }
    for key in ["anyOf", "oneOf", "allOf"] {
        for inner in schema
            .get(key)
            .and_then(Value::as_array)
            .into_iter()
            .flatten()
        {
            found.extend(branches(root, inner));
        }
    }
    found
}
