//! What one plant goes through, sample by sample: what drives it, what is read, where it ends.

use crate::channels::{ALL_OUTPUTS, INPUTS, Quantity, outputs, recorded_inputs};
use crate::drive::Drive;
use crate::dynamics::Instant;
use crate::faults::{ActuatorPositions, Fault, FaultCourse, FaultSizes, Place};
use crate::inputs::Inputs;
use crate::local_model::longest_step_s;
use crate::maps::Extrapolation;
use crate::scenario::{MOST_SUBSTEPS, Scenario};
use crate::simulate::time_s;
use crate::state::{STATES, State, within};
use crate::trim::{Hold, trim};
use crate::warning::{Remarks, Warning};
use crate::{PlantError, PlantParameters, SAMPLE_TIME_S};

/// Share of the longest stable step at the start that is accepted: the plant moves from there, and
/// with it its fastest mode by a few percent.
pub(crate) const STEP_MARGIN: f64 = 0.96;

/// How much before a sample the sample before it ends, s: more than the tolerance of a fault's
/// onset, too little to matter to a ramp.
const BEFORE_NEXT_SAMPLE_S: f64 = 2e-9;

/// Temperatures outside leave the heat capacity polynomial's range, K.
const TEMPERATURE_RANGE_K: (f64, f64) = (200.0, 1600.0);

/// The true values of a sample.
pub(crate) struct Truth {
    /// Of all inputs; a variant has the first of them.
    pub u: [f64; INPUTS],
    /// Of all outputs.
    pub y: [f64; ALL_OUTPUTS],
}

/// Drives and reads one plant, which is given at each sample; the caller integrates.
#[derive(Debug, Clone)]
pub(crate) struct Operation {
    faults: FaultCourse,
    inputs: Inputs,
    drive: Drive,
    /// Samples read.
    read: usize,
    /// When the last moment of the current sample is, s.
    until_s: f64,
    remarks: Remarks,
}

impl Operation {
    /// The operation of a scenario, with the faults that act on the plant, and the state in which
    /// it starts.
    pub fn start(
        plant: &PlantParameters,
        scenario: &Scenario,
        faults: &[Fault],
    ) -> Result<(Self, [f64; STATES]), PlantError> {
        let drive = Drive::new(
            &scenario.profile,
            &scenario.boundary,
            &scenario.disturbance,
            scenario.seed,
            scenario.run_index,
        );
        let inputs = Inputs::driven(plant, &drive.start());
        let start = trim(plant, &inputs, &FaultSizes::HEALTHY, Hold::Control)?;
        let stable_s = STEP_MARGIN * longest_step_s(plant, &inputs, &start.state)?;
        if scenario.step_s() > stable_s {
            #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss)]
            let least = (SAMPLE_TIME_S / stable_s).ceil() as usize;
            return Err(PlantError::Substeps {
                least,
                most: MOST_SUBSTEPS,
                limit_s: stable_s,
                found: scenario.substeps,
            });
        }
        let operation = Self {
            faults: FaultCourse::new(faults, scenario.seed, scenario.run_index),
            inputs,
            drive,
            read: 0,
            until_s: 0.0,
            remarks: Remarks::default(),
        };
        Ok((operation, start.state.to_array()))
    }

    /// Samples read.
    pub fn read(&self) -> usize {
        self.read
    }

    /// What acts on the plant until the next sample.
    pub fn inputs(&self) -> &Inputs {
        &self.inputs
    }

    /// The faults that act on the plant.
    pub fn faults(&self) -> &FaultCourse {
        &self.faults
    }

    /// Puts other faults in their place, from the next sample on.
    pub fn set_faults(&mut self, faults: FaultCourse) {
        self.faults = faults;
    }

    /// The sizes of the faults at a time of the current sample, as the integrator asks for them.
    ///
    /// The last stage of a step stands at the beginning of the next sample. A fault that begins
    /// there must not act before it: the time is taken a little earlier.
    #[inline]
    pub fn sizes(&self, t_s: f64) -> FaultSizes {
        self.faults.sizes(t_s.min(self.until_s))
    }

    /// The part of [`Self::sizes`] that is to be added, and where.
    #[inline]
    pub fn each_growing(&self, t_s: f64, add: impl FnMut(Place, f64)) {
        self.faults.each_continuous(t_s.min(self.until_s), add);
    }

    /// What a reader of the record should know.
    pub fn warnings(&self) -> Vec<Warning> {
        self.remarks.warnings()
    }

    /// Reads the next sample of `plant` in the state `x`, then moves the inputs.
    ///
    /// # Errors
    /// [`PlantError`] when the plant has left the range in which the model means something: there
    /// are no further samples then.
    pub fn sample(
        &mut self,
        plant: &PlantParameters,
        x: &[f64; STATES],
    ) -> Result<Truth, PlantError> {
        let t = time_s(self.read);
        let x = State::from_array(x);
        if self.faults.is_sampled() {
            // The moment before: the faults as they were, the inputs that were held.
            let before = Instant::at(plant, &self.inputs, &self.sizes(t), &x).actuation;
            self.faults.begin_sample(
                t,
                &ActuatorPositions {
                    fuel_kg_s: before.fuel_kg_s,
                    valve_deg: before.valve_deg,
                    guide_vanes_deg: before.guide_vane_deg,
                },
            );
        }
        self.until_s = t + SAMPLE_TIME_S - BEFORE_NEXT_SAMPLE_S;
        let instant = Instant::at(plant, &self.inputs, &self.faults.sizes(t), &x);
        let y = outputs(plant, &self.inputs, &x, &instant);
        x.check(t)?;
        check_outputs(plant, &y, t)?;
        check_maps(plant, &instant, t)?;
        self.remarks.see(plant, &instant, &x, t);
        self.inputs = Inputs::driven(plant, &self.drive.step());
        let u = recorded_inputs(&self.inputs, instant.fuel_demand_kg_s, &x);
        self.read += 1;
        Ok(Truth { u, y })
    }
}

/// Refuses a point off a table that refuses extrapolation.
fn check_maps(plant: &PlantParameters, instant: &Instant, time_s: f64) -> Result<(), PlantError> {
    let (compression, expansion) = (&instant.point.compression, &instant.point.expansion);
    let compressor = &plant.compressor.map;
    let turbine = &plant.turbine.map;
    let exits = [
        (
            "compressor",
            compressor.extrapolation(),
            compressor.exit(compression.map_speed, compression.map_pressure_ratio),
        ),
        (
            "turbine",
            turbine.extrapolation(),
            turbine.exit(expansion.map_speed, expansion.expansion_ratio),
        ),
    ];
    for (component, extrapolation, exit) in exits {
        if let (Extrapolation::Refuse, Some(exit)) = (extrapolation, exit) {
            return Err(PlantError::OutsideMap {
                component,
                time_s,
                exit,
            });
        }
    }
    Ok(())
}

/// Refuses values that make no sense.
fn check_outputs(
    plant: &PlantParameters,
    values: &[f64; ALL_OUTPUTS],
    time_s: f64,
) -> Result<(), PlantError> {
    for (&found, &(quantity, _, kind)) in values.iter().zip(plant.variant.output_channels()) {
        let (low, high) = match kind {
            Quantity::Temperature => TEMPERATURE_RANGE_K,
            // A generator that takes power from the mains is no nonsense.
            Quantity::Power if quantity == "P_e" => (f64::MIN, f64::MAX),
            // Everything else is positive in forward running; the states bound it from above.
            _ => (0.0, f64::MAX),
        };
        within((quantity, low, high), found, time_s)?;
    }
    Ok(())
}
