//! The options of `gtfdi design`.

use std::path::PathBuf;

use clap::{Args, ValueEnum};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::{DataArgs, count, integer};
use crate::config::VerbOptions;
use crate::row_range::RowRange;

/// Residual generators.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum GeneratorKind {
    /// Output observers, one an output (eq. 22 of the paper)
    Observer,
    /// Kalman filters, one an output, for the noise of the model (eq. 27 of the paper); of an ARX
    /// model its one-step errors
    Kalman,
}

/// Evaluation statistics.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Statistic {
    /// The residual's modulus against a fixed threshold (eq. 26 of the paper)
    Threshold,
    /// The mean of the whitened residual over a window
    MovingAverage,
    /// The cumulative sum of the whitened residual, for lasting deviations
    Cusum,
    /// The likelihood ratio of the whitened residual, for ramps or steps of unknown onset and size
    Glr,
    /// The sum of squares of the whitened residual over a window
    Chi2,
    /// The Shiryaev-Roberts procedure on the whitened residual, for lasting deviations
    ShiryaevRoberts,
    /// The variance of the whitened residual over a window, too large or too small
    Variance,
    /// The correlations of the whitened residual over a window
    Whiteness,
}

/// Which residuals are tested.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum WatchKind {
    /// Each output's by itself; those that one filter makes (--unknown) together
    Outputs,
    /// All together: the norm of the residuals whitened among themselves
    Joint,
    /// Both
    Both,
}

/// The faults that a likelihood ratio looks for.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum WaveformKind {
    /// A deviation that grows steadily
    Ramp,
    /// A deviation that is there at once
    Step,
}

/// What an observer's poles are chosen by.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum PoleCriterion {
    /// V': the energy of the healthy residuals over that of all that the fault adds to them
    FaultEnergy,
    /// V: the energy of the healthy residual over that of the faulty one, of one pair (eq. 24 of the
    /// paper)
    Paper,
}

/// How an observer's poles are searched for.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum PoleSearchKind {
    /// Descents by sequential quadratic programming from many starts
    Descent,
    /// Differential evolution, for the paper's genetic algorithm
    Evolution,
}

/// `gtfdi design`.
#[derive(Debug, Clone, Default, Args, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, rename_all = "kebab-case")]
#[command(after_help = "\
Example: gtfdi design --model model.json --healthy healthy.mcap --poles 0.7 --margin 1.2 \
--consecutive 6 --out bank.json
         gtfdi design --model model.json --healthy h1.mcap,h2.mcap --generator kalman \
--statistic glr --arl0 24h --out bank.json
         gtfdi design --model model.json --healthy h1.mcap,h2.mcap --faulty f1.mcap \
--validate-faulty f2.mcap --out bank.json
         gtfdi design --model eiv.json --healthy h1.mcap,h2.mcap --generator kalman --arl0 24h \
--faults faults.toml --out isolator.json
         gtfdi design --model eiv.json --healthy h1.mcap,h2.mcap --generator kalman --unknown M_f \
--statistic chi2 --arl0 24h --out without_fuel.json

A file of faults has a table for each, by what one unit of it changes in the outputs at held inputs, \
by the actuator that grows slow, or by pairs of records that show it:

  [[fault]]
  name = \"exhaust thermocouple\"
  unit = \"K\"
  both_signs = true
  changes = { t3 = 1.0 }

  [[fault]]
  name = \"fuel valve\"
  actuator = \"M_f\"

  [[fault]]
  name = \"compressor fouling\"
  unit = \"%\"
  [[fault.pair]]
  healthy = \"clean.mcap\"
  faulty = \"fouled.mcap\"
  course = [[60, 0.0], [120, 2.0]]  # seconds, size

Poles are chosen by pairs of records of the same run without and with a fault, such as simulate \
gives with the same --seed without and with --faults: the records of --faulty pair with the first of \
--healthy in their order, those of --validate-faulty with the ones that follow. All of --healthy set \
the limits.")]
pub struct DesignArgs {
    /// Model file written by identify
    #[arg(long, env = "GTFDI_MODEL", value_name = "MODEL.json")]
    pub model: Option<PathBuf>,
    /// Healthy record; several with commas, or repeat the option
    #[arg(long, env = "GTFDI_HEALTHY", value_name = "LOG", value_delimiter = ',')]
    pub healthy: Option<Vec<PathBuf>>,
    /// How the healthy records are read.
    #[command(flatten)]
    #[serde(flatten)]
    pub reading: DataArgs,
    /// Rows of each record [default: all]
    #[arg(long, env = "GTFDI_ROWS", value_name = "A:B")]
    pub rows: Option<RowRange>,
    /// Residual generator [default: observer]
    #[arg(long, env = "GTFDI_GENERATOR", value_enum)]
    pub generator: Option<GeneratorKind>,
    /// Inputs or outputs that may read anything: one filter whose residuals feel no error of
    /// theirs, tested together, with --generator kalman and an errors-in-variables model; an input
    /// must act at once or one sample later (--nk 0 or 1); several with commas, or repeat the option
    #[arg(long, env = "GTFDI_UNKNOWN", value_name = "TAG", value_delimiter = ',')]
    pub unknown: Option<Vec<String>>,
    /// Observer poles: one for all, one a state, or TAG=POLE for one output, again one or one a state;
    /// complex ones as 0.9+0.1i,0.9-0.1i [default: the paper's for the four outputs it watches (0.7,
    /// 0.3, 0.4, 0.4), 0.5 for any other, equal for all states]
    #[arg(
        long,
        env = "GTFDI_POLES",
        value_delimiter = ',',
        allow_negative_numbers = true
    )]
    pub poles: Option<Vec<String>>,
    /// Choose the observers' poles by this record with a fault and the first of --healthy, the same
    /// run without it; several with commas, or repeat the option, each with the next of --healthy
    #[arg(long, env = "GTFDI_FAULTY", value_name = "LOG", value_delimiter = ',')]
    pub faulty: Option<Vec<PathBuf>>,
    /// Judge the poles found by this record with a fault and the first of --healthy after those that
    /// pair with --faulty; several likewise
    #[arg(
        long,
        env = "GTFDI_VALIDATE_FAULTY",
        value_name = "LOG",
        value_delimiter = ','
    )]
    pub validate_faulty: Option<Vec<PathBuf>>,
    /// What poles are chosen by [default: fault-energy]
    #[arg(long, env = "GTFDI_POLE_CRITERION", value_enum)]
    pub criterion: Option<PoleCriterion>,
    /// How they are searched for [default: descent]
    #[arg(long, env = "GTFDI_SEARCH", value_enum)]
    pub search: Option<PoleSearchKind>,
    /// Largest modulus of the poles searched [default: 0.97]
    #[arg(long, env = "GTFDI_RADIUS", allow_negative_numbers = true)]
    pub radius: Option<f64>,
    /// Samples at the start of each record of the search that do not count, while the observers
    /// forget their initial state [default: 0]
    #[arg(long, env = "GTFDI_SEARCH_SKIP", value_name = "SAMPLES", value_parser = count())]
    pub search_skip: Option<usize>,
    /// Seed of the search [default: 0]
    #[arg(long, env = "GTFDI_SEARCH_SEED", value_name = "N", value_parser = integer())]
    pub search_seed: Option<u64>,
    /// Evaluation statistic [default: threshold]
    #[arg(long, env = "GTFDI_STATISTIC", value_enum)]
    pub statistic: Option<Statistic>,
    /// Which residuals are tested [default: outputs]
    #[arg(long, env = "GTFDI_WATCH", value_enum)]
    pub watch: Option<WatchKind>,
    /// Window in samples, of moving-average and variance [default: 125], chi2 [default: 25],
    /// whiteness [default: 1125], the longest of glr [default: 4096]
    #[arg(long, env = "GTFDI_WINDOW", value_name = "SAMPLES", value_parser = count())]
    pub window: Option<usize>,
    /// Half the deviation that cusum and shiryaev-roberts are to find, in standard deviations
    /// [default: 0.5]
    #[arg(
        long,
        env = "GTFDI_ALLOWANCE",
        value_name = "SIGMAS",
        allow_negative_numbers = true
    )]
    pub allowance: Option<f64>,
    /// The faults that glr looks for [default: ramp]
    #[arg(long, env = "GTFDI_WAVEFORM", value_enum)]
    pub waveform: Option<WaveformKind>,
    /// Sizes of the faults that glr looks for, smallest and largest, in standard deviations (a
    /// sample, of ramps) [default: 1e-4:1e-2 of ramps, 0.1:10 of steps]
    #[arg(
        long,
        env = "GTFDI_SIZES",
        value_name = "A:B",
        allow_hyphen_values = true
    )]
    pub sizes: Option<String>,
    /// Limit by the share of healthy samples above it
    #[arg(
        long,
        env = "GTFDI_EXCEEDANCE",
        value_name = "SHARE",
        allow_negative_numbers = true
    )]
    pub exceedance: Option<f64>,
    /// Limit as a multiple of the largest healthy value [default, for threshold: 1.2]
    #[arg(
        long,
        env = "GTFDI_MARGIN",
        value_name = "FACTOR",
        allow_negative_numbers = true
    )]
    pub margin: Option<f64>,
    /// Limit by the mean time between false alarms of all tests together, such as 24h or 30min
    /// [default, but for threshold: 24h]
    #[arg(
        long,
        env = "GTFDI_ARL0",
        value_name = "TIME",
        allow_hyphen_values = true
    )]
    pub arl0: Option<String>,
    /// Samples in a row above the limit that make an alarm [default: 6 with --exceedance, else 1]
    #[arg(long, env = "GTFDI_CONSECUTIVE", value_name = "N", value_parser = count())]
    pub consecutive: Option<usize>,
    /// Faults to tell apart, a TOML file: writes an isolator, which names faults, instead of a bank;
    /// with an errors-in-variables model and --generator kalman one filter serves all outputs
    #[arg(long, env = "GTFDI_FAULTS", value_name = "FAULTS.toml")]
    pub faults: Option<PathBuf>,
    /// Probability from which on a fault is named [default: 0.99]
    #[arg(
        long,
        env = "GTFDI_CONFIDENCE",
        value_name = "P",
        allow_negative_numbers = true
    )]
    pub confidence: Option<f64>,
    /// How far back the onset of a fault is looked for, such as 10min [default: 600s]
    #[arg(
        long,
        env = "GTFDI_LONGEST",
        value_name = "TIME",
        allow_hyphen_values = true
    )]
    pub longest: Option<String>,
    /// Robust standard deviations beyond which a burst of a residual is cut: lower, to 2.5, where
    /// model errors at movements rule, not noise [default: 4]
    #[arg(
        long,
        env = "GTFDI_LIMITER",
        value_name = "SIGMAS",
        allow_negative_numbers = true
    )]
    pub limiter: Option<f64>,
    /// The bank file to write
    #[arg(long, env = "GTFDI_OUT", value_name = "BANK.json")]
    pub out: Option<PathBuf>,
}

impl VerbOptions for DesignArgs {
    const ALTERNATIVES: &'static [&'static [&'static str]] =
        &[&["exceedance"], &["margin"], &["arl0"]];

    fn defaults() -> Self {
        Self {
            generator: Some(GeneratorKind::Observer),
            statistic: Some(Statistic::Threshold),
            ..Self::default()
        }
    }
}
