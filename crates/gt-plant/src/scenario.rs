//! A scenario: everything that determines a run.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::boundary::Boundary;
use crate::channel::Channel;
use crate::disturbance::Disturbance;
use crate::excitation::Profile;
use crate::faults::{ActuatorId, Fault, Target};
use crate::maps::{CompressorMap, Tables, TurbineMap};
use crate::params::MapSet;
use crate::scenario_text::ScenarioText;
use crate::sensors::Noise;
use crate::{PlantError, PlantParameters, SAMPLE_TIME_S, Variant};

/// Most substeps that are accepted.
pub(crate) const MOST_SUBSTEPS: usize = 10_000;
/// Most samples of a record: 44 hours, about 1 GB while it is made. Longer running is several runs
/// under one seed.
const MOST_SAMPLES: usize = 2_000_000;

/// Everything that determines a run. Fields that a file leaves out keep their defaults; the profile
/// is a name or a table of fields, read for the variant of the file.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(try_from = "ScenarioText")]
#[schemars(into = "ScenarioText")]
pub struct Scenario {
    /// Which machine.
    pub variant: Variant,
    /// Which compressor map.
    pub map_set: MapSet,
    /// Tabulated maps in the place of the analytic ones.
    #[serde(skip_serializing_if = "Tables::is_empty")]
    pub maps: Tables,
    /// Length of the record, s; rounded to samples.
    pub duration_s: f64,
    /// Integration steps a sample.
    pub substeps: usize,
    /// Excitation.
    pub profile: Profile,
    /// Ambient conditions and heating value.
    pub boundary: Boundary,
    /// Process disturbances, recorded nowhere.
    pub disturbance: Disturbance,
    /// Sensor noise and resolution.
    pub noise: Noise,
    /// Faults, any number at once.
    pub faults: Vec<Fault>,
    /// Seed of excitation, noise and random faults.
    pub seed: u64,
    /// Index of the run; runs with one seed and different indices are independent.
    pub run_index: u64,
}

impl Default for Scenario {
    /// A healthy, noise-free record of 600 s of the prototype at design conditions, with the
    /// `standard` profile and steps of 2.86 ms: the longest with which every output of every named
    /// profile is within 1e-5 of an adaptive reference, with room for other ambient conditions
    /// (`tests/accuracy.rs`: 1e-6 at the design conditions).
    fn default() -> Self {
        Self {
            variant: Variant::default(),
            map_set: MapSet::default(),
            maps: Tables::default(),
            duration_s: 600.0,
            substeps: 28,
            profile: Profile::default(),
            boundary: Boundary::default(),
            disturbance: Disturbance::default(),
            noise: Noise::default(),
            faults: Vec::new(),
            seed: 0,
            run_index: 0,
        }
    }
}

impl Scenario {
    /// The default scenario of a variant, with its `standard` profile.
    pub fn of(variant: Variant) -> Self {
        Self {
            variant,
            profile: Profile::standard(variant),
            ..Self::default()
        }
    }

    /// The plant of the scenario: its variant with its maps.
    pub fn parameters(&self) -> PlantParameters {
        let mut parameters = PlantParameters::new(self.variant, self.map_set);
        if let Some(table) = &self.maps.compressor {
            parameters.compressor.map = CompressorMap::Table(table.clone());
        }
        if let Some(table) = &self.maps.turbine {
            parameters.turbine.map = TurbineMap::Table(table.clone());
        }
        parameters
    }

    /// Whether the healthy plant moves, by excitation, boundary conditions or disturbances.
    pub fn excites(&self) -> bool {
        self.profile.excites() || self.boundary.moves() || self.disturbance.moves()
    }

    /// Number of samples: the duration over the sample time, rounded.
    ///
    /// # Errors
    /// [`PlantError::Duration`] when that is not between one and two million.
    pub fn samples(&self) -> Result<usize, PlantError> {
        let samples = (self.duration_s / SAMPLE_TIME_S).round();
        if samples >= 1.0 && samples <= MOST_SAMPLES as f64 {
            #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss)]
            return Ok(samples as usize);
        }
        Err(PlantError::Duration {
            shortest_s: SAMPLE_TIME_S,
            longest_s: MOST_SAMPLES as f64 * SAMPLE_TIME_S,
            found_s: self.duration_s,
        })
    }

    /// Length of an integration step, s.
    pub fn step_s(&self) -> f64 {
        SAMPLE_TIME_S / self.substeps as f64
    }

    /// Refuses what cannot be run; whether the step is stable depends on the plant's equilibrium
    /// and is checked when a run starts.
    ///
    /// # Errors
    /// [`PlantError`] with the first offending option.
    pub fn validate(&self) -> Result<(), PlantError> {
        self.validate_with(&self.parameters())
    }

    /// Refuses faults and noise of what the variant does not have.
    fn validate_places(&self) -> Result<(), PlantError> {
        self.validate_places_of(&self.faults)
    }

    /// As [`Self::validate_places`], of other faults.
    pub(crate) fn validate_places_of(&self, faults: &[Fault]) -> Result<(), PlantError> {
        let faulty = faults.iter().filter_map(|fault| match fault.target {
            Target::Sensor { channel, .. } => Some(("sensor of a fault", channel)),
            Target::Actuator {
                actuator: ActuatorId::GuideVanes,
                ..
            } => Channel::named(ActuatorId::GuideVanes.name())
                .ok()
                .map(|channel| ("actuator of a fault", channel)),
            _ => None,
        });
        let noisy = self.noise.channels.keys();
        for (what, channel) in faulty.chain(noisy.map(|channel| ("channel of noise", *channel))) {
            if !channel.is_in(self.variant) {
                return Err(PlantError::NotInVariant {
                    what,
                    variant: self.variant,
                    expected: "a channel of its records",
                    found: channel.to_string(),
                });
            }
        }
        Ok(())
    }

    /// Refuses what cannot be run with given parameters.
    ///
    /// # Errors
    /// [`PlantError`] with the first offending option.
    pub fn validate_with(&self, parameters: &PlantParameters) -> Result<(), PlantError> {
        if parameters.variant != self.variant {
            return Err(PlantError::NotInVariant {
                what: "plant",
                variant: self.variant,
                expected: "the parameters of that variant",
                found: parameters.variant.to_string(),
            });
        }
        self.samples()?;
        if self.substeps == 0 || self.substeps > MOST_SUBSTEPS {
            return Err(PlantError::Substeps {
                least: 1,
                most: MOST_SUBSTEPS,
                limit_s: SAMPLE_TIME_S,
                found: self.substeps,
            });
        }
        self.profile.validate_for(self.variant)?;
        self.boundary
            .validate(&parameters.design, self.duration_s)?;
        self.disturbance.validate()?;
        self.noise.validate()?;
        Fault::validate_each(&self.faults, |fault| fault.validate_by(self.duration_s))?;
        Fault::validate_together(&self.faults)?;
        self.validate_places()
    }
}
