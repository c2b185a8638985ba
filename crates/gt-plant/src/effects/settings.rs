//! How the effects of the faults are measured.

use serde::Serialize;

use super::CASES;
use super::held::{Case, Window};
use crate::drive::Drive;
use crate::faults::{ActuatorFault, FaultSizes};
use crate::inputs::Inputs;
use crate::interval::within;
use crate::local_model::longest_step_s;
use crate::operation::STEP_MARGIN;
use crate::scenario::{MOST_SUBSTEPS, Scenario};
use crate::state::State;
use crate::{PlantError, PlantParameters, Profile, SAMPLE_TIME_S, Variant};

/// How the effects of the faults are measured: reference sizes and excitation.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct EffectSettings {
    /// Case 1: share of the compressor's mass flow that is lost, percent.
    pub flow_loss_percent: f64,
    /// Case 2: error of the reading of t3, percent of the absolute temperature.
    pub drift_percent: f64,
    /// Case 3: share of the turbine's efficiency that is lost, percent.
    pub efficiency_loss_percent: f64,
    /// Case 4: time constant of the fuel actuator's lag, s.
    pub lag_s: f64,
    /// Excitation.
    pub profile: Profile,
    /// Length of the window, s; rounded to samples. A second of it takes 34 kB.
    pub window_s: f64,
    /// What passes between the start of the excitation and the window, s; rounded to samples.
    pub settle_s: f64,
    /// Integration steps a sample.
    pub substeps: usize,
    /// Seed of the excitation.
    pub seed: u64,
    /// Index of the run.
    pub run_index: u64,
}

impl Default for EffectSettings {
    /// 5 % in cases 1 to 3 and a lag of 2 s, with the profile `lively`, over 120 s after 30 s.
    fn default() -> Self {
        let standard = Profile::standard(Variant::Prototype);
        Self {
            flow_loss_percent: 5.0,
            drift_percent: 5.0,
            efficiency_loss_percent: 5.0,
            lag_s: 2.0,
            profile: Profile::named(Variant::Prototype, "lively").unwrap_or(standard),
            window_s: 120.0,
            settle_s: 30.0,
            substeps: 28,
            seed: 0,
            run_index: 0,
        }
    }
}

impl EffectSettings {
    /// What acts on the plant in each case; nothing in case 2.
    pub(super) fn sizes(&self) -> [FaultSizes; CASES] {
        let healthy = FaultSizes::HEALTHY;
        [
            FaultSizes {
                compressor_flow_loss: self.flow_loss_percent / 100.0,
                ..healthy
            },
            healthy,
            FaultSizes {
                turbine_efficiency_loss: self.efficiency_loss_percent / 100.0,
                ..healthy
            },
            FaultSizes {
                fuel: ActuatorFault {
                    lag_s: self.lag_s,
                    ..ActuatorFault::HEALTHY
                },
                ..healthy
            },
        ]
    }

    /// Refuses numbers that make no sense.
    pub(super) fn validate(&self, plant: &PlantParameters) -> Result<(), PlantError> {
        const LARGEST_PERCENT: f64 = 99.0;
        for (what, found) in [
            ("flow_loss_percent", self.flow_loss_percent),
            ("efficiency_loss_percent", self.efficiency_loss_percent),
        ] {
            within(what, found, [0.0, LARGEST_PERCENT], "between 0 and 99")?;
        }
        within(
            "drift_percent",
            self.drift_percent,
            [-LARGEST_PERCENT, LARGEST_PERCENT],
            "between -99 and 99",
        )?;
        let expected = "at least 0 and finite";
        within("lag_s", self.lag_s, [0.0, f64::MAX], expected)?;
        within("settle_s", self.settle_s, [0.0, f64::MAX], expected)?;
        self.scenario(self.window_s).validate_with(plant)?;
        self.scenario(self.window_s + self.settle_s)
            .validate_with(plant)
    }

    fn scenario(&self, duration_s: f64) -> Scenario {
        Scenario {
            duration_s,
            substeps: self.substeps,
            profile: self.profile.clone(),
            seed: self.seed,
            run_index: self.run_index,
            ..Scenario::default()
        }
    }

    /// The inputs of every sample, and which samples count.
    pub(super) fn window(
        &self,
        plant: &PlantParameters,
        cases: &[Case],
    ) -> Result<Window, PlantError> {
        let scenario = self.scenario(self.window_s + self.settle_s);
        let (samples, counted) = (scenario.samples()?, self.scenario(self.window_s).samples()?);
        self.check_step(plant, cases, scenario.step_s())?;
        let mut drive = Drive::new(
            &scenario.profile,
            &scenario.boundary,
            &scenario.disturbance,
            scenario.seed,
            scenario.run_index,
        );
        let start = Inputs::driven(plant, &drive.start());
        let inputs = std::iter::once(start)
            .chain((1..samples).map(|_| Inputs::driven(plant, &drive.step())))
            .collect();
        Ok(Window {
            inputs,
            first: samples.saturating_sub(counted),
            substeps: self.substeps,
            step_s: scenario.step_s(),
        })
    }

    /// Refuses a step at which RK4 is unstable where one of the plants starts.
    fn check_step(
        &self,
        plant: &PlantParameters,
        cases: &[Case],
        step_s: f64,
    ) -> Result<(), PlantError> {
        let inputs = Inputs::design(plant);
        let mut limit_s = f64::INFINITY;
        for start in cases.iter().flat_map(|case| case.start) {
            let stable_s = longest_step_s(plant, &inputs, &State::from_array(&start))?;
            limit_s = limit_s.min(STEP_MARGIN * stable_s);
        }
        if step_s <= limit_s {
            return Ok(());
        }
        #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss)]
        let least = (SAMPLE_TIME_S / limit_s).ceil() as usize;
        Err(PlantError::Substeps {
            least,
            most: MOST_SUBSTEPS,
            limit_s,
            found: self.substeps,
        })
    }
}
