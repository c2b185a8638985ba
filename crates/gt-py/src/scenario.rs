//! A scenario from what Python gives: a dictionary or a file, and arguments beside it.

use std::fs;
use std::path::PathBuf;

use gtfdi::plant::{Fault, Noise, NoiseLevel, Profile, Scenario, Variant};
use pyo3::prelude::*;
use pyo3::types::{PyBool, PyDict, PyString};
use serde::Deserialize;

use crate::error::Failure;

/// The arguments of ``simulate``; what is `None` is that of the scenario.
pub struct Arguments<'py> {
    pub seconds: Option<f64>,
    pub scenario: Option<Bound<'py, PyAny>>,
    pub variant: Option<&'py str>,
    pub seed: Option<u64>,
    pub run_index: Option<u64>,
    pub profile: Option<&'py str>,
    pub noise: Option<Bound<'py, PyAny>>,
    pub map_set: Option<&'py str>,
    pub faults: Option<Vec<Bound<'py, PyDict>>>,
    pub substeps: Option<usize>,
}

impl Arguments<'_> {
    /// The scenario: the given one or the command line's default, with the other arguments in the
    /// place of its fields.
    pub fn scenario(&self) -> Result<Scenario, Failure> {
        let mut scenario = match &self.scenario {
            Some(given) => read_scenario(given)?,
            None => Scenario {
                duration_s: 60.0,
                noise: NoiseLevel::Low.into(),
                seed: 1,
                ..Scenario::default()
            },
        };
        if let Some(name) = self.variant {
            let variant: Variant = name.parse()?;
            if variant != scenario.variant {
                scenario.variant = variant;
                scenario.profile = Profile::standard(variant);
            }
        }
        if let Some(name) = self.map_set {
            scenario.map_set = name.parse()?;
        }
        if let Some(name) = self.profile {
            scenario.profile = Profile::named(scenario.variant, name)?;
        }
        if let Some(noise) = &self.noise {
            scenario.noise = read_noise(noise)?;
        }
        if let Some(faults) = &self.faults {
            scenario.faults = faults
                .iter()
                .enumerate()
                .map(|(index, fault)| read_fault(index, fault))
                .collect::<Result<_, _>>()?;
        }
        scenario.duration_s = self.seconds.unwrap_or(scenario.duration_s);
        scenario.substeps = self.substeps.unwrap_or(scenario.substeps);
        scenario.seed = self.seed.unwrap_or(scenario.seed);
        scenario.run_index = self.run_index.unwrap_or(scenario.run_index);
        Ok(scenario)
    }
}

/// A dictionary with the keys of a scenario file, or the path of one.
fn read_scenario(given: &Bound<'_, PyAny>) -> Result<Scenario, Failure> {
    if let Ok(fields) = given.cast::<PyDict>() {
        let fields = table("scenario", fields)?;
        return Scenario::deserialize(fields).map_err(|cause| Failure::Scenario { cause });
    }
    let path: PathBuf = given.extract()?;
    let text = match fs::read_to_string(&path) {
        Ok(text) => text,
        Err(cause) => return Err(Failure::Unreadable { path, cause }),
    };
    toml::from_str(&text).map_err(|cause| Failure::ScenarioFile { path, cause })
}

/// A dictionary as a fault.
fn read_fault(index: usize, fault: &Bound<'_, PyDict>) -> Result<Fault, Failure> {
    let fields = table("faults", fault)?;
    Fault::deserialize(fields).map_err(|cause| Failure::Fault { index, cause })
}

/// The name of a level or a dictionary as noise.
fn read_noise(noise: &Bound<'_, PyAny>) -> Result<Noise, Failure> {
    match noise.cast::<PyDict>() {
        Ok(fields) => {
            let fields = table("noise", fields)?;
            Noise::deserialize(fields).map_err(|cause| Failure::Noise { cause })
        }
        Err(_) => Ok(noise.extract::<String>()?.parse()?),
    }
}

/// A dictionary as a table; `None` stands for a key that is left out.
fn table(option: &'static str, fields: &Bound<'_, PyDict>) -> Result<toml::Table, Failure> {
    let mut table = toml::Table::new();
    for (key, field) in fields {
        if !field.is_none() {
            table.insert(key.extract()?, value(option, &field)?);
        }
    }
    Ok(table)
}

/// Text, a number, a dictionary or a sequence (an array too) of these.
fn value(option: &'static str, object: &Bound<'_, PyAny>) -> Result<toml::Value, Failure> {
    if let Ok(text) = object.cast::<PyString>() {
        return Ok(toml::Value::String(text.extract()?));
    }
    if let Ok(flag) = object.cast::<PyBool>() {
        return Ok(toml::Value::Boolean(flag.is_true()));
    }
    if let Ok(fields) = object.cast::<PyDict>() {
        return Ok(toml::Value::Table(table(option, fields)?));
    }
    if object.len().is_ok() {
        let items = object.try_iter()?.map(|item| value(option, &item?));
        return Ok(toml::Value::Array(items.collect::<Result<_, _>>()?));
    }
    if object.hasattr("__index__")? {
        return Ok(toml::Value::Integer(object.extract()?));
    }
    match object.extract() {
        Ok(number) => Ok(toml::Value::Float(number)),
        Err(_) => Err(Failure::Option {
            option,
            expected: "text, numbers, dictionaries and sequences".to_owned(),
            found: object.get_type().name()?.to_string(),
        }),
    }
}
