//! What the paper's four faults do to the outputs, in percent, in two readings: as the sensors show
//! it, and as the ideal residual that knows the healthy plant's answer to the same inputs.

mod held;
mod lag_limit;
mod settings;
mod signature;

use gt_core::Signal;
use nalgebra::DMatrix;
use serde::{Serialize, Serializer};

use crate::channels::{ALL_OUTPUTS, signals};
use crate::inputs::Inputs;
use crate::state::State;
use crate::trim::{Hold, SteadyState, steady_state, trim};
use crate::{FaultSizes, PlantError, PlantParameters, Variant};

pub use lag_limit::{LagLimit, lag_limit};
pub use settings::EffectSettings;
pub use signature::{MONITORED, Signature};

use held::{Case, records};

/// The fault cases of the paper: columns of every matrix of effects.
pub const CASES: usize = 4;
/// Column of case 2, whose plant is the healthy one: the fault sits in the sensor.
const SENSOR_CASE: usize = 1;
/// Column of case 4.
const LAG_CASE: usize = 3;

/// The effects of the four cases in one reading (28 x 4: outputs, cases), in percent of the steady
/// value of the healthy output that the faulty one is compared with.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Reading {
    /// Once everything has settled at the design inputs, with its sign. Zero in case 4.
    #[serde(serialize_with = "rows")]
    pub static_percent: DMatrix<f64>,
    /// Root mean square over the window of the excited run.
    #[serde(serialize_with = "rows")]
    pub rms_percent: DMatrix<f64>,
}

/// The effects of the paper's four fault cases on the 28 outputs of the prototype.
///
/// Each fault is there in full from the beginning of the run, which starts from the faulty
/// equilibrium, so that the window sees the excitation alone and no onset. Valve, speed reference
/// and dither are the same in all runs.
///
/// Two plants are healthy *shadows* of the faulty one: they get its valve angle and, in the place of
/// their own governors', its fuel, *demanded* or *delivered*, at every stage of the integration.
/// What remains of a fault with inputs held is what a residual can show at best, however good its
/// model: with demanded fuel as input case 4 shows, with delivered fuel it does not.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct FaultEffects {
    /// How it was measured.
    pub settings: EffectSettings,
    /// Names and units of the outputs (28): the rows.
    pub outputs: Vec<Signal>,
    /// The healthy steady outputs (28), each in its unit.
    pub steady: Vec<f64>,
    /// The faulty closed loop against the healthy closed loop: raw outputs.
    pub raw: Reading,
    /// The faulty plant against the healthy plant at the same valve angle and the same demanded
    /// fuel: the ideal residual.
    pub inputs_held: Reading,
    /// Case 4 against the healthy plant at the same valve angle and the same *delivered* fuel:
    /// root mean square (28), percent. Nothing but rounding.
    pub delivered_fuel_rms_percent: Vec<f64>,
}

impl FaultEffects {
    /// Measures the effects on a prototype.
    ///
    /// # Errors
    /// [`PlantError::NotInVariant`] for another machine, [`PlantError::Parameter`],
    /// [`PlantError::Scenario`], [`PlantError::Duration`] and [`PlantError::Substeps`] for
    /// impossible parameters or settings, [`PlantError::Trim`] where a faulty plant has no
    /// equilibrium, [`PlantError::OutOfRange`] where one leaves the model's range of validity.
    pub fn measure(plant: &PlantParameters, settings: &EffectSettings) -> Result<Self, PlantError> {
        prototype_only(plant, "fault effects")?;
        settings.validate(plant)?;
        let healthy = steady_state(plant)?;
        let sizes = settings.sizes();
        let equilibria = sizes
            .iter()
            .map(|faults| Equilibria::of(plant, &healthy, faults))
            .collect::<Result<Vec<_>, _>>()?;
        let cases: Vec<Case> = equilibria.iter().map(Equilibria::case).collect();
        let records = records(plant, &cases, &settings.window(plant, &cases)?)?;

        let channels = plant.variant.output_channels();
        let ny = channels.len();
        let drift = 1.0 + settings.drift_percent / 100.0;
        let t3 = channels.iter().position(|channel| channel.0 == "t3");
        let faulty = |case: usize, settled, reference| Comparison {
            faulty_settled: &equilibria[case].faulty.outputs,
            faulty: records[case].faulty(),
            settled,
            reference,
            sensor: t3.filter(|_| case == SENSOR_CASE).map(|row| (row, drift)),
        };
        let raw = |case| faulty(case, &healthy.outputs, records[SENSOR_CASE].faulty());
        let shadow = |case: usize| &equilibria[case].shadow.outputs;
        let held = |case: usize| faulty(case, shadow(case), records[case].at_demanded_fuel());
        let delivered = records[LAG_CASE].at_delivered_fuel();
        let delivered = faulty(LAG_CASE, shadow(LAG_CASE), delivered);
        Ok(Self {
            settings: settings.clone(),
            outputs: signals(channels),
            steady: healthy.outputs[..ny].to_vec(),
            raw: Reading::of(ny, raw),
            inputs_held: Reading::of(ny, held),
            delivered_fuel_rms_percent: (0..ny)
                .map(|output| delivered.rms_percent(output))
                .collect(),
        })
    }

    /// The row of an output, by name.
    pub fn row(&self, output: &str) -> Option<usize> {
        self.outputs.iter().position(|signal| signal.name == output)
    }

    /// The signature of the four cases in the four monitored outputs, from one of the matrices of
    /// effects (28 x 4); what a smaller matrix lacks counts as no effect.
    pub fn signature(&self, percent: &DMatrix<f64>) -> Signature {
        Signature::of(&self.outputs, percent)
    }
}

impl Reading {
    fn of<'a>(ny: usize, case: impl Fn(usize) -> Comparison<'a>) -> Self {
        let matrix = |effect: fn(&Comparison<'a>, usize) -> f64| {
            DMatrix::from_fn(ny, CASES, |output, column| effect(&case(column), output))
        };
        Self {
            static_percent: matrix(Comparison::static_percent),
            rms_percent: matrix(Comparison::rms_percent),
        }
    }
}

/// A faulty plant against a healthy one: settled outputs, and records (28 x N).
struct Comparison<'a> {
    faulty_settled: &'a [f64; ALL_OUTPUTS],
    faulty: &'a DMatrix<f64>,
    settled: &'a [f64; ALL_OUTPUTS],
    reference: &'a DMatrix<f64>,
    /// Row of a faulty sensor, and by what its reading is multiplied.
    sensor: Option<(usize, f64)>,
}

impl Comparison<'_> {
    fn gain(&self, output: usize) -> f64 {
        match self.sensor {
            Some((row, gain)) if row == output => gain,
            _ => 1.0,
        }
    }

    fn static_percent(&self, output: usize) -> f64 {
        let (reading, steady) = (
            self.faulty_settled[output] * self.gain(output),
            self.settled[output],
        );
        100.0 * (reading - steady) / steady
    }

    fn rms_percent(&self, output: usize) -> f64 {
        let effect = self.faulty.row(output) * self.gain(output) - self.reference.row(output);
        let mean_square = effect.norm_squared() / effect.len() as f64;
        100.0 * mean_square.sqrt() / self.settled[output]
    }
}

/// A faulty plant and its healthy shadow, each where it settles.
struct Equilibria {
    faults: FaultSizes,
    faulty: SteadyState,
    shadow: SteadyState,
}

impl Equilibria {
    fn of(
        plant: &PlantParameters,
        healthy: &SteadyState,
        faults: &FaultSizes,
    ) -> Result<Self, PlantError> {
        let inputs = Inputs::design(plant);
        let faulty = trim(plant, &inputs, faults, Hold::Control)?;
        let shadow = if faulty.point == healthy.point {
            // The same fuel: to the last bit, so that no fault gives no effect at all.
            healthy.clone()
        } else {
            let kg_s = faulty.point.fuel_kg_s;
            trim(plant, &inputs, &FaultSizes::HEALTHY, Hold::Fuel { kg_s })?
        };
        Ok(Self {
            faults: *faults,
            faulty,
            shadow,
        })
    }

    fn case(&self) -> Case {
        let (faulty, shadow) = (self.faulty.state, self.shadow.state);
        Case {
            faults: self.faults,
            start: [faulty, shadow, shadow].map(State::to_array),
        }
    }
}

/// Refuses the variant whose fuel no governor sets.
fn prototype_only(plant: &PlantParameters, what: &'static str) -> Result<(), PlantError> {
    match plant.variant {
        Variant::Prototype => Ok(()),
        variant @ Variant::Cogeneration => Err(PlantError::NotInVariant {
            what,
            variant,
            expected: "nothing, as no governor closes a loop over the fuel",
            found: "a request".to_owned(),
        }),
    }
}

/// A matrix as a list of its rows.
fn rows<S: Serializer>(matrix: &DMatrix<f64>, serializer: S) -> Result<S::Ok, S::Error> {
    serializer.collect_seq(
        matrix
            .row_iter()
            .map(|row| row.iter().copied().collect::<Vec<_>>()),
    )
}
