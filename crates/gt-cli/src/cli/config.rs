//! The options of `gtfdi config`.

use std::path::PathBuf;

use clap::Subcommand;
use clap::builder::PossibleValuesParser;

use crate::config::SECTIONS;
use crate::toml_kind::TomlKind;

/// Verbs on the files that users write.
#[derive(Debug, Subcommand)]
pub enum ConfigCommand {
    /// Print a configuration file with every option of a verb, at its default
    ///
    /// Example: gtfdi config init design --out design.toml
    Init {
        /// The verbs, their words with a hyphen between them [default: all]
        #[arg(value_name = "VERB", value_parser = verbs())]
        verbs: Vec<String>,
        /// The file to write, which is not there yet; without it the text is printed
        #[arg(long, value_name = "FILE.toml")]
        out: Option<PathBuf>,
    },
    /// Say whether a TOML file is sound, and what is wrong with it
    ///
    /// Its kind is recognised by its keys. Exit codes: 0 sound; 2 not.
    ///
    /// Example: gtfdi config check design.toml
    Check {
        /// The file
        #[arg(value_name = "FILE.toml")]
        file: PathBuf,
        /// What the file is to be [default: recognised]
        #[arg(long, value_enum)]
        kind: Option<TomlKind>,
    },
    /// Print the JSON Schema of a kind of TOML file
    ///
    /// Editors that know the schema complete and check as one types.
    ///
    /// Example: gtfdi config schema campaign > campaign.schema.json
    Schema {
        /// The kind
        #[arg(value_enum, default_value = "config")]
        kind: TomlKind,
    },
}

/// Reads the name of a verb's section.
fn verbs() -> PossibleValuesParser {
    SECTIONS.iter().map(|section| section.name).into()
}
