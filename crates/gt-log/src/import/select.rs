//! Names and patterns into columns.

use std::path::Path;

use gt_core::Signal;

use super::Selection;
use crate::LogError;

/// The selected columns, by their positions in the file.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) struct Columns {
    pub(crate) inputs: Vec<usize>,
    pub(crate) outputs: Vec<usize>,
}

impl Columns {
    /// Finds the selected columns among `available`. Patterns pass over the column `time`.
    pub(crate) fn resolve(
        path: &Path,
        available: &[Signal],
        time: Option<usize>,
        selection: &Selection,
    ) -> Result<Self, LogError> {
        let side = |wanted: &[String], side: &'static str| {
            let mut found = Vec::new();
            for name in wanted {
                match available.iter().position(|signal| is_named(signal, name)) {
                    Some(index) if found.contains(&index) => {
                        let (path, column) = (path.to_owned(), name.clone());
                        return Err(LogError::SelectedTwice { path, column, side });
                    }
                    Some(index) => found.push(index),
                    None => {
                        for index in matches(path, available, time, name)? {
                            if !found.contains(&index) {
                                found.push(index);
                            }
                        }
                    }
                }
            }
            Ok(found)
        };
        let inputs = side(&selection.inputs, "input")?;
        let outputs = side(&selection.outputs, "output")?;
        if inputs.is_empty() && outputs.is_empty() {
            let (path, available) = (path.to_owned(), names(available));
            return Err(LogError::NothingSelected { path, available });
        }
        if let Some(&both) = inputs.iter().find(|index| outputs.contains(index)) {
            let (path, column) = (path.to_owned(), available[both].name.clone());
            return Err(LogError::InputAndOutput { path, column });
        }
        Ok(Self { inputs, outputs })
    }

    /// The inputs, then the outputs.
    pub(crate) fn all(&self) -> impl Iterator<Item = usize> {
        self.inputs.iter().chain(&self.outputs).copied()
    }
}

/// The tags that are selected, all but the time where none are.
pub(crate) fn chosen_tags(
    path: &Path,
    available: &[Signal],
    time: Option<usize>,
    selection: &Selection,
) -> Result<Vec<usize>, LogError> {
    if selection.inputs.is_empty() && selection.outputs.is_empty() {
        let named = available.iter().enumerate();
        let named = named.filter(|&(index, s)| Some(index) != time && !s.name.is_empty());
        return Ok(named.map(|(index, _)| index).collect());
    }
    let columns = Columns::resolve(path, available, time, selection)?;
    Ok(columns.all().collect())
}

/// The names of the columns that can be selected.
pub(crate) fn names(available: &[Signal]) -> Vec<String> {
    available
        .iter()
        .map(|s| s.name.clone())
        .filter(|name| !name.is_empty())
        .collect()
}

fn is_named(signal: &Signal, name: &str) -> bool {
    !signal.name.is_empty() && signal.name == name
}

fn matches(
    path: &Path,
    available: &[Signal],
    time: Option<usize>,
    pattern: &str,
) -> Result<Vec<usize>, LogError> {
    if !pattern.contains(['*', '?', '[']) {
        let (path, column) = (path.to_owned(), pattern.to_owned());
        return Err(LogError::UnknownColumn {
            path,
            column,
            available: names(available),
        });
    }
    let glob = glob::Pattern::new(pattern).map_err(|cause| LogError::Pattern {
        pattern: pattern.to_owned(),
        cause: cause.msg,
    })?;
    let found: Vec<usize> = available
        .iter()
        .enumerate()
        .filter(|&(index, s)| Some(index) != time && !s.name.is_empty() && glob.matches(&s.name))
        .map(|(index, _)| index)
        .collect();
    if found.is_empty() {
        let (path, pattern) = (path.to_owned(), pattern.to_owned());
        return Err(LogError::NoMatch {
            path,
            pattern,
            available: names(available),
        });
    }
    Ok(found)
}
