//! The numbers of a reproduction, as they go into JSON.

use std::collections::BTreeMap;
use std::fmt;

use gtfdi::fdi::FalseAlarmRate;
use gtfdi::plant::LagLimit;
use serde::Serialize;

pub use super::cogeneration::{Cogeneration, Load, Manoeuvre, Transition};
pub use super::contradictions::Contradiction;
pub use super::effects::{Effects, PaperSignature};
pub use super::limits::{IsolationTable, Table10Row};

/// Version of the JSON object; it rises when a key changes its meaning.
pub const SCHEMA_VERSION: u32 = 1;

/// Everything that `reproduce` computes; keys that are not computed yet are null or empty.
#[derive(Debug, Clone, Serialize)]
pub struct Tables {
    /// Version of this object.
    pub schema_version: u32,
    /// Version of the program.
    pub version: &'static str,
    /// Seed of all runs.
    pub seed: u64,
    /// Sample time in seconds.
    pub sample_time_s: f64,
    /// Table 3: steady state.
    pub table3: Vec<Table3Row>,
    /// What a reader of `table3` must know.
    pub table3_notes: Table3Notes,
    /// What the four faults do to every output, by map set.
    pub fault_effects: BTreeMap<String, Effects>,
    /// The lag of the fuel actuator at which the speed loop loses its stability, by map set; null
    /// where it never does.
    pub lag_limit: BTreeMap<String, Option<LagLimit>>,
    /// The machine of section 3.1 on the mains.
    pub cogeneration: Cogeneration,
    /// Tables 5 and 6: reconstruction errors of the ARX models.
    pub table6: Vec<Table6Row>,
    /// How `table6` is computed.
    pub table6_definition: String,
    /// Table 6 over many seeds, a profile each.
    pub table6_seeds: Vec<Table6Seeds>,
    /// Table 7: reconstruction errors of the errors-in-variables models.
    pub table7: Vec<Table7Row>,
    /// How `table7` is computed.
    pub table7_definition: &'static str,
    /// Table 8: the deviations of the noise that those models find.
    pub table8: Vec<Table8Row>,
    /// How `table8` is computed.
    pub table8_definition: &'static str,
    /// Table 9: signature matrices of the free-run residuals, a map set each.
    pub table9: Vec<Table9>,
    /// The same for the observers with the paper's poles.
    pub table9_observers: Vec<Table9>,
    /// The observers and thresholds of sections 5.3 to 5.6.
    pub observers: Vec<ObserverRow>,
    /// How the thresholds are set.
    pub observers_definition: String,
    /// Detection of the paper's nominal faults by those observers.
    pub detection: Vec<DetectionRow>,
    /// How `detection` is computed.
    pub detection_definition: String,
    /// Table 10: minimal detectable faults.
    pub table10: Vec<Table10Row>,
    /// How often faults are named, with Table 8's noise on the `paper` maps.
    pub isolation: Option<IsolationTable>,
    /// The same for other maps and noise.
    pub isolation_others: Vec<IsolationTable>,
    /// How `table10` and `isolation` are computed.
    pub table10_definition: String,
}

/// A variable of Table 3.
#[derive(Debug, Clone, Serialize)]
pub struct Table3Row {
    /// Its name.
    pub variable: String,
    /// Its unit.
    pub unit: String,
    /// The paper's value.
    pub paper: f64,
    /// The trimmed plant's value.
    pub model: f64,
    /// `100 (model - paper) / paper`.
    pub error_percent: f64,
    /// Where the model's value comes from.
    pub origin: Origin,
}

/// Where the model's value of an entry of Table 3 comes from.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Origin {
    /// A parameter was solved for it: met by construction.
    Calibrated,
    /// A mass flow, changed as little as closes the balances.
    Reconciled,
    /// Not used by the calibration: an independent check.
    Check,
    /// Computed under a definition that was chosen for the number: no check.
    Defined,
}

impl fmt::Display for Origin {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        formatter.pad(match self {
            Self::Calibrated => "calibrated",
            Self::Reconciled => "reconciled",
            Self::Check => "check",
            Self::Defined => "defined",
        })
    }
}

/// What a reader of Table 3 must know.
#[derive(Debug, Clone, Serialize)]
pub struct Table3Notes {
    /// Mean of the absolute errors over all entries, percent.
    pub mean_absolute_error_percent: f64,
    /// The same over the entries that are not met by construction.
    pub mean_absolute_error_not_calibrated_percent: f64,
    /// The error that is largest in modulus, percent.
    pub largest_error_percent: f64,
    /// The entry that has it.
    pub largest_error_variable: String,
    /// What `e_c` means here.
    pub e_c_definition: &'static str,
    /// The compressor map's isentropic efficiency between stations 2 and 3.
    pub map_isentropic_efficiency: f64,
    /// Where the table contradicts itself, and what was done about it.
    pub contradictions: Vec<Contradiction>,
}

/// An output of Table 6: mean square error over the variance of the output.
#[derive(Debug, Clone, Serialize)]
pub struct Table6Row {
    /// The tag.
    pub output: String,
    /// The paper's label.
    pub label: String,
    /// Free run on the identification record; null where it diverges.
    pub identification: Option<f64>,
    /// Free run on the first validation record.
    pub validation1: Option<f64>,
    /// Free run on the second validation record.
    pub validation2: Option<f64>,
    /// One step ahead on the identification record.
    pub identification_prediction: f64,
    /// The paper's bounds: identification, first and second validation.
    pub paper: [f64; 3],
    /// Whether all three free runs are within the paper's bounds.
    pub met: bool,
}

/// Table 6 over many seeds.
#[derive(Debug, Clone, Serialize)]
pub struct Table6Seeds {
    /// The excitation's name.
    pub profile: String,
    /// How far it moves the valve either way, degrees.
    pub valve_amplitude_deg: f64,
    /// The seeds.
    pub seeds: Vec<u64>,
    /// The outputs.
    pub rows: Vec<WorstRow>,
    /// How the rows are computed.
    pub definition: String,
}

/// An output of [`Table6Seeds`]: the largest free-run errors of any seed.
#[derive(Debug, Clone, Serialize)]
pub struct WorstRow {
    /// The tag.
    pub output: String,
    /// The paper's label.
    pub label: String,
    /// On the identification record; null where a free run diverges.
    pub identification: Option<f64>,
    /// On the first validation record.
    pub validation1: Option<f64>,
    /// On the second validation record.
    pub validation2: Option<f64>,
    /// The paper's bounds.
    pub paper: [f64; 3],
    /// Seeds with which all three errors are within the bounds.
    pub met: usize,
}

/// An output of Table 7: the free-run error of its errors-in-variables model over the variance of
/// the output, both without noise.
#[derive(Debug, Clone, Serialize)]
pub struct Table7Row {
    /// `linearised twin` or `non-linear plant`.
    pub plant: &'static str,
    /// Order of the model.
    pub order: usize,
    /// The tag.
    pub output: String,
    /// The paper's label.
    pub label: String,
    /// The paper's J.
    pub paper: f64,
    /// On the record of the fit; null where the free run diverges.
    pub identification: Option<f64>,
    /// On the validation record.
    pub validation: Option<f64>,
    /// On the record of the fit, the worst of the seeds.
    pub worst_identification: Option<f64>,
    /// On the validation record, the worst of the seeds.
    pub worst_validation: Option<f64>,
}

/// A channel of Table 8: standard deviation of its noise over that of its signal.
#[derive(Debug, Clone, Serialize)]
pub struct Table8Row {
    /// `linearised twin` or `non-linear plant`.
    pub plant: &'static str,
    /// The tag.
    pub signal: String,
    /// The paper's label.
    pub label: String,
    /// The paper's number.
    pub paper: f64,
    /// What was put in.
    pub put_in: f64,
    /// What was found.
    pub found: f64,
    /// The estimate's own standard error; null where the record does not tell.
    pub standard_error: Option<f64>,
    /// `100 (found / put_in - 1)`.
    pub error_percent: f64,
    /// The same for the worst of the seeds.
    pub worst_error_percent: f64,
    /// Whether that is within 10 percent.
    pub met: bool,
}

/// A signature matrix.
#[derive(Debug, Clone, Serialize)]
pub struct Table9 {
    /// The plant's maps: `paper` or `axial`.
    pub map_set: String,
    /// Fault cases.
    pub rows: Vec<String>,
    /// Residuals.
    pub columns: Vec<String>,
    /// Graded entries, the largest of a column is 1.
    pub matrix: Vec<Vec<f64>>,
    /// The entries before the columns are normalised, in each output's own unit.
    pub raw: Vec<Vec<f64>>,
    /// The graded entries of combinations of the residuals, one a case, that isolate it.
    pub matrix_isolated: Vec<Vec<f64>>,
    /// Whether every column peaks at its own case.
    pub diagonal: bool,
    /// How the entries are defined.
    pub definition: String,
}

/// An observer of sections 5.3 to 5.6 with its threshold.
#[derive(Debug, Clone, Serialize)]
pub struct ObserverRow {
    /// The watched output.
    pub output: String,
    /// Its unit.
    pub unit: String,
    /// Where all eight poles lie, as in the paper.
    pub pole: f64,
    /// The paper's reconstruction error of the model.
    pub paper_reconstruction_error: Option<f64>,
    /// Free-run error of the model on the identification record.
    pub reconstruction_error: Option<f64>,
    /// The threshold on the residual's modulus, in the output's unit.
    pub limit: f64,
    /// False alarms on healthy records that the limit was not set on.
    pub false_alarms_cross_validated: FalseAlarmRate,
    /// False alarms on one more healthy record.
    pub false_alarms_test: FalseAlarmRate,
}

/// Detection of one nominal fault.
#[derive(Debug, Clone, Serialize)]
pub struct DetectionRow {
    /// 1 to 4.
    pub case: usize,
    /// What fails.
    pub name: String,
    /// Onset in seconds.
    pub onset_s: f64,
    /// Size at the end of the run, in `unit`.
    pub final_size: f64,
    /// `%` or `s`.
    pub unit: String,
    /// The watched outputs' first alarms after the onset, as delays in seconds; null without one.
    pub delays_s: Vec<OutputDelay>,
    /// The output whose residual alarms first.
    pub first: Option<String>,
    /// The output that the paper expects.
    pub expected: String,
}

/// The delay of one residual's first alarm.
#[derive(Debug, Clone, Serialize)]
pub struct OutputDelay {
    /// The tag.
    pub output: String,
    /// Seconds from the onset to the first alarm.
    pub delay_s: Option<f64>,
    /// The fault's size at that moment.
    pub size: Option<f64>,
}
