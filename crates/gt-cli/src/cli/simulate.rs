//! The options of `gtfdi simulate`.

use std::path::PathBuf;

use clap::{Args, ValueEnum};
use serde::{Deserialize, Serialize};

use super::{count, integer};
use crate::config::Alternatives;

/// The machine's variants.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Variant {
    /// The monitored prototype: valve angle and fuel, speed held, no power turbine
    Prototype,
}

/// `gtfdi simulate`.
#[derive(Debug, Clone, Default, Args, Serialize, Deserialize)]
#[serde(deny_unknown_fields, rename_all = "kebab-case")]
#[command(after_help = "Example: gtfdi simulate --seconds 60 --seed 3 --out run.mcap")]
pub struct SimulateArgs {
    /// The machine [default: prototype]
    #[arg(long, env = "GTFDI_VARIANT", value_enum)]
    pub variant: Option<Variant>,
    /// Component maps: paper (flat, shows the paper's signature) or axial (usual slopes)
    /// [default: paper]
    #[arg(long, env = "GTFDI_MAP_SET")]
    pub map_set: Option<String>,
    /// Excitation: steady, gentle, standard, lively or wide [default: standard]
    #[arg(long, env = "GTFDI_PROFILE")]
    pub profile: Option<String>,
    /// Sensor noise: none, low (1 % of each signal's deviation) or table8 (the paper's Table 8)
    /// [default: low]
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
    /// Seed of excitation and noise [default: 1]
    #[arg(long, env = "GTFDI_SEED", value_name = "N", value_parser = integer())]
    pub seed: Option<u64>,
    /// Index of the run under this seed [default: 0]
    #[arg(long, env = "GTFDI_RUN_INDEX", value_name = "N", value_parser = integer())]
    pub run_index: Option<u64>,
    /// RK4 steps a sample of 0.08 s [default: 40]
    #[arg(long, env = "GTFDI_SUBSTEPS", value_name = "N", value_parser = count())]
    pub substeps: Option<usize>,
    /// The log to write
    #[arg(long, env = "GTFDI_OUT", value_name = "FILE.mcap")]
    pub out: Option<PathBuf>,
}

impl Alternatives for SimulateArgs {}
