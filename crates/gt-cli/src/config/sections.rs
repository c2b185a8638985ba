//! The sections of a configuration file: one a verb.

use schemars::{JsonSchema, Schema};
use serde::Deserialize;
use toml::Table;

use super::{VerbOptions, lay_over, to_table};
use crate::cli::{
    CampaignArgs, CheckArgs, DataCheckArgs, DesignArgs, DetectArgs, ExportArgs, IdentifyArgs,
    RecoverArgs, ReproduceArgs, SimulateArgs,
};
use crate::failure::Failure;

/// What is known of a verb's section.
pub struct Section {
    /// Its name: the words of the verb with a hyphen between them.
    pub name: &'static str,
    /// The options that are in force where nobody gives them.
    pub defaults: fn() -> Result<Table, Failure>,
    /// The schema of the options.
    pub schema: fn() -> Schema,
    /// The key of a file with values of its own, as in [`VerbOptions::BASE_FILE`].
    pub base_file: Option<&'static str>,
    /// Refuses two options of which the verb takes one.
    check: fn(Table) -> Result<(), String>,
}

macro_rules! sections {
    ($($field:ident, $name:literal: $options:ty;)*) => {
        /// A configuration file. It is read into this only to be checked, so that mistakes are
        /// reported with their line, in whichever section they are.
        #[derive(Deserialize, JsonSchema)]
        #[serde(deny_unknown_fields)]
        #[expect(dead_code, reason = "checked, not used")]
        pub struct ConfigFile {
            $(
                /// Options of the verb.
                #[serde(rename = $name)]
                $field: Option<$options>,
            )*
        }

        /// All sections, in the order of the work.
        pub const SECTIONS: &[Section] = &[$(
            Section {
                name: $name,
                defaults: || to_table(&<$options>::defaults()),
                schema: || schemars::schema_for!($options),
                base_file: <$options>::BASE_FILE,
                check: |table| lay_over::<$options>(&mut Table::new(), table),
            },
        )*];
    };
}

sections! {
    simulate, "simulate": SimulateArgs;
    data_check, "data-check": DataCheckArgs;
    identify, "identify": IdentifyArgs;
    model_check, "model-check": CheckArgs;
    design, "design": DesignArgs;
    detect, "detect": DetectArgs;
    reproduce, "reproduce": ReproduceArgs;
    campaign, "campaign": CampaignArgs;
    log_recover, "log-recover": RecoverArgs;
    log_export, "log-export": ExportArgs;
}

/// Refuses, in a file that is otherwise sound, two options of which a verb takes one.
///
/// # Errors
/// The section and what was found there.
pub fn check_choices(whole: &Table) -> Result<(), String> {
    for section in SECTIONS {
        if let Some(table) = whole.get(section.name).and_then(toml::Value::as_table) {
            (section.check)(table.clone())
                .map_err(|error| format!("[{}]: {error}", section.name))?;
        }
    }
    Ok(())
}
