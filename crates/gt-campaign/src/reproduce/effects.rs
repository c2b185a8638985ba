//! What the four faults do to every output: the sensitivity matrices behind Tables 2 and 9.

use std::fmt::Write as _;

use gtfdi::core::Signal;
use gtfdi::plant::effects::{CASES, MONITORED, Reading, Signature};
use gtfdi::plant::{EffectSettings, FaultEffects, MapSet, PlantParameters};
use serde::Serialize;

use crate::error::{CampaignError, During as _};
use crate::parallel;

/// Run indices of the excitation; case 4's effect depends on it, so several are taken.
pub const RUN_INDICES: [u64; 5] = [40, 41, 42, 43, 44];
/// Column of case 4.
const LAG_CASE: usize = 3;

/// The effects of the four cases on the 28 outputs, on one map set.
#[derive(Debug, Clone, Serialize)]
pub struct Effects {
    /// How they are defined.
    pub definition: String,
    /// Sizes, profile, window, seed; the run index is that of the first run.
    pub settings: EffectSettings,
    /// The runs that the root mean squares are taken over.
    pub run_indices: Vec<u64>,
    /// Names and units of the outputs: the rows of every matrix.
    pub outputs: Vec<Signal>,
    /// The healthy steady outputs, each in its unit.
    pub steady: Vec<f64>,
    /// The faulty closed loop against the healthy one.
    pub raw: Reading,
    /// The faulty plant against the healthy plant at the same valve angle and demanded fuel.
    pub inputs_held: Reading,
    /// Case 4 against the healthy plant at the same valve angle and delivered fuel: root mean
    /// square, percent.
    pub delivered_fuel_rms_percent: Vec<f64>,
    /// Lowest and highest root mean square of case 4 among the single runs, raw, percent.
    pub case4_raw_range_percent: Vec<[f64; 2]>,
    /// The same with inputs held.
    pub case4_inputs_held_range_percent: Vec<[f64; 2]>,
    /// The signature in the root mean squares of `raw`.
    pub signature_raw: PaperSignature,
    /// The signature in the root mean squares of `inputs_held`.
    pub signature_inputs_held: PaperSignature,
}

/// A signature over the monitored outputs, and whether it is the paper's.
#[derive(Debug, Clone, Serialize)]
pub struct PaperSignature {
    /// The signature; the rows of its shares are the outputs, the columns the cases.
    #[serde(flatten)]
    pub signature: Signature,
    /// Whether every monitored output is moved most by its own case.
    pub diagonal: bool,
}

/// Measures the effects on the prototype with one map set.
pub fn measure(map_set: MapSet, seed: u64) -> Result<Effects, CampaignError> {
    let what = format!("fault effects, {map_set} maps");
    let plant = PlantParameters::for_maps(map_set);
    let runs = parallel::map(&RUN_INDICES, |&run_index| {
        let settings = EffectSettings {
            seed,
            run_index,
            ..EffectSettings::default()
        };
        FaultEffects::measure(&plant, &settings).during(&what)
    })?;
    let first = &runs[0];
    let raw = pooled(&runs, |effects| &effects.raw);
    let inputs_held = pooled(&runs, |effects| &effects.inputs_held);
    let paper_signature = |reading: &Reading| {
        let signature = first.signature(&reading.rms_percent);
        PaperSignature {
            diagonal: signature.is_diagonal(),
            signature,
        }
    };
    let outputs = 0..first.outputs.len();
    let range = |reading: fn(&FaultEffects) -> &Reading| {
        outputs
            .clone()
            .map(|output| {
                let values = runs
                    .iter()
                    .map(|run| reading(run).rms_percent[(output, LAG_CASE)]);
                values.fold([f64::INFINITY, 0.0], |[low, high], value| {
                    [value.min(low), value.max(high)]
                })
            })
            .collect()
    };
    Ok(Effects {
        definition: definition(&first.settings),
        signature_raw: paper_signature(&raw),
        signature_inputs_held: paper_signature(&inputs_held),
        case4_raw_range_percent: range(|effects| &effects.raw),
        case4_inputs_held_range_percent: range(|effects| &effects.inputs_held),
        delivered_fuel_rms_percent: outputs
            .map(|output| {
                root_mean_square(
                    runs.iter()
                        .map(|run| run.delivered_fuel_rms_percent[output]),
                )
            })
            .collect(),
        raw,
        inputs_held,
        run_indices: RUN_INDICES.to_vec(),
        settings: first.settings.clone(),
        outputs: first.outputs.clone(),
        steady: first.steady.clone(),
    })
}

/// The reading over all runs: windows of one length, so their mean squares have one weight.
fn pooled(runs: &[FaultEffects], reading: fn(&FaultEffects) -> &Reading) -> Reading {
    let mut all = reading(&runs[0]).clone();
    for output in 0..all.rms_percent.nrows() {
        for case in 0..CASES {
            all.rms_percent[(output, case)] = root_mean_square(
                runs.iter()
                    .map(|run| reading(run).rms_percent[(output, case)]),
            );
        }
    }
    all
}

fn root_mean_square(values: impl ExactSizeIterator<Item = f64>) -> f64 {
    let count = values.len() as f64;
    (values.map(|value| value * value).sum::<f64>() / count).sqrt()
}

fn definition(settings: &EffectSettings) -> String {
    let EffectSettings {
        flow_loss_percent,
        drift_percent,
        efficiency_loss_percent,
        lag_s,
        profile,
        window_s,
        settle_s,
        seed,
        ..
    } = settings;
    let runs = RUN_INDICES.len();
    let (first, last) = (RUN_INDICES[0], RUN_INDICES[runs - 1]);
    format!(
        "Percent of the healthy steady value. Sizes: {flow_loss_percent} % of the compressor's \
         flow (case 1), {drift_percent} % of the reading of t3 (case 2), {efficiency_loss_percent} \
         % of the turbine's efficiency (case 3), {lag_s} s of lag of the fuel actuator (case 4), \
         present in full from the start. Settled: difference of the equilibria at the design \
         inputs, with its sign; a lag moves none. rms: root mean square of the difference over \
         {runs} windows of {window_s} s, each after {settle_s} s, noise-free, valve within +-{} \
         deg, speed reference within +-{} %, dither of the fuel {} %; seed {seed}, run indices \
         {first} to {last}. Raw: faulty closed loop against healthy closed loop. Inputs held: \
         against the healthy plant that gets the faulty one's valve angle and demanded fuel, so \
         what the best of residuals shows. Single runs: lowest and highest rms of case \
         4 among them, because it depends on the excitation.",
        profile.valve_amplitude_deg,
        100.0 * profile.speed_amplitude_fraction,
        100.0 * profile.dither_fraction,
    )
}

impl Effects {
    /// Row of an output.
    pub(super) fn row(&self, output: &str) -> Option<usize> {
        self.outputs.iter().position(|signal| signal.name == output)
    }

    /// The largest effect that is left of case 4 where delivered fuel is the input, percent.
    pub(super) fn largest_delivered_percent(&self) -> f64 {
        self.delivered_fuel_rms_percent
            .iter()
            .copied()
            .fold(0.0, f64::max)
    }

    /// All numbers, a line an output.
    pub(super) fn csv(&self) -> String {
        let mut text = String::from("output,unit,steady");
        for reading in ["raw", "inputs_held"] {
            for case in 1..=CASES {
                let _ = write!(text, ",{reading}_settled_percent_case{case}");
            }
            for case in 1..=CASES {
                let _ = write!(text, ",{reading}_rms_percent_case{case}");
            }
            let _ = write!(
                text,
                ",{reading}_rms_percent_case4_low,{reading}_rms_percent_case4_high"
            );
        }
        text.push_str(",delivered_fuel_rms_percent_case4\n");
        for (row, (output, steady)) in self.outputs.iter().zip(&self.steady).enumerate() {
            let _ = write!(text, "{},{},{steady}", output.name, output.unit);
            for (reading, range) in [
                (&self.raw, &self.case4_raw_range_percent),
                (&self.inputs_held, &self.case4_inputs_held_range_percent),
            ] {
                for matrix in [&reading.static_percent, &reading.rms_percent] {
                    for value in matrix.row(row).iter() {
                        let _ = write!(text, ",{value}");
                    }
                }
                let _ = write!(text, ",{},{}", range[row][0], range[row][1]);
            }
            let _ = writeln!(text, ",{}", self.delivered_fuel_rms_percent[row]);
        }
        text
    }

    /// Cells of the table of one reading: settled effects of cases 1 to 3, then all four rms.
    pub(super) fn cells(&self, reading: &Reading, range: &[[f64; 2]]) -> Vec<Vec<String>> {
        let outputs = self.outputs.iter().enumerate();
        outputs
            .map(|(row, output)| {
                let settled = reading.static_percent.row(row);
                let rms = reading.rms_percent.row(row);
                let [low, high] = range[row];
                let mut cells = vec![output.name.clone()];
                cells.extend(settled.iter().take(LAG_CASE).map(|value| signed(*value)));
                cells.extend(rms.iter().map(|value| format!("{value:.2}")));
                cells.push(format!("{low:.2} to {high:.2}"));
                cells
            })
            .collect()
    }

    /// The rms of the monitored outputs in one reading: a row a case, a column an output.
    pub(super) fn monitored_cells(
        &self,
        reading: &Reading,
        signature: &Signature,
    ) -> Vec<Vec<String>> {
        (0..CASES)
            .map(|case| {
                let mut cells = vec![format!("case {}", case + 1)];
                for (column, output) in MONITORED.iter().enumerate() {
                    let row = self.row(output);
                    let percent = row.map_or(f64::NAN, |row| reading.rms_percent[(row, case)]);
                    let share = signature.share[(column, case)];
                    cells.push(format!("{percent:.2} ({share:.2})"));
                }
                cells.push(signature.most_affected[case].unwrap_or("-").to_owned());
                cells
            })
            .collect()
    }
}

/// A percentage with its sign, where a rounded zero has none.
fn signed(value: f64) -> String {
    let rounded = (100.0 * value).round() / 100.0;
    if rounded == 0.0 {
        "0.00".to_owned()
    } else {
        format!("{rounded:+.2}")
    }
}
