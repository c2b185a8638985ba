//! Everything of a run but the integration: what drives it, what is read, where it ends.

use nalgebra::DMatrix;

use crate::channels::{ALL_OUTPUTS, Quantity, outputs, recorded_inputs};
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

/// The true inputs (nu x N) and all outputs (34 x N) of a run.
pub(crate) struct Path {
    pub u: DMatrix<f64>,
    pub y: DMatrix<f64>,
    pub warnings: Vec<Warning>,
    pub ended: Option<PlantError>,
}

/// Drives and records one plant; the caller integrates.
pub(crate) struct Recorder<'a> {
    plant: &'a PlantParameters,
    faults: FaultCourse,
    inputs: Inputs,
    drive: Drive,
    /// Samples read.
    read: usize,
    /// When the last moment of the current sample is, s.
    until_s: f64,
    u: DMatrix<f64>,
    y: DMatrix<f64>,
    remarks: Remarks,
    ended: Option<PlantError>,
}

impl<'a> Recorder<'a> {
    /// The recorder of a scenario, with the faults that act on the plant, and the state in which
    /// it starts.
    pub fn start(
        plant: &'a PlantParameters,
        scenario: &Scenario,
        faults: &[Fault],
    ) -> Result<(Self, [f64; STATES]), PlantError> {
        let n = scenario.samples()?;
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
        let recorder = Self {
            plant,
            faults: FaultCourse::new(faults, scenario.seed, scenario.run_index),
            inputs,
            drive,
            read: 0,
            until_s: 0.0,
            u: DMatrix::zeros(plant.variant.input_channels().len(), n),
            y: DMatrix::zeros(ALL_OUTPUTS, n),
            remarks: Remarks::default(),
            ended: None,
        };
        Ok((recorder, start.state.to_array()))
    }

    /// What acts on the plant until the next sample.
    pub fn inputs(&self) -> &Inputs {
        &self.inputs
    }

    /// The sizes of the faults at a time of the current sample, as the integrator asks for them.
    ///
    /// The last stage of a step stands at the beginning of the next sample. A fault that begins
    /// there must not act before it: the time is taken a little earlier.
    #[inline]
    pub fn sizes(&self, t_s: f64) -> FaultSizes {
        self.faults.sizes(t_s.min(self.until_s))
    }

    /// The part of [`Self::sizes`] that holds until the next sample.
    pub fn held_sizes(&self) -> &FaultSizes {
        self.faults.held()
    }

    /// The other part of [`Self::sizes`]: what is to be added where.
    #[inline]
    pub fn each_growing(&self, t_s: f64, add: impl FnMut(Place, f64)) {
        self.faults.each_continuous(t_s.min(self.until_s), add);
    }

    /// Whether any fault acts on the plant.
    pub fn is_faulty(&self) -> bool {
        !self.faults.is_healthy()
    }

    /// Samples that the scenario asks for.
    pub fn samples(&self) -> usize {
        self.y.ncols()
    }

    /// Whether samples are still to be read.
    pub fn is_running(&self) -> bool {
        self.ended.is_none() && self.read < self.y.ncols()
    }

    /// Reads a sample in the state `x`, then moves the inputs; false when the run is over.
    pub fn sample(&mut self, x: &[f64; STATES]) -> bool {
        let k = self.read;
        let t = time_s(k);
        let x = State::from_array(x);
        if self.faults.is_sampled() {
            // The moment before: the faults as they were, the inputs that were held.
            let before = Instant::at(self.plant, &self.inputs, &self.sizes(t), &x).actuation;
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
        let instant = Instant::at(self.plant, &self.inputs, &self.faults.sizes(t), &x);
        let values = outputs(self.plant, &self.inputs, &x, &instant);
        let valid = x
            .check(t)
            .and_then(|()| self.check(&values, t))
            .and_then(|()| self.check_maps(&instant, t));
        if let Err(reason) = valid {
            self.ended = Some(reason);
            return false;
        }
        self.remarks.see(self.plant, &instant, &x, t);
        self.y.column_mut(k).copy_from_slice(&values);
        self.inputs = Inputs::driven(self.plant, &self.drive.step());
        let recorded = recorded_inputs(&self.inputs, instant.fuel_demand_kg_s, &x);
        let rows = self.u.nrows();
        self.u.column_mut(k).copy_from_slice(&recorded[..rows]);
        self.read += 1;
        self.is_running()
    }

    /// The record.
    pub fn finish(self) -> Path {
        let n = self.read;
        Path {
            u: self.u.resize_horizontally(n, 0.0),
            y: self.y.resize_horizontally(n, 0.0),
            warnings: self.remarks.warnings(),
            ended: self.ended,
        }
    }

    /// Refuses a point off a table that refuses extrapolation.
    fn check_maps(&self, instant: &Instant, time_s: f64) -> Result<(), PlantError> {
        let (compression, expansion) = (&instant.point.compression, &instant.point.expansion);
        let compressor = &self.plant.compressor.map;
        let turbine = &self.plant.turbine.map;
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

    fn check(&self, values: &[f64; ALL_OUTPUTS], time_s: f64) -> Result<(), PlantError> {
        for (&found, &(quantity, _, kind)) in
            values.iter().zip(self.plant.variant.output_channels())
        {
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
}
