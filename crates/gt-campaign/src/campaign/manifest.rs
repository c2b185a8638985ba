//! What a folder says of the campaign in it.

use std::path::Path;

use serde::{Deserialize, Serialize};
use toml::{Table, Value};

use super::spec::Spec;
use crate::error::CampaignError;

/// Version of the folder's layout.
const FORMAT: u32 = 2;

/// The file `campaign.toml` of a folder.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Manifest {
    /// Version of the folder's layout.
    pub format: u32,
    /// The version of the program that began it.
    pub version: String,
    /// SHA-256 of the specification as it stands below.
    pub spec_sha256: String,
    /// SHA-256 of the file `bank.json`.
    pub bank_sha256: String,
    /// The specification, every default in it.
    pub spec: Table,
}

impl Manifest {
    /// That of a campaign with a bank.
    ///
    /// # Errors
    /// [`CampaignError::Toml`].
    pub fn new(spec: &Spec, bank_sha256: String) -> Result<Self, CampaignError> {
        let spec = spec.table()?;
        Ok(Self {
            format: FORMAT,
            version: env!("CARGO_PKG_VERSION").to_owned(),
            spec_sha256: gt_log::sha256_hex(toml::to_string(&spec)?.as_bytes()),
            bank_sha256,
            spec,
        })
    }

    /// Reads a folder's manifest.
    ///
    /// # Errors
    /// [`CampaignError::SpecFile`] and [`CampaignError::SpecText`].
    pub fn read(path: &Path) -> Result<Self, CampaignError> {
        let text = std::fs::read_to_string(path).map_err(|source| CampaignError::SpecFile {
            path: path.to_owned(),
            source,
        })?;
        toml::from_str(&text).map_err(|error| CampaignError::SpecText {
            path: path.to_owned(),
            reason: error.to_string().trim_end().to_owned(),
        })
    }

    /// The specification; `path` is where the manifest lies.
    ///
    /// # Errors
    /// [`CampaignError::SpecText`] for one that this version does not write, and
    /// [`CampaignError::Toml`].
    pub fn specification(&self, path: &Path) -> Result<Spec, CampaignError> {
        // By a text, as it is read everywhere else: a second way would compile all of it again. Its
        // lines are not those of the file.
        let text = toml::to_string(&self.spec)?;
        toml::from_str(&text).map_err(|error| CampaignError::SpecText {
            path: path.to_owned(),
            reason: format!("spec: {}", error.message()),
        })
    }

    /// Writes it, whole or not at all.
    ///
    /// # Errors
    /// [`CampaignError::Log`] names the file.
    pub fn write(&self, path: &Path) -> Result<(), CampaignError> {
        let text = toml::to_string(self)?;
        Ok(gt_log::write_atomically(path, text.as_bytes())?)
    }

    /// What a file of rows says of the campaign that it is of.
    pub(super) fn marks(&self) -> Vec<(String, String)> {
        let pairs = [
            ("gtfdi.version", &self.version),
            ("gtfdi.spec_sha256", &self.spec_sha256),
            ("gtfdi.bank_sha256", &self.bank_sha256),
        ];
        let pairs = pairs.map(|(key, value)| (key.to_owned(), value.clone()));
        pairs.into()
    }

    /// The first difference between what is here, of the file `path`, and what is wanted now.
    ///
    /// # Errors
    /// [`CampaignError::Changed`] names the key.
    pub fn check(&self, path: &Path, wanted: &Self) -> Result<(), CampaignError> {
        let changed = |key: &str, expected: String, found: String| {
            Err(CampaignError::Changed {
                path: path.to_owned(),
                key: key.to_owned(),
                expected,
                found,
            })
        };
        if self.format != wanted.format {
            return changed("format", self.format.to_string(), wanted.format.to_string());
        }
        if self.version != wanted.version {
            return changed("version", self.version.clone(), wanted.version.clone());
        }
        if let Some((key, here, now)) = difference("", &self.spec, &wanted.spec) {
            return changed(&key, here, now);
        }
        if self.spec_sha256 != wanted.spec_sha256 {
            let expected = wanted.spec_sha256.clone();
            return changed("spec_sha256", self.spec_sha256.clone(), expected);
        }
        if self.bank_sha256 != wanted.bank_sha256 {
            let expected = wanted.bank_sha256.clone();
            return changed("bank_sha256", self.bank_sha256.clone(), expected);
        }
        Ok(())
    }
}

/// The first key whose values differ, with both.
fn difference(prefix: &str, here: &Table, now: &Table) -> Option<(String, String, String)> {
    let keys = here
        .keys()
        .chain(now.keys().filter(|key| !here.contains_key(*key)));
    for key in keys {
        let path = format!("{prefix}{key}");
        let found = match (here.get(key), now.get(key)) {
            (Some(here), Some(now)) => value_difference(&path, here, now),
            (here, now) => Some((path, text(here), text(now))),
        };
        if found.is_some() {
            return found;
        }
    }
    None
}

fn value_difference(path: &str, here: &Value, now: &Value) -> Option<(String, String, String)> {
    match (here, now) {
        (Value::Table(here), Value::Table(now)) => difference(&format!("{path}."), here, now),
        (Value::Array(first), Value::Array(second)) if first.len() == second.len() => {
            let pairs = first.iter().zip(second).enumerate();
            let mut found = pairs.filter_map(|(place, (here, now))| {
                value_difference(&format!("{path}[{place}]"), here, now)
            });
            found.next()
        }
        _ if here == now => None,
        _ => Some((path.to_owned(), text(Some(here)), text(Some(now)))),
    }
}

fn text(value: Option<&Value>) -> String {
    value.map_or_else(|| "nothing".to_owned(), ToString::to_string)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_first_difference_is_named_with_its_path() {
        let table = |text: &str| toml::from_str::<Table>(text).expect("a table");
        let here = table("a = 1\n[b]\nc = [1.0, 2.0]\n[[f]]\ncase = 'x'");
        let cases = [
            (
                "a = 2\n[b]\nc = [1.0, 2.0]\n[[f]]\ncase = 'x'",
                "a",
                "1",
                "2",
            ),
            (
                "a = 1\n[b]\nc = [1.0, 3.0]\n[[f]]\ncase = 'x'",
                "b.c[1]",
                "2.0",
                "3.0",
            ),
            (
                "a = 1\n[b]\nc = [1.0, 2.0]\n[[f]]\ncase = 'y'",
                "f[0].case",
                "\"x\"",
                "\"y\"",
            ),
            (
                "a = 1\nd = 2\n[b]\nc = [1.0, 2.0]\n[[f]]\ncase = 'x'",
                "d",
                "nothing",
                "2",
            ),
        ];
        for (now, key, expected, found) in cases {
            let difference = difference("", &here, &table(now));
            assert_eq!(
                difference,
                Some((key.into(), expected.into(), found.into()))
            );
        }
        assert_eq!(difference("", &here, &here), None);
    }
}
