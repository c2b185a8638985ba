//! `gtfdi config schema`: what may stand in a file, for editors.

use crate::Outcome;
use crate::failure::Failure;
use crate::output::print;
use crate::toml_kind::TomlKind;

/// Prints a JSON Schema.
pub fn schema(kind: TomlKind) -> Result<Outcome, Failure> {
    let mut text = serde_json::to_string_pretty(&kind.schema()).map_err(Failure::failed)?;
    text.push('\n');
    print(&text)?;
    Ok(Outcome::Done)
}
