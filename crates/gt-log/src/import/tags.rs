//! A map from the tags of a plant to the signals of a record.

use std::borrow::Cow;
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use gt_core::Signal;
use schemars::{JsonSchema, Schema, SchemaGenerator};
use serde::Deserialize;

use super::ReadingError;
use super::select::names;
use super::units::{Dimension, KNOWN, Unit};
use crate::LogError;

/// What the tags of a file are called, and how their readings become those of a record.
///
/// ```toml
/// [tags."10FT1234.PV"]
/// name = "fuel_flow"  # [default: the tag]
/// unit = "kg/h"       # the file's unit [default: that of the file's row of units]
/// to = "kg/s"         # the record's unit
/// low = 0.0           # readings outside, in the file's unit, are missing
/// high = 9000.0
///
/// [tags."10TT0001.PV"]
/// scale = 0.1         # in place of `to`: reading times scale plus offset
/// offset = -40.0
/// unit = "degC"       # then the unit of the result
/// ```
#[derive(Debug, Clone, Default, PartialEq)]
pub struct TagMap {
    path: PathBuf,
    tags: BTreeMap<String, Rule>,
}

#[derive(Debug, Clone, Default, PartialEq, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
struct Rule {
    /// The signal's name; that of the tag where it is left out.
    name: Option<String>,
    /// The file's unit.
    unit: Option<String>,
    /// The record's unit.
    to: Option<String>,
    /// In place of `to`: what a reading is multiplied with.
    scale: Option<f64>,
    /// In place of `to`: what is added after that.
    offset: Option<f64>,
    /// Readings below, in the file's unit, are missing.
    low: Option<f64>,
    /// Readings above, in the file's unit, are missing.
    high: Option<f64>,
}

#[derive(Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
struct File {
    /// What becomes of each tag.
    tags: BTreeMap<String, Rule>,
}

/// What becomes of the readings of a tag.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Conversion {
    change: Change,
    low: f64,
    high: f64,
}

#[derive(Debug, Clone, Copy, PartialEq)]
enum Change {
    None,
    Unit(Unit, Unit),
    Line(f64, f64),
}

impl Conversion {
    /// Readings as they are.
    pub(crate) const NONE: Self = Self {
        change: Change::None,
        low: f64::NEG_INFINITY,
        high: f64::INFINITY,
    };

    /// The reading in the record's unit; nothing where it is out of range.
    pub(crate) fn of(&self, value: f64) -> Option<f64> {
        if value < self.low || value > self.high {
            return None;
        }
        Some(match &self.change {
            Change::None => value,
            Change::Unit(from, to) => from.convert(value, to),
            Change::Line(scale, offset) => value * scale + offset,
        })
    }
}

impl JsonSchema for TagMap {
    fn schema_name() -> Cow<'static, str> {
        "TagMap".into()
    }

    /// That of the file.
    fn json_schema(generator: &mut SchemaGenerator) -> Schema {
        File::json_schema(generator)
    }
}

impl TagMap {
    /// Reads a file of tags.
    ///
    /// # Errors
    /// [`LogError`] for a file that cannot be read, is no TOML, or has a rule that cannot be
    /// followed.
    pub fn read(path: &Path) -> Result<Self, LogError> {
        let text = String::from_utf8_lossy(&crate::source::read(path)?).into_owned();
        let File { tags } = toml::from_str(&text).map_err(|cause| {
            let cause = cause.to_string().trim_end().to_owned();
            LogError::reading(path, ReadingError::TagFile { cause })
        })?;
        let map = Self {
            path: path.to_owned(),
            tags,
        };
        map.check()?;
        Ok(map)
    }

    fn check(&self) -> Result<(), LogError> {
        let mut seen = BTreeMap::new();
        for (tag, rule) in &self.tags {
            let name = rule.name.as_ref().unwrap_or(tag);
            if let Some(other) = seen.insert(name, tag) {
                return Err(self.refused(
                    tag,
                    format!("expected a name of its own, found `{name}`, as for `{other}`"),
                ));
            }
            let numbers = [rule.scale, rule.offset, rule.low, rule.high];
            if let Some(found) = numbers.into_iter().flatten().find(|n| !n.is_finite()) {
                return Err(self.refused(tag, format!("expected finite numbers, found {found}")));
            }
            if rule.scale == Some(0.0) {
                return Err(self.refused(tag, "scale: expected another number than 0".to_owned()));
            }
            if rule.to.is_some() && (rule.scale.is_some() || rule.offset.is_some()) {
                let found = "expected to, or scale and offset, found both".to_owned();
                return Err(self.refused(tag, found));
            }
            if let (Some(low), Some(high)) = (rule.low, rule.high)
                && low >= high
            {
                let found = format!("expected low < high, found {low} and {high}");
                return Err(self.refused(tag, found));
            }
            if name.is_empty() {
                return Err(self.refused(tag, "name: expected some text, found none".to_owned()));
            }
        }
        Ok(())
    }

    fn refused(&self, tag: &str, found: String) -> LogError {
        let tag = tag.to_owned();
        LogError::reading(&self.path, ReadingError::TagRule { tag, found })
    }

    /// Gives the signals of a file their names and units, and says what becomes of the readings of
    /// each.
    pub(super) fn apply(
        &self,
        path: &Path,
        signals: &mut [Signal],
    ) -> Result<Vec<Conversion>, LogError> {
        let available = names(signals);
        let mut conversions = vec![Conversion::NONE; signals.len()];
        for (tag, rule) in &self.tags {
            let index = available.iter().any(|name| name == tag);
            let index = index
                .then(|| signals.iter().position(|s| s.name == *tag))
                .flatten();
            let Some(index) = index else {
                let near = near(tag, &available).join(", ");
                let found = format!(
                    "expected a tag of {}, found none of that name; near are {near}",
                    path.display()
                );
                return Err(self.refused(tag, found));
            };
            conversions[index] = self.conversion(tag, rule, &mut signals[index])?;
        }
        // All tags are found by their own names before any is given another.
        let old: Vec<String> = signals.iter().map(|signal| signal.name.clone()).collect();
        for (signal, old) in signals.iter_mut().zip(&old) {
            if let Some(name) = self.tags.get(old).and_then(|rule| rule.name.clone()) {
                signal.name = name;
            }
        }
        for (index, signal) in signals.iter().enumerate() {
            let twin = signals[..index]
                .iter()
                .position(|other| other.name == signal.name);
            if let Some(twin) = twin.filter(|_| !signal.name.is_empty()) {
                let renamed = if self.tags.contains_key(&old[index]) {
                    index
                } else {
                    twin
                };
                let found = format!(
                    "expected a name that no other tag of {} has, found `{}`",
                    path.display(),
                    signal.name
                );
                return Err(self.refused(&old[renamed], found));
            }
        }
        Ok(conversions)
    }

    fn conversion(
        &self,
        tag: &str,
        rule: &Rule,
        signal: &mut Signal,
    ) -> Result<Conversion, LogError> {
        let given = rule.unit.clone().unwrap_or_else(|| signal.unit.clone());
        let change = match (&rule.to, rule.scale, rule.offset) {
            (Some(to), ..) => {
                let (from, into) = (self.unit(tag, "unit", &given)?, self.unit(tag, "to", to)?);
                let gauge = [from, into]
                    .iter()
                    .any(|u| u.dimension == Dimension::GaugePressure);
                if from.dimension != into.dimension || gauge {
                    return Err(
                        self.refused(tag, unlike((given.as_str(), from), (to.as_str(), into)))
                    );
                }
                Change::Unit(from, into)
            }
            (None, None, None) => Change::None,
            (None, scale, offset) => Change::Line(scale.unwrap_or(1.0), offset.unwrap_or(0.0)),
        };
        signal.unit = rule.to.clone().unwrap_or(given);
        Ok(Conversion {
            change,
            low: rule.low.unwrap_or(f64::NEG_INFINITY),
            high: rule.high.unwrap_or(f64::INFINITY),
        })
    }

    fn unit(&self, tag: &str, key: &str, name: &str) -> Result<Unit, LogError> {
        Unit::of(name).ok_or_else(|| {
            let found = format!("{key}: expected a unit that is known ({KNOWN}), found `{name}`");
            self.refused(tag, found)
        })
    }
}

/// Why one unit does not become the other.
fn unlike((given, from): (&str, Unit), (to, into): (&str, Unit)) -> String {
    let gauge = |unit: Unit| unit.dimension == Dimension::GaugePressure;
    if gauge(from) || gauge(into) {
        return format!(
            "expected absolute pressures, found `{given}` to `{to}`: the ambient pressure is not \
             known; keep the unit, or give scale and offset"
        );
    }
    format!(
        "expected units of one kind, found `{given}` ({}) and `{to}` ({})",
        from.dimension.name(),
        into.dimension.name()
    )
}

/// The names that are nearest to one, nearest first.
fn near(name: &str, available: &[String]) -> Vec<String> {
    let distance =
        |other: &&String| strsim::levenshtein(&name.to_lowercase(), &other.to_lowercase());
    let mut sorted: Vec<&String> = available.iter().collect();
    sorted.sort_by_key(distance);
    sorted.into_iter().take(3).cloned().collect()
}
