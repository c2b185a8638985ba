//! Model and bank files: JSON, written atomically.

use std::path::Path;

use serde::Serialize;
use serde::de::DeserializeOwned;

use crate::source;
use crate::{LogError, write_atomically};

/// Reads a JSON file.
///
/// # Errors
/// A missing file or a directory; [`LogError::Json`] with the line and column that do not fit `T`.
pub fn read_json<T: DeserializeOwned>(path: &Path) -> Result<T, LogError> {
    parse_json(path, &source::read(path)?)
}

/// Reads the bytes of a JSON file, which errors call `path`.
pub(crate) fn parse_json<T: DeserializeOwned>(path: &Path, bytes: &[u8]) -> Result<T, LogError> {
    serde_json::from_slice(bytes).map_err(|cause| {
        let text = cause.to_string();
        let place = format!(" at line {} column {}", cause.line(), cause.column());
        LogError::Json {
            path: path.to_owned(),
            line: cause.line(),
            column: cause.column(),
            cause: text.strip_suffix(&place).unwrap_or(&text).to_owned(),
        }
    })
}

/// Writes a value as indented JSON with a newline at the end, atomically.
///
/// JSON has no NaN and no infinity: they become `null`.
///
/// # Errors
/// [`LogError::NotJson`] when the value has no JSON form, else as [`write_atomically`].
pub fn write_json<T: Serialize + ?Sized>(path: &Path, value: &T) -> Result<(), LogError> {
    let mut bytes = serde_json::to_vec_pretty(value).map_err(|cause| LogError::NotJson {
        path: path.to_owned(),
        cause: cause.to_string(),
    })?;
    bytes.push(b'\n');
    write_atomically(path, &bytes)
}
