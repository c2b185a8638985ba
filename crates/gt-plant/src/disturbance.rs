//! Process disturbances: what acts on the plant and is recorded nowhere.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::PlantError;
use crate::boundary::Fluctuation;

/// The process disturbances of a run, constant over each sample. Left out, there are none.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct Disturbance {
    /// Heat release of the combustor, share of what the fuel gives.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub heat_release_fraction: Option<Fluctuation>,
    /// Torque on the shaft, N m; positive accelerates.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub torque_n_m: Option<Fluctuation>,
}

impl Disturbance {
    /// Whether anything is disturbed.
    pub fn moves(&self) -> bool {
        [self.heat_release_fraction, self.torque_n_m]
            .into_iter()
            .flatten()
            .any(|fluctuation| fluctuation.deviation != 0.0)
    }

    /// Refuses numbers that make no sense: standard deviations above 5 percent of the heat or 500
    /// N m, a sixth of the turbine's torque, and time constants below a sample.
    ///
    /// # Errors
    /// [`PlantError::Scenario`] with the first such number.
    pub fn validate(&self) -> Result<(), PlantError> {
        let time_constant = "a time_constant_s of at least one sample time (0.08 s) and finite";
        for (fluctuation, what, most, deviation) in [
            (
                self.heat_release_fraction,
                "disturbance.heat_release_fraction",
                0.05,
                "a deviation between 0 and 0.05",
            ),
            (
                self.torque_n_m,
                "disturbance.torque_n_m",
                500.0,
                "a deviation between 0 and 500 N m",
            ),
        ] {
            if let Some(fluctuation) = fluctuation {
                fluctuation.validate(what, most, deviation, time_constant)?;
            }
        }
        Ok(())
    }
}
