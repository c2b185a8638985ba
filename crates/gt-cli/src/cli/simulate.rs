//! The options of `gtfdi simulate`.

use std::path::PathBuf;

use clap::Args;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::{count, integer};
use crate::config::VerbOptions;
use gtfdi::plant::Scenario;

/// `gtfdi simulate`.
#[derive(Debug, Clone, Default, Args, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, rename_all = "kebab-case")]
#[command(after_help = "\
Example: gtfdi simulate --seconds 60 --seed 3 --out run.mcap
         gtfdi simulate --variant cogeneration --profile load_reduction_igv --out run.mcap
         gtfdi simulate --scenario winter.toml --faults faults.toml --out run.mcap

Exit code 1 with a log that is whole but shorter than asked for: the plant left the range in which \
the model means something.")]
pub struct SimulateArgs {
    /// A whole scenario, as the attachment config.toml of every simulated log holds it. Options
    /// beside it replace its fields, the defaults below do not; fields that it leaves out are those
    /// of a healthy run of 600 s of the prototype, without noise, with seed 0
    #[arg(long, env = "GTFDI_SCENARIO", value_name = "FILE.toml")]
    pub scenario: Option<PathBuf>,
    /// The machine: prototype (valve and fuel, speed held by the governor) or cogeneration (on the
    /// mains, fuel sets the load, guide vanes hold the exhaust temperature) [default: prototype]. Another
    /// variant than that of --scenario takes its own standard profile in the place of the file's
    #[arg(long, env = "GTFDI_VARIANT")]
    pub variant: Option<String>,
    /// Component maps: paper (flat, shows the paper's signature) or axial (usual slopes)
    /// [default: paper]
    #[arg(long, env = "GTFDI_MAP_SET")]
    pub map_set: Option<String>,
    /// Table of speed lines in the place of the compressor's map: kind = "compressor" and a
    /// `[[line]]` with speed, `pressure_ratio`, flow and efficiency each
    #[arg(long, env = "GTFDI_COMPRESSOR_MAP", value_name = "FILE.toml")]
    pub compressor_map: Option<PathBuf>,
    /// Table of speed lines in the place of the turbine's map, of kind = "turbine"
    #[arg(long, env = "GTFDI_TURBINE_MAP", value_name = "FILE.toml")]
    pub turbine_map: Option<PathBuf>,
    /// Excitation: steady, gentle, standard, lively or wide; in cogeneration steady, standard,
    /// `load_reduction_igv` or `load_reduction_fuel` [default: standard]
    #[arg(long, env = "GTFDI_PROFILE")]
    pub profile: Option<String>,
    /// Sensor noise: none, low (1 % of each signal's deviation), table8 (the paper's Table 8 as
    /// standard deviations), `table8_variance` (as variances) or `tables4_5` (the accuracies of
    /// Tables 4 and 5 as three standard deviations) [default: low]
    #[arg(long, env = "GTFDI_NOISE")]
    pub noise: Option<String>,
    /// Faults, one `[[fault]]` table each
    #[arg(long, env = "GTFDI_FAULTS", value_name = "FILE.toml")]
    pub faults: Option<PathBuf>,
    /// Length of the run in seconds [default: 60]
    #[arg(
        long,
        env = "GTFDI_SECONDS",
        value_name = "S",
        allow_negative_numbers = true
    )]
    pub seconds: Option<f64>,
    /// Seed of excitation, noise and random faults [default: 1]
    #[arg(long, env = "GTFDI_SEED", value_name = "N", value_parser = integer())]
    pub seed: Option<u64>,
    /// Index of the run under this seed [default: 0]
    #[arg(long, env = "GTFDI_RUN_INDEX", value_name = "N", value_parser = integer())]
    pub run_index: Option<u64>,
    /// RK4 steps a sample of 0.08 s [default: 28]
    #[arg(long, env = "GTFDI_SUBSTEPS", value_name = "N", value_parser = count())]
    pub substeps: Option<usize>,
    /// The log to write
    #[arg(long, env = "GTFDI_OUT", value_name = "FILE.mcap")]
    pub out: Option<PathBuf>,
}

impl VerbOptions for SimulateArgs {
    const BASE_FILE: Option<&'static str> = Some("scenario");

    fn defaults() -> Self {
        Self {
            variant: Some("prototype".into()),
            map_set: Some("paper".into()),
            profile: Some("standard".into()),
            noise: Some("low".into()),
            seconds: Some(60.0),
            seed: Some(1),
            run_index: Some(0),
            substeps: Some(Scenario::default().substeps),
            ..Self::default()
        }
    }
}
