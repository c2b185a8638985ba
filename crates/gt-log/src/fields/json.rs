//! Numbers in JSON.

use std::collections::HashSet;

use serde_json::Value;

use super::{ELEMENTS, FIELDS};

/// The way to a number.
pub(crate) type Path = Vec<Step>;

/// A step on the way to a number.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) enum Step {
    Key(String),
    Index(usize),
}

/// The numbers that messages had so far.
#[derive(Debug, Default)]
pub(crate) struct Survey {
    found: Vec<(String, Path)>,
    names: HashSet<String>,
}

impl Survey {
    pub(crate) fn add(&mut self, data: &[u8]) {
        if let Ok(value) = serde_json::from_slice::<Value>(data) {
            self.visit(&value, "", &mut Vec::new());
        }
    }

    fn visit(&mut self, value: &Value, name: &str, path: &mut Path) {
        match value {
            Value::Number(_) | Value::Bool(_) => {
                // A message that is a number has no name for it.
                let name = if name.is_empty() { "value" } else { name };
                if self.names.len() < FIELDS && !self.names.contains(name) {
                    self.names.insert(name.to_owned());
                    self.found.push((name.to_owned(), path.clone()));
                }
            }
            Value::Array(values) => {
                for (index, value) in values.iter().take(ELEMENTS).enumerate() {
                    path.push(Step::Index(index));
                    self.visit(value, &format!("{name}[{index}]"), path);
                    path.pop();
                }
            }
            Value::Object(values) => {
                for (key, value) in values {
                    let inner = if name.is_empty() {
                        key.clone()
                    } else {
                        format!("{name}.{key}")
                    };
                    path.push(Step::Key(key.clone()));
                    self.visit(value, &inner, path);
                    path.pop();
                }
            }
            Value::Null | Value::String(_) => {}
        }
    }

    pub(crate) fn fields(self) -> Vec<(String, Path)> {
        self.found
    }
}

/// The numbers at the ends of `paths`.
pub(crate) fn decode(data: &[u8], paths: &[Path]) -> Result<Vec<Option<f64>>, String> {
    let value: Value = serde_json::from_slice(data).map_err(|cause| cause.to_string())?;
    Ok(paths.iter().map(|path| at(&value, path)).collect())
}

/// The number at the end of a path.
pub(crate) fn at(value: &Value, path: &[Step]) -> Option<f64> {
    let end = path.iter().try_fold(value, |own, step| match step {
        Step::Key(key) => own.get(key),
        Step::Index(index) => own.get(index),
    });
    end.and_then(number)
}

/// A number, a truth value, or one of the names that JSON writers give to what JSON has no number
/// for.
fn number(value: &Value) -> Option<f64> {
    match value {
        Value::Number(own) => own.as_f64(),
        Value::Bool(own) => Some(f64::from(u8::from(*own))),
        Value::String(own) => match own.as_str() {
            "NaN" => Some(f64::NAN),
            "Infinity" => Some(f64::INFINITY),
            "-Infinity" => Some(f64::NEG_INFINITY),
            _ => None,
        },
        _ => None,
    }
}
