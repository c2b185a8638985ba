//! A scenario as a file gives it: its profile means something once the variant is known, which may
//! stand before or after it.

use schemars::JsonSchema;
use serde::Deserialize;

use crate::boundary::Boundary;
use crate::disturbance::Disturbance;
use crate::excitation::ProfileChoice;
use crate::faults::Fault;
use crate::maps::Tables;
use crate::params::MapSet;
use crate::scenario::Scenario;
use crate::sensors::Noise;
use crate::{PlantError, Variant};

/// The fields of [`Scenario`] in a file.
#[derive(Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub(crate) struct ScenarioText {
    variant: Variant,
    map_set: MapSet,
    maps: Tables,
    duration_s: f64,
    substeps: usize,
    profile: ProfileChoice,
    boundary: Boundary,
    disturbance: Disturbance,
    noise: Noise,
    #[serde(alias = "fault")]
    faults: Vec<Fault>,
    seed: u64,
    run_index: u64,
}

impl Default for ScenarioText {
    /// The default scenario.
    fn default() -> Self {
        let Scenario {
            variant,
            map_set,
            maps,
            duration_s,
            substeps,
            profile: _,
            boundary,
            disturbance,
            noise,
            faults,
            seed,
            run_index,
        } = Scenario::default();
        Self {
            variant,
            map_set,
            maps,
            duration_s,
            substeps,
            profile: ProfileChoice::default(),
            boundary,
            disturbance,
            noise,
            faults,
            seed,
            run_index,
        }
    }
}

impl TryFrom<ScenarioText> for Scenario {
    type Error = PlantError;

    fn try_from(text: ScenarioText) -> Result<Self, PlantError> {
        Ok(Self {
            variant: text.variant,
            map_set: text.map_set,
            maps: text.maps,
            duration_s: text.duration_s,
            substeps: text.substeps,
            profile: text.profile.resolve(text.variant)?,
            boundary: text.boundary,
            disturbance: text.disturbance,
            noise: text.noise,
            faults: text.faults,
            seed: text.seed,
            run_index: text.run_index,
        })
    }
}
