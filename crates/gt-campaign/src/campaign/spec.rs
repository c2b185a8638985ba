//! What a campaign is: its file, read and checked.

use std::path::{Path, PathBuf};

use gtfdi::fdi::Waveform;
use gtfdi::plant::{MapSet, NoiseLevel, Scenario};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use toml::Table;

use super::bank_choice::BankChoice;
use super::fault_plan::FaultPlan;
use crate::error::CampaignError;

/// A campaign. In its file every key but `seed`, `runs`, `record` and `faults` may be left out; a
/// key that is not known is refused.
///
/// ```toml
/// seed = 1
/// runs = 1000
/// healthy_share = 0.1                  # of the runs, 0
///
/// [plant]
/// map_set = "paper"                    # or axial
/// profile = "lively"                   # of the prototype: standard
/// valve_amplitude_deg = 1.5            # that of the profile
/// noise = "table8"                     # none
/// noise_record_s = 600.0               # shares of signals are of those in one such record
///
/// [record]
/// duration_s = 180.0
/// onset_s = [60.0, 90.0]               # uniform
/// horizon_s = 60.0                     # an alarm later than this after the onset comes too late
///
/// [[faults]]
/// case = 2                             # 1 to 4, or a name
/// size = { log_uniform = [0.05, 0.5] } # or uniform; percent, seconds in case 4
/// sign = "both"                        # positive
/// shape = { ramp = { rise_s = 30.0 } } # step, exponential, intermittent
///
/// [model]
/// method = "eiv"                       # or arx; by the noise
/// record_s = 600.0
/// order = 2                            # 2 of eiv, 8 of arx
///
/// [bank]                               # or bank = "FILE.json", and no [model]
/// arl0_h = 24.0                        # of all tests together
/// calibration_h = 24.0
/// tests = [{ statistic = "cusum", allowance = 0.5 }]
/// # isolator = true                    # in place of tests: names the fault, its onset and its size
/// ```
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Spec {
    /// Seed of all records and of what is drawn.
    pub seed: u64,
    /// Number of runs; their indices are `0 .. runs`.
    pub runs: u64,
    /// Share of the runs without a fault.
    #[serde(default)]
    pub healthy_share: f64,
    /// What is simulated.
    #[serde(default)]
    pub plant: PlantPlan,
    /// The records.
    pub record: RecordPlan,
    /// The faults, each drawn as often as any other.
    pub faults: Vec<FaultPlan>,
    /// How the plant is identified; not with a bank of a file.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub model: Option<ModelPlan>,
    /// What watches the records.
    #[serde(default)]
    pub bank: BankChoice,
}

/// The plant of a campaign: the prototype.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct PlantPlan {
    /// The maps.
    pub map_set: MapSet,
    /// The operating profile's name.
    pub profile: String,
    /// Amplitude of the valve's levels in degrees, where it is not the profile's.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub valve_amplitude_deg: Option<f64>,
    /// Noise of the sensors, the same in all records: see [`Spec::noise`].
    pub noise: NoiseLevel,
    /// Length of the healthy record by whose signals noise is measured, in seconds.
    pub noise_record_s: f64,
    /// Integration steps a sample.
    pub substeps: usize,
}

impl Default for PlantPlan {
    fn default() -> Self {
        Self {
            map_set: MapSet::default(),
            profile: "standard".to_owned(),
            valve_amplitude_deg: None,
            noise: NoiseLevel::default(),
            noise_record_s: 600.0,
            substeps: Scenario::default().substeps,
        }
    }
}

/// The records of a campaign.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct RecordPlan {
    /// Length of every record in seconds.
    pub duration_s: f64,
    /// Between which times the onset lies, in seconds.
    pub onset_s: [f64; 2],
    /// How long after the onset an alarm counts as a detection, in seconds; to the end of the record
    /// where it is left out.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub horizon_s: Option<f64>,
}

/// How a model is identified.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum ModelMethod {
    /// Errors in variables by maximum likelihood, with Kalman filters for the noise found.
    Eiv,
    /// Least squares, with one-step predictors.
    Arx,
}

/// How the plant is identified.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct ModelPlan {
    /// By which method; errors in variables where the sensors are noisy, else least squares.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub method: Option<ModelMethod>,
    /// Length of the healthy record in seconds, with the noise and the profile of the runs.
    pub record_s: f64,
    /// Order of every output's relation; 2 of errors in variables, 8 of least squares.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub order: Option<usize>,
    /// Tags of the inputs.
    pub inputs: Vec<String>,
    /// Tags of the outputs.
    pub outputs: Vec<String>,
    /// Smallest lag of each input; 0 of errors in variables, 1 but for `M_f` of least squares.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub nk: Option<Vec<usize>>,
}

impl Default for ModelPlan {
    fn default() -> Self {
        let tags = |tags: &[&str]| tags.iter().map(|&tag| tag.to_owned()).collect();
        Self {
            method: None,
            record_s: 600.0,
            order: None,
            inputs: tags(&crate::paper::INPUTS),
            outputs: tags(&["q_c", "t3", "p7", "m9"]),
            nk: None,
        }
    }
}

impl ModelPlan {
    /// The method for records with the given noise.
    pub fn method_for(&self, noise: NoiseLevel) -> ModelMethod {
        self.method.unwrap_or(match noise {
            NoiseLevel::None => ModelMethod::Arx,
            _ => ModelMethod::Eiv,
        })
    }

    /// The order for a method.
    pub fn order_for(&self, method: ModelMethod) -> usize {
        self.order.unwrap_or(match method {
            ModelMethod::Eiv => 2,
            ModelMethod::Arx => crate::paper::ORDER,
        })
    }

    /// The smallest lags for a method: a noisy reading of the valve is that of the moment before, the
    /// demand of the fuel acts within the sample.
    pub fn nk_for(&self, method: ModelMethod) -> Vec<usize> {
        self.nk.clone().unwrap_or_else(|| {
            let inputs = self.inputs.iter();
            inputs
                .map(|tag| usize::from(method == ModelMethod::Arx && tag != "M_f"))
                .collect()
        })
    }
}

/// A statistic with its options, as in a file.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct TestPlanText {
    /// Its name, as on the command line.
    pub statistic: String,
    /// `outputs`, each by itself; `joint`, all together; or `both`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub watch: Option<String>,
    /// Samples of a window.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub window: Option<usize>,
    /// Allowance of a cumulative sum, in standard deviations.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub allowance: Option<f64>,
    /// The fault that a likelihood ratio looks for.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schemars(with = "Option<String>")]
    pub waveform: Option<Waveform>,
    /// Its smallest and largest size.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub sizes: Option<(f64, f64)>,
}

impl Spec {
    /// Reads and checks a campaign's file.
    ///
    /// # Errors
    /// [`CampaignError::SpecFile`] and [`CampaignError::SpecText`] for what cannot be read,
    /// [`CampaignError::Spec`] for a value that makes no sense: all name the file, and the line or
    /// the key.
    pub fn read(path: &Path) -> Result<Self, CampaignError> {
        let text = std::fs::read_to_string(path).map_err(|source| CampaignError::SpecFile {
            path: path.to_owned(),
            source,
        })?;
        let spec: Self = toml::from_str(&text).map_err(|error| CampaignError::SpecText {
            path: path.to_owned(),
            reason: error.to_string().trim_end().to_owned(),
        })?;
        spec.validate().map_err(|problem| CampaignError::Spec {
            path: path.to_owned(),
            problem,
        })?;
        Ok(spec)
    }

    /// The specification as a table with every default in it.
    ///
    /// # Errors
    /// [`CampaignError::Toml`].
    pub fn table(&self) -> Result<Table, CampaignError> {
        Ok(Table::try_from(self)?)
    }

    /// The file of the bank, seen from the folder of the campaign's own file.
    pub fn bank_file(&self, path: &Path) -> Option<PathBuf> {
        let folder = path.parent().unwrap_or(Path::new(""));
        match &self.bank {
            BankChoice::File(file) => Some(folder.join(file)),
            BankChoice::Tests(_) | BankChoice::Isolator(_) => None,
        }
    }

    /// How the plant is identified.
    pub fn model(&self) -> ModelPlan {
        self.model.clone().unwrap_or_default()
    }
}
